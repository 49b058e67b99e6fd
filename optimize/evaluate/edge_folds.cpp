#include "optimize/evaluate/edge_folds.hpp"

#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

namespace strake {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double foldable_below = 120;  ///< degrees at rest
constexpr double folds_of_a_turn = 10;  ///< so that steps are told of a border early, and aim near its limit
constexpr double min_turn = 0.1;        ///< of the largest one: a border that turns less limits no step
constexpr double rounding = 1e-6;       ///< degrees: of designs that are inherited

double as_fold(double turn) { return EdgeFolds::kept + folds_of_a_turn * (std::abs(turn) - EdgeFolds::max_turn); }

/// Edges that are as folded but for rounding are taken in their order.
bool is_larger(double a, double b) { return std::round(a * 1e9) > std::round(b * 1e9); }

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

EdgeFolds EdgeFolds::with_border(const Adjacency& adjacent, const std::vector<char>& held, const Points& datum) const {
    EdgeFolds all = *this;
    const Points normal = normals(datum);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (!adjacent.is_regular(e)) continue;
        auto [a, b] = std::array{adjacent.edge_triangles[e][0], adjacent.edge_triangles[e][1]};
        if (held[static_cast<std::size_t>(a)] == held[static_cast<std::size_t>(b)]) continue;
        if (!held[static_cast<std::size_t>(a)]) std::swap(a, b);
        if (!normal.row(b).isZero(0)) all.border_.push_back({a, b, normal.row(b)});
    }
    return all;
}

std::array<int, 2> EdgeFolds::triangles(int edge) const {
    const auto number = static_cast<std::size_t>(edge);
    if (number < hinges_.size()) return hinges_[number];
    const Border& border = border_[number - hinges_.size()];
    return {border.held, border.free};
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
    if (is_none()) return false;
    const Points normal = normals(vertices);
    return !above(degrees, normal).empty() || std::ranges::any_of(border_, [&](const Border& border) {
        return as_fold(turn(border, vertices, normal.row(border.free))) > std::min(degrees, kept) + rounding;
    });
}

double EdgeFolds::turn(const Border& border, const Points& vertices, const Eigen::Vector3d& normal) const {
    const auto t = rest_->triangles.row(border.free);
    const auto is_held = [&](int v) { return (rest_->triangles.row(border.held).array() == v).any(); };
    int k = 0;  // the corner before the edge
    while (k < 2 && is_held(t[k])) ++k;
    const Eigen::Vector3d along = (vertices.row(t[(k + 2) % 3]) - vertices.row(t[(k + 1) % 3])).normalized();
    return std::atan2(border.normal.cross(normal).dot(along), border.normal.dot(normal)) / degree;
}

/// The free corner turns the normal by its motion along it over its distance from the edge.
EdgeFolds::Row EdgeFolds::border_row(int number, const Points& vertices, const Eigen::Vector3d& normal,
                                     double turn) const {
    const int edge = static_cast<int>(hinges_.size()) + number;
    Row row{edge, as_fold(turn), this->vertices(edge), Eigen::Matrix<double, 4, 3>::Zero(), true};
    const Eigen::Vector3d from = vertices.row(row.vertices[0]), along = vertices.row(row.vertices[1]),
                          corner = vertices.row(row.vertices[3]);
    const double distance = (along - from).normalized().cross(corner - from).norm();
    if (distance > 0)
        row.gradient.row(3) = (turn < 0 ? -1 : 1) * folds_of_a_turn / (distance * degree) * normal.transpose();
    return row;
}

void EdgeFolds::add_border_rows(const Points& vertices, const Points& normal, double degrees, int count,
                                std::vector<Row>& chosen) const {
    std::vector<Row> rows;
    for (std::size_t k = 0; k < border_.size(); ++k) {
        const Eigen::Vector3d n = normal.row(border_[k].free);
        const double angle = turn(border_[k], vertices, n);
        if (std::abs(angle) > min_turn * max_turn && as_fold(angle) > std::min(degrees, kept))
            rows.push_back(border_row(static_cast<int>(k), vertices, n, angle));
    }
    std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return is_larger(a.angle, b.angle); });
    std::vector<int> taken;
    for (const Row& row : rows) {
        if (static_cast<int>(taken.size()) >= count) break;
        if (std::ranges::find(taken, row.vertices[3]) != taken.end()) continue;
        taken.push_back(row.vertices[3]);
        chosen.push_back(row);
    }
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
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return is_larger(a.first, b.first); });
    std::vector<char> is_taken(static_cast<std::size_t>(vertices.rows()), 0);
    for (const auto& [angle, e] : all) {
        if (static_cast<int>(chosen.size()) >= count) break;
        const std::array<int, 4> at = this->vertices(e);
        if (std::ranges::any_of(at, [&](int v) { return is_taken[static_cast<std::size_t>(v)] != 0; })) continue;
        for (const int v : at) is_taken[static_cast<std::size_t>(v)] = 1;
        chosen.push_back(row(e, vertices, angle));
    }
    add_border_rows(vertices, normal, degrees, 2 * count, chosen);
    return chosen;
}

/// d angle = -(m1.da1 / |a1| + m2.da2 / |a2|), a the vector area (twice) of a triangle, and m unit, normal to the edge
/// in its triangle's plane, towards the other's normal.
EdgeFolds::Row EdgeFolds::row(int edge, const Points& vertices, double angle) const {
    const std::array<int, 2> sides = triangles(edge);
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
