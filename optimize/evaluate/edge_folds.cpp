#include "optimize/evaluate/edge_folds.hpp"

#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

namespace strake {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double foldable_below = 120;  ///< degrees at rest

}  // namespace

EdgeFolds::EdgeFolds(std::shared_ptr<const TriMesh> rest, const Adjacency& adjacent, const std::vector<char>& excluded)
    : rest_(std::move(rest)) {
    const Points normal = triangle_normals(*rest_);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (!adjacent.is_regular(e)) continue;
        const int a = adjacent.edge_triangles[e][0], b = adjacent.edge_triangles[e][1];
        if (!excluded.empty() && (excluded[a] || excluded[b])) continue;
        if (dihedral(normal.row(a), normal.row(b)) >= foldable_below * degree) continue;
        hinges_.push_back({a, b});
    }
}

/// The two corners that its triangles share, the smaller number first, and their others.
std::array<int, 4> EdgeFolds::vertices(int edge) const {
    const auto [a, b] = triangles(edge);
    const Eigen::RowVector3i of_a = rest_->triangles.row(a), of_b = rest_->triangles.row(b);
    std::array<int, 4> all{-1, -1, of_a.sum(), of_b.sum()};
    for (const int v : of_a) {
        if (v == all[0] || v == all[1] || (of_b.array() != v).all()) continue;
        (all[0] < 0 ? all[0] : all[1]) = v;
        all[2] -= v;
        all[3] -= v;
    }
    if (all[0] > all[1]) std::swap(all[0], all[1]);
    return all;
}

std::array<int, 2> EdgeFolds::ends(int edge) const {
    const std::array<int, 4> all = vertices(edge);
    return {all[0], all[1]};
}

std::vector<int> EdgeFolds::above(double degrees, const Points& normal) const {
    std::vector<int> found;
    const double near = std::cos((degrees - 1) * degree);  // the angle itself is needed of few
    for (std::size_t e = 0; e < hinges_.size(); ++e) {
        const auto [a, b] = hinges_[e];
        if (normal.row(a).dot(normal.row(b)) < near && dihedral(normal.row(a), normal.row(b)) > degrees * degree)
            found.push_back(static_cast<int>(e));
    }
    return found;
}

Points EdgeFolds::normals(const Points& vertices) const {
    TriMesh mesh;
    mesh.vertices = vertices;
    mesh.triangles = rest_->triangles;
    return triangle_normals(mesh);
}

bool EdgeFolds::any_above(double degrees, const Points& vertices) const {
    return !is_none() && !above(degrees, normals(vertices)).empty();
}

std::vector<EdgeFolds::Row> EdgeFolds::rows(const Points& vertices, double degrees, int count) const {
    std::vector<Row> chosen;
    if (is_none()) return chosen;
    const Points normal = normals(vertices);
    std::vector<std::pair<double, int>> all;
    for (const int e : above(degrees, normal)) {
        const auto [a, b] = triangles(e);
        all.emplace_back(dihedral(normal.row(a), normal.row(b)) / degree, e);
    }
    // Edges that are as folded but for rounding are taken in their order.
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
        return std::round(a.first * 1e9) > std::round(b.first * 1e9);
    });
    std::vector<char> is_taken(static_cast<std::size_t>(vertices.rows()), 0);
    for (const auto& [angle, e] : all) {
        if (static_cast<int>(chosen.size()) >= count) break;
        const std::array<int, 4> at = this->vertices(e);
        if (std::ranges::any_of(at, [&](int v) { return is_taken[static_cast<std::size_t>(v)] != 0; })) continue;
        for (const int v : at) is_taken[static_cast<std::size_t>(v)] = 1;
        chosen.push_back(row(e, vertices, angle));
    }
    return chosen;
}

/// d angle = -(m1.da1 / |a1| + m2.da2 / |a2|), a the vector area (twice) of a triangle, and m unit, normal to the edge
/// in its triangle's plane, towards the other's normal.
EdgeFolds::Row EdgeFolds::row(int edge, const Points& vertices, double angle) const {
    const std::array<int, 2>& sides = triangles(edge);
    Row row{edge, angle, this->vertices(edge), Eigen::Matrix<double, 4, 3>::Zero()};
    const Eigen::Vector3d along = (vertices.row(row.vertices[1]) - vertices.row(row.vertices[0])).normalized();
    std::array<Eigen::Vector3d, 2> area;
    for (int k = 0; k < 2; ++k) {
        const auto t = rest_->triangles.row(sides[k]);
        const Eigen::Vector3d p = vertices.row(t[0]), q = vertices.row(t[1]), r = vertices.row(t[2]);
        area[k] = (q - p).cross(r - p);
    }
    for (int k = 0; k < 2; ++k) {
        Eigen::Vector3d m = along.cross(area[k]).normalized();
        if (m.dot(area[1 - k]) < 0) m = -m;
        const double size = area[k].norm();
        if (!(size > 0)) continue;
        const auto t = rest_->triangles.row(sides[k]);
        for (int c = 0; c < 3; ++c) {
            const Eigen::Vector3d next = vertices.row(t[(c + 1) % 3]), last = vertices.row(t[(c + 2) % 3]);
            const auto at = std::ranges::find(row.vertices, t[c]) - row.vertices.begin();
            row.gradient.row(at) -= (next - last).cross(m).transpose() / (size * degree);
        }
    }
    return row;
}

}  // namespace strake
