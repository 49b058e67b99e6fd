#include "optimize/validity.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/topology.hpp"

#include <algorithm>
#include <numbers>

namespace strake {
namespace {

constexpr double smallest_share = 1e-3;
constexpr double foldable_below = 120 * std::numbers::pi / 180, folded_above = 170 * std::numbers::pi / 180;

double smallest_height(const Points& v, const Eigen::RowVector3i& t, double area) {
    double longest = 0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, (v.row(t[(k + 1) % 3]) - v.row(t[k])).norm());
    return longest > 0 ? 2 * area / longest : 0;
}

/// Counts what is wrong and remembers the first.
struct Finding {
    std::string name;
    int first = -1, count = 0;
    void add(int at) {
        if (count++ == 0) first = at;
    }
};

/// All pairs of triangles that intersect elsewhere than at what they share, ascending.
std::vector<std::array<int, 2>> intersecting_pairs(const TriMesh& mesh) {
    Intersections found = intersections(mesh);
    found.apart.insert(found.apart.end(), found.adjacent.begin(), found.adjacent.end());
    std::sort(found.apart.begin(), found.apart.end());
    return found.apart;
}

}  // namespace

ValidityGuard::ValidityGuard(const TriMesh& rest, const Adjacency& adjacent)
    : triangles_(rest.triangles), normal_(triangle_normals(rest)), area_(triangle_areas(rest)), height_(area_.size()) {
    intersecting_ = intersecting_pairs(rest);
    for (int t = 0; t < triangles_.rows(); ++t)
        height_[t] = smallest_height(rest.vertices, triangles_.row(t), area_[t]);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (!adjacent.is_regular(e)) continue;
        const int a = adjacent.edge_triangles[e][0], b = adjacent.edge_triangles[e][1];
        if (dihedral(normal_.row(a), normal_.row(b)) >= foldable_below) continue;
        hinge_.push_back({a, b});
        hinge_edge_.push_back(adjacent.edges[e]);
    }
}

std::string ValidityGuard::defect(const Points& vertices, const Poses& poses) const {
    if (!vertices.allFinite()) return "a vertex is not finite";
    Finding inverted{"inverted"}, collapsed{"collapsed"}, folded{"folded"};
    Points normal(triangles_.rows(), 3);
    for (int t = 0; t < triangles_.rows(); ++t) {
        const Eigen::Vector3d a = vertices.row(triangles_(t, 0)), b = vertices.row(triangles_(t, 1)),
                              c = vertices.row(triangles_(t, 2));
        const Eigen::Vector3d area_vector = 0.5 * (b - a).cross(c - a);
        const double area = area_vector.norm();
        normal.row(t) = area > 0 ? Eigen::Vector3d(area_vector / area) : Eigen::Vector3d::Zero();
        if (area < smallest_share * area_[t] ||
            smallest_height(vertices, triangles_.row(t), area) < smallest_share * height_[t])
            collapsed.add(t);
        else if (area_vector.dot(poses.rotation[t] * Eigen::Vector3d(normal_.row(t))) < 0)
            inverted.add(t);
    }
    for (std::size_t e = 0; e < hinge_.size(); ++e)
        if (dihedral(normal.row(hinge_[e][0]), normal.row(hinge_[e][1])) > folded_above)
            folded.add(static_cast<int>(e));
    for (const Finding& finding : {inverted, collapsed})
        if (finding.count > 0)
            return text("triangle ", finding.first, " is ", finding.name, " (", finding.count, " in all)");
    if (folded.count > 0)
        return text("the edge between vertices ", hinge_edge_[folded.first][0], " and ", hinge_edge_[folded.first][1],
                    " is folded (", folded.count, " in all)");
    return intersection(vertices);
}

std::string ValidityGuard::intersection(const Points& vertices) const {
    TriMesh surface;
    surface.vertices = vertices;
    surface.triangles = triangles_;
    std::vector<std::array<int, 2>> fresh;
    const std::vector<std::array<int, 2>> now = intersecting_pairs(surface);
    std::set_difference(now.begin(), now.end(), intersecting_.begin(), intersecting_.end(), std::back_inserter(fresh));
    if (fresh.empty()) return {};
    return text("triangles ", fresh[0][0], " and ", fresh[0][1], " intersect (", fresh.size(), " pairs in all)");
}

}  // namespace strake
