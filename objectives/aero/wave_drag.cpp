#include "objectives/aero/wave_drag.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/aero/area_distribution.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <numbers>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double pi = std::numbers::pi;
/// Of the length: a flat base that is not stated has its area just ahead of the end. Where it is stated the body goes
/// on as a cylinder, and the area at the end itself is the base's.
constexpr double end_inset = 1e-3;

/// The quadratic form of the areas at the stations, ends included.
struct AreaForm {
    std::vector<double> stations;
    VectorXd base;            ///< u at the inner ones
    Eigen::MatrixXd inverse;  ///< of P

    AreaForm(int inner, bool has_base) {
        std::vector<double> k;
        for (int i = 1; i <= inner; ++i) k.push_back(static_cast<double>(i) / (inner + 1));
        base.resize(inner);
        for (int i = 0; i < inner; ++i) base[i] = eminton_base(k[static_cast<std::size_t>(i)]);
        inverse = eminton_matrix(k).ldlt().solve(Eigen::MatrixXd::Identity(inner, inner));
        stations.push_back(end_inset);
        stations.insert(stations.end(), k.begin(), k.end());
        stations.push_back(has_base ? 1 : 1 - end_inset);
    }

    /// D/q of these areas over a length; derivatives by both.
    double drag(const VectorXd& areas, double length, VectorXd& by_area, double& by_length) const {
        const Eigen::Index n = base.size();
        const double B = areas[n + 1] - areas[0];
        const VectorXd c = areas.segment(1, n).array() - areas[0] - (B * base).array();
        const VectorXd f = inverse * c;
        const double scale = 4 / (length * length), D = scale * (B * B / pi + pi * c.dot(f));
        by_area = VectorXd::Zero(n + 2);
        by_area.segment(1, n) = 2 * pi * scale * f;
        const double by_base = 2 * scale * (B / pi - pi * base.dot(f));
        by_area[n + 1] = by_base;
        by_area[0] = -by_base - 2 * pi * scale * f.sum();
        by_length = -2 * D / length;
        return D;
    }
};

/// Normals of the sections, one for each roll angle.
std::vector<AreaCuts> cuts_of(const WaveDrag& flow, const AreaForm& form) {
    const Vector3d x = flow.forward.stableNormalized(), y = x.unitOrthogonal(), z = x.cross(y);
    if (flow.mach == 1) return {{x, x, form.stations, flow.base}};
    const double beta = std::sqrt(flow.mach * flow.mach - 1);
    std::vector<AreaCuts> cuts;
    for (int i = 0; i < flow.angles; ++i) {
        const double phi = 2 * pi * i / flow.angles;
        cuts.push_back({x, x - beta * (std::cos(phi) * y + std::sin(phi) * z), form.stations, flow.base});
    }
    return cuts;
}

void check(const std::string& name, const TriMesh& start, const WaveDrag& flow,
           const std::optional<SymmetryPlane>& symmetry) {
    const auto refuse = [&](const char* what, double value, const char* limit) {
        throw InvalidInput(text(name, ": ", what, " = ", value, " must be ", limit));
    };
    if (!flow.forward.allFinite() || flow.forward.isZero(0)) refuse("|forward|", flow.forward.norm(), "> 0 and finite");
    if (!(flow.mach >= 1) || !std::isfinite(flow.mach)) refuse("mach", flow.mach, ">= 1 and finite");
    if (flow.stations < 4 || flow.stations > 400) refuse("stations", flow.stations, "in [4, 400]");
    if (flow.angles < 1 || flow.angles > 360) refuse("angles", flow.angles, "in [1, 360]");
    if (!(flow.reference_area > 0) || !std::isfinite(flow.reference_area))
        refuse("reference_area", flow.reference_area, "> 0 and finite");
    if (!flow.base.empty() && static_cast<int>(flow.base.size()) != start.num_triangles())
        refuse("marks of the base", static_cast<double>(flow.base.size()), "one for each triangle");
    require_along(name, "flow", flow.forward, symmetry);
    if (flow.beside.num_triangles() == 0) return;
    const std::string beside = text(name, ": the surface beside it");
    if (const auto failure = vertices_finite(beside, flow.beside)) throw InvalidInput(failure->message);
    require_closed(beside, flow.beside, symmetry);
}

