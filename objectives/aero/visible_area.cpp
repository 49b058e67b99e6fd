#include "objectives/aero/visible_area.hpp"

#include "core/mesh/geometry.hpp"
#include "objectives/aero/shadow_cutter.hpp"

namespace strake {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double no_area_rel = 1e-13;  // of a triangle's own projected area

}  // namespace

VisibleAreas::VisibleAreas(const TriMesh& mesh, const Vector3d& u, bool with_derivatives) : mesh_(mesh), u_(u) {
    const ShadowCutter cutter(mesh, u);
    area_ = Eigen::VectorXd::Zero(mesh.num_triangles());
    hidden_.assign(static_cast<std::size_t>(mesh.num_triangles()), 0);
    std::vector<int> seen(cutter.front.size(), -1), hiders;
    for (std::size_t i = 0; i < cutter.front.size(); ++i) {
        const int t = cutter.front[i];
        const double full = -u.dot(area_vector(mesh, t));
        const auto pieces = cutter.cut_out(static_cast<int>(i), no_area_rel * full, seen, hiders);
        hidden_[t] = pieces.has_value();
        if (!pieces) area_[t] = full;
        if (!pieces || pieces->empty()) continue;
        for (const ShadowPiece& piece : *pieces) area_[t] += area_of(piece);
        if (!with_derivatives) continue;
        add_borders(cutter, t, t, hiders);
        for (const int o : hiders) add_borders(cutter, t, o, hiders);
    }
}

/// Borders on the edges of o: t itself or one of its hiders.
void VisibleAreas::add_borders(const ShadowCutter& cutter, int t, int o, const std::vector<int>& hiders) {
    for (int k = 0; k < 3; ++k) {
        if (o != t && cutter.continues(o, k, hiders)) continue;
        const Vector2d line = cutter.corner(o, (k + 1) % 3) - cutter.corner(o, k);
        const Vector3d outward = (o == t ? 1 : -1) * (line[1] * cutter.b1 - line[0] * cutter.b2);
        for (const Interval& part : cutter.seen_of_edge(t, o, k, hiders))
            borders_.push_back({t, mesh_.triangles(o, k), mesh_.triangles(o, (k + 1) % 3), 0.5 * (part.from + part.to),
                                (part.to - part.from) * outward});
    }
}

void VisibleAreas::add_gradient(const Eigen::VectorXd& weight, Points& dJ_dv) const {
    for (int t = 0; t < mesh_.num_triangles(); ++t) {
        if (hidden_[t] || area_[t] == 0 || weight[t] == 0) continue;
        for (int k = 0; k < 3; ++k) {
            const Vector3d opposite = mesh_.vertices.row(mesh_.triangles(t, (k + 2) % 3)) -
                                      mesh_.vertices.row(mesh_.triangles(t, (k + 1) % 3));
            dJ_dv.row(mesh_.triangles(t, k)) -= 0.5 * weight[t] * u_.cross(opposite);
        }
    }
    for (const Border& border : borders_) {
        dJ_dv.row(border.p) += (1 - border.along) * weight[border.triangle] * border.outward;
        dJ_dv.row(border.q) += border.along * weight[border.triangle] * border.outward;
    }
}

/// Turning the stream by du is moving each vertex x by -(u . x) du.
double VisibleAreas::derivative_along(const Eigen::VectorXd& weight, const Vector3d& du) const {
    double sum = 0;
    for (int t = 0; t < mesh_.num_triangles(); ++t)
        if (!hidden_[t] && area_[t] != 0) sum -= weight[t] * du.dot(area_vector(mesh_, t));
    for (const Border& border : borders_) {
        const double depth = (1 - border.along) * u_.dot(mesh_.vertices.row(border.p)) +
                             border.along * u_.dot(mesh_.vertices.row(border.q));
        sum -= weight[border.triangle] * depth * du.dot(border.outward);
    }
    return sum;
}

}  // namespace strake
