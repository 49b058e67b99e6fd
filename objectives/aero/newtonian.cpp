#include "objectives/aero/newtonian.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/aero/pressure.hpp"
#include "objectives/aero/visible_area.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::Vector3d;

enum Value { drag, lift, side, lift_to_drag, roll, pitch, yaw, num_values };

/// A value is force . F + moment . M for F and M of the whole surface.
struct Weights {
    Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
};

/// One surface in one stream.
class Impact {
public:
    Impact(const std::string& name, const NewtonianFlow& flow, double cp_max, const QuantityRequest& request)
        : flow_(flow),
          cp_max_(cp_max),
          mesh_(request.surface),
          at_(stream_state(name, flow.stream, request.parameters)) {
        if (flow_.shadows) visible_.emplace(mesh_, at_.axes.drag, request.want_sensitivities);
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            const Facet facet = facet_of(t);
            const Vector3d f = -facet.cp * facet.seen * facet.s;
            force_ += f;
            moment_ += facet.arm.cross(f);
        }
    }

    double value(int i) const {
        if (i == lift_to_drag) return value(lift) / value(drag);
        const Weights w = weights(i, at_.axes);
        return w.force.dot(force_) + w.moment.dot(moment_);
    }

    /// Derivatives of value i: by the vertices (n x 3), and by alpha and beta.
    Points gradient(int i, std::array<double, 2>& by_angle) const;
    const StreamState& state() const { return at_; }
    /// Forces per triangle, with shadows.
    Eigen::VectorXd felt_cp() const {
        Eigen::VectorXd cp(mesh_.num_triangles());
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            const Facet facet = facet_of(t);
            cp[t] = facet.cp * facet.seen;
        }
        return cp;
    }

private:
    struct Facet {
        Vector3d e, f;       // edges from the first corner to the others
        Vector3d s, arm;     // area vector; centroid relative to the moment center
        double area, m;      // |s|, u . s
        double cp, by_sine;  // Cp and its derivative by sigma = m / area
        double seen;         // share that the stream reaches
    };
    Facet facet_of(int t) const;
    PressureCoefficient pressure(double sigma, double tilt) const;
    Weights weights(int i, const StreamAxes& axes) const;
    Weights combined(int i, const StreamAxes& axes) const;

    const NewtonianFlow& flow_;
    double cp_max_;
    const TriMesh& mesh_;
    StreamState at_;
    std::optional<VisibleAreas> visible_;
    Vector3d force_ = Vector3d::Zero(), moment_ = Vector3d::Zero();
};

/// Derivative by the sine of the angle to the surface, not by the angle. `tilt` = |u x n|, the cosine of that angle.
PressureCoefficient Impact::pressure(double sigma, double tilt) const {
    if (sigma < 0) return {cp_max_ * sigma * sigma, 2 * cp_max_ * sigma};
    if (flow_.leeward == LeewardPressure::zero) return {};
    PressureCoefficient expanded = expanded_cp(flow_.mach, flow_.gamma, std::atan2(sigma, tilt));
    // A face square to the stream turns it by the largest angle whichever way it tilts: the pressure has the tip of a
    // cone there, and the mean of its slopes is zero. Below this tilt its direction is round-off.
    constexpr double square = 1e-8;
    expanded.by_angle = tilt > square ? expanded.by_angle / tilt : 0;
    return expanded;
}

Impact::Facet Impact::facet_of(int t) const {
    Facet facet;
    const Vector3d a = mesh_.vertices.row(mesh_.triangles(t, 0)), b = mesh_.vertices.row(mesh_.triangles(t, 1)),
                   c = mesh_.vertices.row(mesh_.triangles(t, 2));
    facet.e = b - a;
    facet.f = c - a;
    facet.s = 0.5 * facet.e.cross(facet.f);
    facet.arm = (a + b + c) / 3 - flow_.moment_center;
    facet.area = facet.s.norm();
    facet.m = at_.axes.drag.dot(facet.s);
    const double tilt = facet.area > 0 ? at_.axes.drag.cross(facet.s).norm() / facet.area : 0;
    const PressureCoefficient p = facet.area > 0 ? pressure(facet.m / facet.area, tilt) : PressureCoefficient{};
    facet.cp = p.cp;
    facet.by_sine = p.by_angle;
    facet.seen = visible_ && facet.m < 0 && visible_->partly_hidden(t) ? visible_->area(t) / -facet.m : 1;
    return facet;
}

Weights Impact::weights(int i, const StreamAxes& axes) const {
    const double S = flow_.reference_area, SL = S * flow_.reference_length;
    Weights w;
    if (i == drag) w.force = axes.drag / S;
    if (i == lift) w.force = axes.lift / S;
    if (i == side) w.force = axes.side / S;
    if (i == roll) w.moment = -at_.x / SL;
    if (i == pitch) w.moment = at_.y / SL;
    if (i == yaw) w.moment = -at_.z / SL;
    return w;
}

/// The same, where L/D counts as d(L/D) = (dL - L/D dD) / D.
Weights Impact::combined(int i, const StreamAxes& axes) const {
    if (i != lift_to_drag) return weights(i, axes);
    const double D = value(drag);
    return {(weights(lift, axes).force - value(lift_to_drag) * weights(drag, axes).force) / D, Vector3d::Zero()};
}

