#include "optimize/evaluate/closed_parts.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <limits>
#include <numbers>
#include <set>

namespace strake {
namespace {

constexpr int max_parts = 16;
constexpr double no_volume = 1e-9;  ///< relative to area times diagonal
constexpr std::size_t part_samples = 16;

Eigen::Vector3d mirrored(const SymmetryPlane& plane, const Eigen::Vector3d& x) {
    return x - 2 * (plane.normal.dot(x) - plane.offset) * plane.normal;
}

enum class EdgeKind { regular, on_plane, open };

EdgeKind kind_of(const TriMesh& mesh, const Adjacency& adjacent, int e, const std::optional<SymmetryPlane>& symmetry,
                 double tolerance) {
    if (adjacent.is_regular(e)) return EdgeKind::regular;
    if (!symmetry || adjacent.edge_triangles[e].size() != 1) return EdgeKind::open;
    for (const int v : adjacent.edges[e])
        if (std::abs(mesh.vertices.row(v).dot(symmetry->normal) - symmetry->offset) > tolerance) return EdgeKind::open;
    return EdgeKind::on_plane;
}

}  // namespace

ClosedParts::ClosedParts(std::shared_ptr<const TriMesh> at_rest, const Adjacency& adjacent,
                         const std::optional<SymmetryPlane>& symmetry,
                         const std::vector<std::array<int, 2>>& intersecting)
    : rest_(std::move(at_rest)), symmetry_(symmetry) {
    const TriMesh& rest = *rest_;
    const double diagonal = box_diagonal(rest);
    const Box box = bounding_box(rest);
    origin_ = 0.5 * (box.min + box.max);
    if (symmetry) origin_ = 0.5 * (origin_ + mirrored(*symmetry, origin_));
    const std::vector<int> component = edge_components(rest, adjacent);
    std::vector<Part> all;
    for (int t = 0; t < rest.num_triangles(); ++t) {
        if (component[t] == static_cast<int>(all.size())) all.emplace_back();
        all[component[t]].triangles.push_back(t);
    }
    std::vector<char> open(all.size(), 0);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const int c = component[adjacent.edge_triangles[e][0]];
        const EdgeKind kind = kind_of(rest, adjacent, e, symmetry, 1e-6 * diagonal);
        if (kind == EdgeKind::open) open[c] = 1;
        if (kind == EdgeKind::on_plane) all[c].by_plane = true;
    }
    const Eigen::VectorXd area = triangle_areas(rest);
    std::vector<int> number(all.size(), -1);
    for (std::size_t c = 0; c < all.size(); ++c) {
        double size = 0;
        for (const int t : all[c].triangles) size += area[t];
        all[c].volume = volume(all[c], rest.vertices);
        if (open[c] || std::abs(all[c].volume) <= no_volume * size * diagonal) continue;
        number[c] = static_cast<int>(parts_.size());
        parts_.push_back(std::move(all[c]));
    }
    if (parts_.size() < 2 || parts_.size() > max_parts) return;
    std::set<std::pair<int, int>> piercing;
    for (const auto& [s, t] : intersecting) piercing.insert(std::minmax(number[component[s]], number[component[t]]));
    for (int a = 0; a < static_cast<int>(parts_.size()); ++a)
        for (int b = 0; b < static_cast<int>(parts_.size()); ++b)
            if (a != b && !piercing.count(std::minmax(a, b))) {
                const int vertex = vertex_away(parts_[a], parts_[b], rest.vertices);
                relations_.push_back({a, b, vertex, inside(vertex, b, rest.vertices)});
            }
}

/// Where parts touch, round-off would decide.
int ClosedParts::vertex_away(const Part& part, const Part& other, const Points& rest) const {
    int best = -1;
    double farthest = -1;
    for (std::size_t k = 0; k < part_samples; ++k) {
        const int v = rest_->triangles(part.triangles[k * part.triangles.size() / part_samples], 0);
        double nearest = std::numeric_limits<double>::infinity();
        for (const int t : other.triangles)
            nearest = std::min(nearest, (rest.row(rest_->triangles(t, 0)) - rest.row(v)).squaredNorm());
        if (nearest > farthest) best = v, farthest = nearest;
    }
    return best;
}

double ClosedParts::volume(const Part& part, const Points& vertices) const {
    double sum = 0;
    for (const int t : part.triangles) {
        const Eigen::Vector3d a = vertices.row(rest_->triangles(t, 0)), b = vertices.row(rest_->triangles(t, 1)),
                              c = vertices.row(rest_->triangles(t, 2));
        sum += (a - origin_).dot((b - origin_).cross(c - origin_));
    }
    return sum / 6;
}

/// Sum of solid angles (Van Oosterom & Strackee 1983) over 4 pi.
int ClosedParts::winding(const Part& part, const Points& vertices, const Eigen::Vector3d& x) const {
    double angle = 0;
    for (const int t : part.triangles) {
        const Eigen::Vector3d a = vertices.row(rest_->triangles(t, 0)).transpose() - x,
                              b = vertices.row(rest_->triangles(t, 1)).transpose() - x,
                              c = vertices.row(rest_->triangles(t, 2)).transpose() - x;
        const double la = a.norm(), lb = b.norm(), lc = c.norm();
        angle += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return static_cast<int>(std::lround(angle / (4 * std::numbers::pi)));
}

int ClosedParts::inside(int vertex, int other, const Points& vertices) const {
    const Part& around = parts_[other];
    const Eigen::Vector3d x = vertices.row(vertex);
    Eigen::Vector3d low = x, high = x;
    for (const int t : around.triangles)
        for (int k = 0; k < 3; ++k) {
            low = low.cwiseMin(vertices.row(rest_->triangles(t, k)).transpose());
            high = high.cwiseMax(vertices.row(rest_->triangles(t, k)).transpose());
        }
    const bool beside = (x.array() == low.array()).any() || (x.array() == high.array()).any();
    if (!around.by_plane) return beside ? 0 : winding(around, vertices, x);
    // The cut is open: the mirror image closes it.
    return winding(around, vertices, x) + winding(around, vertices, mirrored(*symmetry_, x));
}

std::string ClosedParts::words(const Part& part) const {
    return text("the closed part that starts with triangle ", part.triangles[0], " (", part.triangles.size(),
                " triangles)");
}

std::string ClosedParts::inside_out(const Points& vertices) const {
    for (const Part& part : parts_) {
        const double now = volume(part, vertices);
        if (!(now * part.volume > 0))
            return text(words(part), " is turned inside out: it encloses ", now, ", at the start ", part.volume);
    }
    return {};
}

std::string ClosedParts::swallowed(const Points& vertices) const {
    for (const Relation& r : relations_)
        if (inside(r.vertex, r.other, vertices) != r.inside)
            return text(words(parts_[r.part]), " has gone ", r.inside == 0 ? "into " : "out of ",
                        words(parts_[r.other]));
    return {};
}

}  // namespace strake