/// Around a point of its own, so that a surface far from the origin keeps its sign.
bool faces_outward(const TriMesh& mesh) {
    const Eigen::RowVector3d middle = mesh.vertices.colwise().mean();
    double volume = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0)) - middle;
        volume += a.dot(area_vector(mesh, t));
    }
    return volume > 0;
}

/// The surface, and behind its vertices and triangles those beside it, which face the same way.
TriMesh joined(const TriMesh& surface, const TriMesh& beside, bool is_turned) {
    TriMesh both;
    both.vertices.resize(surface.num_vertices() + beside.num_vertices(), 3);
    both.vertices << surface.vertices, beside.vertices;
    both.triangles.resize(surface.num_triangles() + beside.num_triangles(), 3);
    both.triangles << surface.triangles, (beside.triangles.array() + surface.num_vertices()).matrix();
    if (is_turned)
        both.triangles.bottomRows(beside.num_triangles())
            .col(1)
            .swap(both.triangles.bottomRows(beside.num_triangles()).col(2));
    return both;
}

}  // namespace

double eminton_base(double k) { return (std::acos(1 - 2 * k) - 2 * (1 - 2 * k) * std::sqrt(k * (1 - k))) / pi; }

Eigen::MatrixXd eminton_matrix(const std::vector<double>& stations) {
    const auto n = static_cast<Eigen::Index>(stations.size());
    Eigen::MatrixXd P(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j) {
            const double a = stations[static_cast<std::size_t>(i)], b = stations[static_cast<std::size_t>(j)];
            const double sum = a + b - 2 * a * b, root = std::sqrt(a * b * (1 - a) * (1 - b)), d2 = (a - b) * (a - b);
            P(i, j) = 8 * sum * root;
            // (sum - 2 root)(sum + 2 root) = d2, which avoids cancellation between close stations.
            if (i != j) P(i, j) -= 4 * d2 * std::log((sum + 2 * root) / std::abs(a - b));
        }
    return P;
}

Quantity wave_drag(const std::string& name, const TriMesh& start, const WaveDrag& flow,
                   const std::optional<SymmetryPlane>& symmetry) {
    check(name, start, flow, symmetry);
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    require_closed(name, start, symmetry);
    const bool has_beside = flow.beside.num_triangles() > 0;
    const bool is_turned = has_beside && faces_outward(start) != faces_outward(flow.beside);
    WaveDrag all_flow = flow;
    if (!flow.base.empty())
        all_flow.base.resize(flow.base.size() + static_cast<std::size_t>(flow.beside.num_triangles()), 0);
    const auto form = std::make_shared<const AreaForm>(flow.stations, !flow.base.empty());
    std::vector<AreaCuts> all = cuts_of(all_flow, *form);
    if (symmetry)
        for (AreaCuts& cuts : all)
            cuts.excluded.insert(cuts.excluded.end(), all_flow.base.begin(), all_flow.base.end());
    return checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        const TriMesh both = has_beside ? joined(request.surface, flow.beside, is_turned) : TriMesh();
        const TriMesh& half = has_beside ? both : request.surface;
        const TriMesh whole = symmetry ? whole_of(half, *symmetry) : TriMesh();
        const TriMesh& mesh = symmetry ? whole : half;
        // Orientation does not matter: the drag is even in S.
        const double share = (symmetry ? 0.5 : 1) / flow.reference_area / static_cast<double>(all.size());
        double sum = 0;
        Points dJ_dv = request.wants(0) ? Points(Points::Zero(mesh.num_vertices(), 3)) : Points();
        for (const AreaCuts& cuts : all) {
            const AreaDistribution at = area_distribution(mesh, cuts);
            VectorXd by_area;
            double by_length = 0;
            if (!(at.end > at.begin)) throw InvalidInput(text(name, ": the surface has zero length along the flow"));
            sum += share * form->drag(at.area, at.end - at.begin, by_area, by_length);
            if (dJ_dv.rows() > 0)
                add_area_gradient(mesh, cuts, at, share * by_area, -share * by_length, share * by_length, dJ_dv);
        }
        if (symmetry && dJ_dv.rows() > 0) dJ_dv = folded(dJ_dv, *symmetry);
        if (has_beside && dJ_dv.rows() > 0) dJ_dv.conservativeResize(request.surface.num_vertices(), 3);
        return one_value(sum, std::move(dJ_dv));
    });
}

}  // namespace strake