Points Impact::gradient(int i, std::array<double, 2>& by_angle) const {
    const Weights w = combined(i, at_.axes);
    const Vector3d u = at_.axes.drag;
    Points dJ_dv = Points::Zero(mesh_.num_vertices(), 3);
    Eigen::VectorXd by_seen = Eigen::VectorXd::Zero(visible_ ? mesh_.num_triangles() : 0);
    Vector3d by_u = Vector3d::Zero();
    for (int t = 0; t < mesh_.num_triangles(); ++t) {
        const Facet f = facet_of(t);
        if (!(f.area > 0) || (f.cp == 0 && f.by_sine == 0)) continue;
        const Vector3d h = w.force + w.moment.cross(f.arm);
        const double sh = f.s.dot(h), slope = f.seen * f.by_sine * sh / f.area;
        Vector3d by_s = -slope * (u - f.m / (f.area * f.area) * f.s) - f.seen * f.cp * h;
        by_u -= slope * f.s;
        if (visible_ && f.m < 0 && visible_->partly_hidden(t)) {
            const double c = -f.cp * sh / -f.m;  // by the visible area
            by_seen[t] = c;
            by_s += c * f.seen * u;
            by_u += c * f.seen * f.s;
        }
        const Vector3d by_centroid = -f.seen * f.cp * f.s.cross(w.moment) / 3;
        const Vector3d by_e = 0.5 * f.f.cross(by_s), by_f = 0.5 * by_s.cross(f.e);
        const auto v = mesh_.triangles.row(t);
        dJ_dv.row(v[0]) += by_centroid - by_e - by_f;
        dJ_dv.row(v[1]) += by_centroid + by_e;
        dJ_dv.row(v[2]) += by_centroid + by_f;
    }
    if (visible_) visible_->add_gradient(by_seen, dJ_dv);
    for (int angle = 0; angle < 2; ++angle) {
        const Vector3d du = at_.by_angle[angle].drag;
        // The moments' weights do not depend on the angles.
        const double by_axes = i <= lift_to_drag ? combined(i, at_.by_angle[angle]).force.dot(force_) : 0;
        by_angle[angle] = by_axes + by_u.dot(du) + (visible_ ? visible_->derivative_along(by_seen, du) : 0);
    }
    return dJ_dv;
}

/// Area-weighted mean over the triangles at each vertex; 0 where these have no area.
Eigen::VectorXd vertex_means(const TriMesh& mesh, const Eigen::VectorXd& of_triangles) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.num_vertices()), areas = sum;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const double area = area_vector(mesh, t).stableNorm();
        for (int k = 0; k < 3; ++k) {
            sum[mesh.triangles(t, k)] += area * of_triangles[t];
            areas[mesh.triangles(t, k)] += area;
        }
    }
    for (Eigen::Index v = 0; v < sum.size(); ++v) sum[v] = areas[v] > 0 ? sum[v] / areas[v] : 0;
    return sum;
}

void check(const std::string& name, const TriMesh& start, const NewtonianFlow& flow) {
    check_stream(name, flow.stream);
    const auto require = [&](bool ok, const char* what, double value, const char* limit) {
        if (!ok || !std::isfinite(value)) throw InvalidInput(text(name, ": ", what, " = ", value, " must be ", limit));
    };
    require(flow.mach >= 1, "mach", flow.mach, ">= 1");
    if (flow.leeward == LeewardPressure::prandtl_meyer)
        require(flow.mach > 1, "mach", flow.mach, "> 1 for prandtl_meyer");
    require(flow.gamma > 1 && flow.gamma <= 2, "gamma", flow.gamma, "in (1, 2]");
    if (flow.cp_max) require(*flow.cp_max > 0, "cp_max", *flow.cp_max, "> 0");
    require(flow.reference_area > 0, "reference_area", flow.reference_area, "> 0");
    require(flow.reference_length > 0, "reference_length", flow.reference_length, "> 0");
    require(flow.moment_center.allFinite(), "moment_center", flow.moment_center.sum(), "finite");
    require_oriented(name, start);
    const double V = enclosed_volume(start), d = box_diagonal(start);
    if (V < -1e-6 * d * d * d)
        throw InvalidInput(text(name, ": the surface is inside out (volume ", V, "); orient it outward"));
}

}  // namespace

Quantity newtonian(const std::string& name, const TriMesh& start, const NewtonianFlow& flow) {
    check(name, start, flow);
    const double cp_max = flow.cp_max ? *flow.cp_max : stagnation_cp(flow.mach, flow.gamma);
    std::vector<std::string> names;
    std::vector<int> kinds;  // of the values, as `Value`
    for (int i = 0; i < num_values; ++i) {
        const std::string& value = newtonian_values[static_cast<std::size_t>(i)];
        if (!flow.has_side_values && is_side_value(value)) continue;
        names.push_back(name + "." + value);
        kinds.push_back(i);
    }
    Quantity quantity = checked_quantity(name, names, start, [=](const QuantityRequest& request) {
        const Impact impact(name, flow, cp_max, request);
        QuantityResult result;
        for (const int kind : kinds) result.values.push_back(impact.value(kind));
        if (!request.want_sensitivities) return result;
        result.dJ_dv.resize(kinds.size());
        result.dJ_dp.resize(kinds.size());
        for (std::size_t i = 0; i < kinds.size(); ++i) {
            if (!request.wants(i)) continue;
            std::array<double, 2> by_angle;
            result.dJ_dv[i] = impact.gradient(kinds[i], by_angle);
            result.dJ_dp[i] = own_derivatives(impact.state(), request, by_angle);
        }
        return result;
    });
    quantity.fields = [=](const QuantityRequest& request) {
        const Impact impact(name, flow, cp_max, request);
        return std::vector<SurfaceField>{{name + ".cp", vertex_means(request.surface, impact.felt_cp())}};
    };
    return quantity;
}

}  // namespace strake
