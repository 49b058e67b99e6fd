#include "optimize/evaluate/validity.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>

namespace strake {
namespace {

constexpr double smallest_share = 1e-3;
constexpr double chord_slack = 2;  ///< the estimate of a chord error, and how much a map shrinks
constexpr double sliver = 1e-3;    ///< height over longest edge of triangles that say nothing

double longest_edge(const Points& v, const Eigen::RowVector3i& t) {
    double longest = 0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, (v.row(t[(k + 1) % 3]) - v.row(t[k])).squaredNorm());
    return std::sqrt(longest);
}

double smallest_height(const Points& v, const Eigen::RowVector3i& t, double area) {
    const double longest = longest_edge(v, t);
    return longest > 0 ? 2 * area / longest : 0;
}

std::string place(const Eigen::Vector3d& x) { return text("at (", x[0], ", ", x[1], ", ", x[2], ")"); }

Eigen::Vector3d centre(const Points& v, const Eigen::RowVector3i& t) {
    return (v.row(t[0]) + v.row(t[1]) + v.row(t[2])) / 3;
}

/// The middle of what the boxes of two triangles have in common.
Eigen::Vector3d between(const Points& v, const Eigen::RowVector3i& s, const Eigen::RowVector3i& t) {
    const auto low = [&](const Eigen::RowVector3i& a) -> Eigen::RowVector3d {
        return v.row(a[0]).cwiseMin(v.row(a[1])).cwiseMin(v.row(a[2]));
    };
    const auto high = [&](const Eigen::RowVector3i& a) -> Eigen::RowVector3d {
        return v.row(a[0]).cwiseMax(v.row(a[1])).cwiseMax(v.row(a[2]));
    };
    return 0.5 * (low(s).cwiseMax(low(t)) + high(s).cwiseMin(high(t)));
}

/// Counts what is wrong and remembers the first.
struct Finding {
    int first = -1, count = 0;
    void add(int at) {
        if (count++ == 0) first = at;
    }
};

std::vector<int> vertices_of(const TriMesh& mesh, const std::vector<int>& triangles) {
    std::vector<int> result;
    for (const int t : triangles) {
        if (t < 0 || t >= mesh.num_triangles())
            throw InvalidInput(
                text("validity guard: fixed triangle ", t, " is not in [0, ", mesh.num_triangles(), ")"));
        for (int k = 0; k < 3; ++k) result.push_back(mesh.triangles(t, k));
    }
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

}  // namespace

ValidityGuard::ValidityGuard(std::shared_ptr<const TriMesh> at_rest, const Adjacency& adjacent,
                             const ValidityOptions& options)
    : rest_(std::move(at_rest)),
      fixed_vertices_(vertices_of(*rest_, options.fixed)),
      tree_(rest_),
      parts_(rest_, adjacent, options.symmetry, tree_.at_rest().apart),
      normal_(triangle_normals(*rest_)),
      area_(triangle_areas(*rest_)),
      height_(area_.size()) {
    const TriMesh& rest = *rest_;
    if (!options.attached.empty()) let_cuts_wander(rest, adjacent, options.attached);
    for (int t = 0; t < triangles().rows(); ++t)
        height_[t] = smallest_height(rest.vertices, triangles().row(t), area_[t]);
    if (options.by_map) {
        std::vector<std::array<int, 2>> pairs = tree_.at_rest().apart;
        pairs.insert(pairs.end(), tree_.at_rest().adjacent.begin(), tree_.at_rest().adjacent.end());
        contacts_.emplace(rest_, adjacent, std::move(pairs));
        is_sliver_.resize(static_cast<std::size_t>(triangles().rows()));
        for (int t = 0; t < triangles().rows(); ++t)
            is_sliver_[static_cast<std::size_t>(t)] =
                !(height_[t] > sliver * longest_edge(rest.vertices, triangles().row(t)));
    }
    folds_ = EdgeFolds(rest_, adjacent, is_sliver_);
}

void ValidityGuard::let_cuts_wander(const TriMesh& rest, const Adjacency& adjacent, const std::vector<int>& attached) {
    component_ = edge_components(rest, adjacent);
    std::vector<char> is_attached(component_.size(), 0);
    for (const int t : attached) is_attached.at(t) = 1;
    for (const auto& [s, t] : tree_.at_rest().apart)
        if (component_[s] != component_[t] && (is_attached[s] || is_attached[t]))
            piercing_.insert(std::minmax(component_[s], component_[t]));
}

void ValidityGuard::check_size(Eigen::Index vertices, std::size_t per_triangle, const char* of) const {
    if (vertices != rest_->num_vertices() || static_cast<Eigen::Index>(per_triangle) != triangles().rows())
        throw InvalidInput(text("validity guard: ", vertices, " vertices and ", per_triangle, " ", of, ", expected ",
                                rest_->num_vertices(), " and ", triangles().rows()));
}

std::string ValidityGuard::defect(const Points& vertices, const Poses& poses) const {
    check_size(vertices.rows(), poses.rotation.size(), "poses");
    const auto turned = [&](int t) { return Eigen::Vector3d(poses.rotation[t] * Eigen::Vector3d(normal_.row(t))); };
    return defect(vertices, turned, nullptr);
}

std::string ValidityGuard::defect(const Points& vertices, const std::vector<Eigen::Matrix3d>& maps) const {
    check_size(vertices.rows(), maps.size(), "maps");
    if (!contacts_) throw InvalidInput("validity guard: it was made for a surface that no map of space moves");
    std::string words = folding(maps);
    if (!words.empty()) return words;
    const auto image = [&](int t) {
        const Eigen::Matrix3d& F = maps[static_cast<std::size_t>(t)];
        const Eigen::Vector3d n = normal_.row(t);  // the cofactors turn normals: det F > 0
        return Eigen::Vector3d(F.determinant() * F.transpose().inverse() * n);
    };
    return defect(vertices, image, &maps);
}

std::string ValidityGuard::folding(const std::vector<Eigen::Matrix3d>& maps) const {
    Finding folds;
    for (std::size_t t = 0; t < maps.size(); ++t)
        if (!(maps[t].determinant() > min_determinant)) folds.add(static_cast<int>(t));
    if (folds.count == 0) return {};
    return text("the displacement fields fold space at triangle ", folds.first, " (", folds.count, " in all), ",
                place(centre(rest_->vertices, triangles().row(folds.first))), " at rest");
}

/// By how much the edges miss the linear part of the map: more than any point of the flat triangle does.
double ValidityGuard::chord_error(int t, const Points& vertices, const Eigen::Matrix3d& map) const {
    double largest = 0;
    for (int k = 0; k < 3; ++k) {
        const int a = triangles()(t, k), b = triangles()(t, (k + 1) % 3);
        const Eigen::Vector3d rest = (rest_->vertices.row(b) - rest_->vertices.row(a)).transpose();
        largest = std::max(largest, ((vertices.row(b) - vertices.row(a)).transpose() - map * rest).norm());
    }
    return largest;
}

std::string ValidityGuard::defect(const Points& vertices, const Expected& expected,
                                  const std::vector<Eigen::Matrix3d>* maps) const {
    for (int v = 0; v < vertices.rows(); ++v)
        if (!vertices.row(v).allFinite()) return text("vertex ", v, " is not finite");
    Points normal(triangles().rows(), 3);
    std::string words = moved_fixed(vertices);
    if (words.empty()) words = bad_triangles(vertices, expected, normal);
    if (words.empty()) words = folded(vertices, normal);
    if (words.empty()) words = parts_.inside_out(vertices);
    if (words.empty()) words = intersection(vertices, maps);
    if (words.empty()) words = parts_.swallowed(vertices);
    return words;
}

std::string ValidityGuard::moved_fixed(const Points& vertices) const {
    Finding moved;
    for (const int v : fixed_vertices_)
        if (vertices.row(v) != rest_->vertices.row(v)) moved.add(v);
    if (moved.count == 0) return {};
    return text("fixed vertex ", moved.first, " has moved by ",
                (vertices.row(moved.first) - rest_->vertices.row(moved.first)).norm(), " (", moved.count, " in all), ",
                place(vertices.row(moved.first)));
}

std::string ValidityGuard::bad_triangles(const Points& vertices, const Expected& expected, Points& normal) const {
    Finding inverted, collapsed;
    for (int t = 0; t < triangles().rows(); ++t) {
        const Eigen::Vector3d a = vertices.row(triangles()(t, 0)), b = vertices.row(triangles()(t, 1)),
                              c = vertices.row(triangles()(t, 2));
        const Eigen::Vector3d area_vector = 0.5 * (b - a).cross(c - a);
        const double area = area_vector.norm();
        normal.row(t) = area > 0 ? Eigen::Vector3d(area_vector / area) : Eigen::Vector3d::Zero();
        if (!is_sliver_.empty() && is_sliver_[static_cast<std::size_t>(t)]) continue;
        if (area < smallest_share * area_[t] ||
            smallest_height(vertices, triangles().row(t), area) < smallest_share * height_[t])
            collapsed.add(t);
        else if (!(area_vector.dot(expected(t)) >= 0))
            inverted.add(t);
    }
    for (const auto& [name, finding] : {std::pair("inverted", inverted), std::pair("collapsed", collapsed)})
        if (finding.count > 0)
            return text("triangle ", finding.first, " is ", name, " (", finding.count, " in all), ",
                        place(centre(vertices, triangles().row(finding.first))));
    return {};
}

std::string ValidityGuard::folded(const Points& vertices, const Points& normal) const {
    const std::vector<int> folded = folds_.above(EdgeFolds::folded, normal);
    if (folded.empty()) return {};
    const auto [v, w] = folds_.ends(folded[0]);
    const auto [s, t] = folds_.triangles(folded[0]);
    return text("the edge between vertices ", v, " and ", w, " (triangles ", s, " and ", t, ") is folded (",
                folded.size(), " in all), ", place(0.5 * (vertices.row(v) + vertices.row(w))));
}

std::string ValidityGuard::intersection(const Points& vertices, const std::vector<Eigen::Matrix3d>* maps) const {
    std::vector<std::array<int, 2>> pairs = tree_.fresh(vertices);
    if (maps)
        std::erase_if(pairs, [&](const std::array<int, 2>& pair) {
            const auto [s, t] = pair;
            const double error = chord_error(s, vertices, (*maps)[static_cast<std::size_t>(s)]) +
                                 chord_error(t, vertices, (*maps)[static_cast<std::size_t>(t)]);
            return contacts_->is_near(s, t) && contacts_->distance(s, t) <= chord_slack * error;
        });
    if (!piercing_.empty())
        std::erase_if(pairs, [&](const std::array<int, 2>& pair) {
            return piercing_.contains(std::minmax(component_[pair[0]], component_[pair[1]]));
        });
    if (pairs.empty()) return {};
    const auto [s, t] = pairs[0];
    return text("triangles ", s, " and ", t, " intersect (", pairs.size(), " pairs in all), ",
                place(between(vertices, triangles().row(s), triangles().row(t))));
}

}  // namespace strake
