#include "objectives/aero/friction.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double rounded_rel = 1e-4;  // of the length
constexpr double prandtl = 0.72, sutherland = 110.4;

/// Rule of degree five: barycentric points and weights.
struct Point {
    std::array<double, 3> b;
    double weight;
};
const std::array<Point, 7>& rule() {
    static const std::array<Point, 7> points = [] {
        const double r = std::sqrt(15.0), p = (6 - r) / 21, q = (6 + r) / 21, wp = (155 - r) / 1200,
                     wq = (155 + r) / 1200, third = 1.0 / 3;
        return std::array<Point, 7>{{{{third, third, third}, 0.225},
                                     {{p, p, 1 - 2 * p}, wp},
                                     {{p, 1 - 2 * p, p}, wp},
                                     {{1 - 2 * p, p, p}, wp},
                                     {{q, q, 1 - 2 * q}, wq},
                                     {{q, 1 - 2 * q, q}, wq},
                                     {{1 - 2 * q, q, q}, wq}}};
    }();
    return points;
}

/// Where a vertex's length begins: a point between two foremost vertices.
struct Begin {
    int a, b;
    double t;
};

/// Vertices as the flow sees them. A half model adds their mirror images, with `vertex` the original (`along` is the
/// same, because the flow does not cross the plane).
struct Seen {
    VectorXd along, across;
    int vertex(int i) const { return i % count; }
    int count;               ///< of the model itself
    std::vector<char> used;  ///< by a triangle
};

std::vector<Begin> leading_line(const Seen& seen, double edge) {
    const VectorXd &along = seen.along, &across = seen.across;
    const double low = across.minCoeff(), high = across.maxCoeff();
    // An odd number, counted from the middle: both sides get the same strips.
    const int side = static_cast<int>((high - low) / (4 * edge));
    const double width = (high - low) / (2 * side + 1), middle = 0.5 * (low + high);
    const auto strip = [&](int v) {
        const double from_middle = width > 0 ? (across[v] - middle) / width : 0;
        const int k = std::min(side, static_cast<int>(std::abs(from_middle) + 0.5 + 1e-9));
        return static_cast<std::size_t>(from_middle < 0 ? side - k : side + k);
    };
    std::vector<int> foremost(static_cast<std::size_t>(2 * side + 1), -1), line;
    for (int v = 0; v < along.size(); ++v) {
        if (!seen.used[seen.vertex(v)]) continue;
        int& first = foremost[strip(v)];
        if (first < 0 || along[v] < along[first]) first = v;
    }
    for (const int v : foremost)
        if (v >= 0) line.push_back(v);
    std::vector<Begin> begins;
    for (int v = 0; v < seen.count; ++v) {
        const auto next =
            std::upper_bound(line.begin(), line.end(), across[v], [&](double y, int w) { return y < across[w]; });
        const int b = next == line.end() ? line.back() : *next, a = next == line.begin() ? b : *(next - 1);
        const double gap = across[b] - across[a];
        begins.push_back({seen.vertex(a), seen.vertex(b), gap > 0 ? (across[v] - across[a]) / gap : 0});
    }
    return begins;
}

class Plates {
public:
    Plates(const TriMesh& start, const FrictionFlow& flow, const std::optional<SymmetryPlane>& symmetry)
        : flow_(flow), law_(plate_law(flow)) {
        Stream level = flow.stream;
        level.alpha = level.beta = {};
        const StreamState at = stream_state("friction", level, {});
        const Points vertices = symmetry ? whole_of(start, *symmetry).vertices : start.vertices;
        const Seen seen{vertices * at.x, vertices * at.y, start.num_vertices(), used_vertices(start)};
        const double edge = std::sqrt(2.3 * surface_area(start) / std::max(1, start.num_triangles()));
        begins_ = leading_line(seen, edge);
        rounded_ = rounded_rel * (seen.along.maxCoeff() - seen.along.minCoeff());
    }

    /// @param dJ_dv, by_axis may be null; by_axis is dJ / d(direction of the stream).
    double drag(const TriMesh& mesh, const Vector3d& axis, Points* dJ_dv, Vector3d* by_axis) const;
    /// Of each vertex.
    VectorXd cf(const TriMesh& mesh, const Vector3d& axis) const {
        return lengths(mesh, axis).unaryExpr([this](double l) { return at(l).cf; });
    }

private:
    /// Per vertex: distance along the stream from the leading line.
    VectorXd lengths(const TriMesh& mesh, const Vector3d& axis) const {
        const VectorXd along = mesh.vertices * axis;
        VectorXd length(along.size());
        for (Eigen::Index v = 0; v < along.size(); ++v) {
            const Begin& begin = begins_[static_cast<std::size_t>(v)];
            length[v] = along[v] - (1 - begin.t) * along[begin.a] - begin.t * along[begin.b];
        }
        return length;
    }
    struct Friction {
        double cf, by_length;
    };
    Friction at(double l) const {
        const double root = std::sqrt(l * l + rounded_ * rounded_), length = 0.5 * (l + root);
        const double cf = law_.scale * std::pow(flow_.reynolds_per_length * length, -law_.exponent);
        return {cf, -law_.exponent * cf / length * 0.5 * (1 + l / root)};
    }
    FrictionFlow flow_;
    PlateLaw law_;
    std::vector<Begin> begins_;
    double rounded_ = 0;
};

double Plates::drag(const TriMesh& mesh, const Vector3d& axis, Points* dJ_dv, Vector3d* by_axis) const {
    const VectorXd length = lengths(mesh, axis);
    VectorXd by_length = VectorXd::Zero(length.size());
    double sum = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto v = mesh.triangles.row(t);
        const Vector3d s = area_vector(mesh, t);
        const double A = s.norm(), share = A / flow_.reference_area;
        double mean = 0;
        std::array<double, 3> by{};
        for (const Point& point : rule()) {
            const Friction f = at(point.b[0] * length[v[0]] + point.b[1] * length[v[1]] + point.b[2] * length[v[2]]);
            mean += point.weight * f.cf;
            for (int k = 0; k < 3; ++k) by[k] += point.weight * f.by_length * point.b[k];
        }
        sum += share * mean;
        if (!dJ_dv || !(A > 0)) continue;
        for (int k = 0; k < 3; ++k) {
            by_length[v[k]] += share * by[k];
            const Vector3d opposite = mesh.vertices.row(v[(k + 2) % 3]) - mesh.vertices.row(v[(k + 1) % 3]);
            dJ_dv->row(v[k]) += mean / flow_.reference_area * 0.5 / A * s.cross(opposite);
        }
    }
    if (!dJ_dv) return sum;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Begin& begin = begins_[static_cast<std::size_t>(v)];
        const Vector3d g = by_length[v] * axis;
        dJ_dv->row(v) += g;
        dJ_dv->row(begin.a) -= (1 - begin.t) * g;
        dJ_dv->row(begin.b) -= begin.t * g;
        const Vector3d arm =
            mesh.vertices.row(v) - (1 - begin.t) * mesh.vertices.row(begin.a) - begin.t * mesh.vertices.row(begin.b);
        *by_axis += by_length[v] * arm;
    }
    return sum;
}

void check(const std::string& name, const FrictionFlow& flow) {
    check_stream(name, flow.stream);
    const auto require = [&](bool ok, const char* what, double value, const char* limit) {
        if (!ok || !std::isfinite(value)) throw InvalidInput(text(name, ": ", what, " = ", value, " must be ", limit));
    };
    require(flow.reynolds_per_length > 0, "reynolds", flow.reynolds_per_length, "> 0");
    require(flow.mach >= 0, "mach", flow.mach, ">= 0");
    require(flow.gamma > 1 && flow.gamma <= 2, "gamma", flow.gamma, "in (1, 2]");
    require(flow.temperature > 0, "temperature", flow.temperature, "> 0");
    require(flow.reference_area > 0, "reference_area", flow.reference_area, "> 0");
    if (flow.wall_temperature) require(*flow.wall_temperature > 0, "wall_temperature", *flow.wall_temperature, "> 0");
}

}  // namespace

PlateLaw plate_law(const FrictionFlow& flow) {
    const double recovery = flow.turbulent ? std::cbrt(prandtl) : std::sqrt(prandtl);
    const double heating = 0.5 * (flow.gamma - 1) * flow.mach * flow.mach * recovery;
    const double wall = flow.wall_temperature.value_or(1 + heating);
    const double hot = 0.5 * (1 + wall) + 0.22 * heating;  // T*/T
    const double T = flow.temperature;
    const double viscosity = std::pow(hot, 1.5) * (T + sutherland) / (hot * T + sutherland);
    // cf = cf_i(Re*) rho*/rho, Re* = Re (rho*/rho) / (mu*/mu).
    const double exponent = flow.turbulent ? 0.2 : 0.5, scale = flow.turbulent ? 0.0592 : 0.664;
    return {scale / hot * std::pow(hot * viscosity, exponent), exponent};
}

Quantity friction(const std::string& name, const TriMesh& start, const FrictionFlow& flow,
                  const std::optional<SymmetryPlane>& symmetry) {
    check(name, flow);
    require_along(name, "flow", flow.stream.forward, symmetry);
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    if (start.num_triangles() == 0) throw InvalidInput(text(name, ": the surface has no triangles"));
    const auto plates = std::make_shared<const Plates>(start, flow, symmetry);
    Quantity quantity = checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        const TriMesh& mesh = request.surface;
        const StreamState at = stream_state(name, flow.stream, request.parameters);
        if (!request.wants(0)) return QuantityResult{{plates->drag(mesh, at.axes.drag, nullptr, nullptr)}, {}, {}};
        QuantityResult result;
        result.dJ_dv.push_back(Points::Zero(mesh.num_vertices(), 3));
        Vector3d by_axis = Vector3d::Zero();
        result.values.push_back(plates->drag(mesh, at.axes.drag, &result.dJ_dv[0], &by_axis));
        result.dJ_dp.push_back(own_derivatives(at, request, by_axis));
        return result;
    });
    quantity.fields = [=](const QuantityRequest& request) {
        const StreamState at = stream_state(name, flow.stream, request.parameters);
        return std::vector<SurfaceField>{{name + ".cf", plates->cf(request.surface, at.axes.drag)}};
    };
    return quantity;
}

}  // namespace strake
