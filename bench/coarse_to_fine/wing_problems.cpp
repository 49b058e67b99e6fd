#include "bench/coarse_to_fine/makers.hpp"
#include "cases/geometry/wing.hpp"
#include "objectives/geometry/measures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace strake::evidence {

using Eigen::Vector3d;

namespace {

TriMesh wing_of(int triangles, Draw& draw, example::WingShape& shape) {
    shape.sweep_deg = draw.between(20, 35);
    shape.taper = draw.between(0.45, 0.65);
    shape.thickness = draw.between(0.095, 0.125);
    return example::wing(std::max(triangles, 1000), shape);
}

/// Bent by the square of the span with a break of the dihedral, twisted about the quarter chord outside of another
/// station: what designers draw, and no polynomial.
Displacement bend_and_twist(const example::WingShape& shape, Draw& draw) {
    const double twist = radians(draw.sign() * draw.between(6, 10));
    const double bend = draw.sign() * draw.between(0.03, 0.06) * shape.semi_span;
    const double kink = draw.sign() * draw.between(0.15, 0.25), kink_at = draw.between(0.5, 0.7);
    const double twist_from = draw.between(0.25, 0.5);
    const double slope = std::tan(radians(shape.sweep_deg));
    return [=](const Vector3d& p) {
        const double t = p.y() / shape.semi_span;
        const Vector3d axis(p.y() * slope + 0.25 * shape.root_chord * (1 + t * (shape.taper - 1)), p.y(), 0);
        const Vector3d arm = p - axis;
        const double up = bend * t * t + kink * shape.semi_span * soft_ramp(t - kink_at, 0.08);
        const double turn = twist * smooth_step((t - twist_from) / (1 - twist_from));
        return Vector3d(Eigen::AngleAxisd(turn, Vector3d::UnitY()) * arm - arm + up * Vector3d::UnitZ());
    };
}

}  // namespace

EvidenceProblem wing_recovery(int triangles, Draw& draw) {
    example::WingShape shape;
    const TriMesh surface = wing_of(triangles, draw, shape);
    EvidenceProblem p = start_of({.name = "wing",
                                  .what = "wing bent and twisted by formula",
                                  .surface = surface,
                                  .ends = {1, 0.05, {}},
                                  .max_displacement = 0.15});
    recover_vertices(p, warped(surface, p.ends, bend_and_twist(shape, draw)));
    return p;
}

namespace {

/// Upper vertices nearest to stations along span and chord, each with its mirror image below.
std::vector<std::pair<int, int>> thickness_pairs(const TriMesh& wing, const example::WingShape& shape) {
    std::map<std::pair<double, double>, int> below;
    for (int v = 0; v < wing.num_vertices(); ++v)
        if (wing.vertices(v, 2) < 0) below[{wing.vertices(v, 0), wing.vertices(v, 1)}] = v;
    std::vector<std::pair<int, int>> pairs;
    for (const double span : {0.2, 0.4, 0.6, 0.8})
        for (const double chord : {0.15, 0.35, 0.6, 0.8}) {
            const double y = span * shape.semi_span;
            const double x =
                y * std::tan(radians(shape.sweep_deg)) + chord * shape.root_chord * (1 + span * (shape.taper - 1));
            int nearest = -1;
            double least = std::numeric_limits<double>::infinity();
            for (int v = 0; v < wing.num_vertices(); ++v) {
                const double d = std::hypot(wing.vertices(v, 0) - x, wing.vertices(v, 1) - y);
                if (wing.vertices(v, 2) > 0 && d < least) least = d, nearest = v;
            }
            pairs.emplace_back(nearest, below.at({wing.vertices(nearest, 0), wing.vertices(nearest, 1)}));
        }
    return pairs;
}

}  // namespace

EvidenceProblem wing_under_limits(int triangles, Draw& draw) {
    example::WingShape shape;
    const TriMesh surface = wing_of(triangles, draw, shape);
    EvidenceProblem p =
        start_of({.name = "volume_under_limits",
                  .what = "wing: most volume under area, thickness (least, most) and change of curvature",
                  .surface = surface,
                  .ends = {1, 0.05, 0.95 * shape.semi_span},
                  .kinds = {VariableKind::normal_load},
                  .max_displacement = 0.08});
    p.problem.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
    p.problem.quantities = {volume(surface, p.problem.symmetry), area(),
                            pair_thickness(surface, thickness_pairs(surface, shape)), curvature_change(surface)};
    p.problem.objective = "volume";
    p.problem.maximize = true;
    p.problem.constraints = {
        {.quantity = "area", .min = {}, .max = 1.001, .equals = {}, .relative = true},
        {.quantity = "thinnest", .min = 0.98, .max = {}, .equals = {}, .relative = false},
        {.quantity = "thickest", .min = {}, .max = 1.25, .equals = {}, .relative = false},
        {.quantity = "curvature_change", .min = {}, .max = draw.between(0.8, 1.2), .equals = {}, .relative = false}};
    p.second = Method::mma;
    return p;
}

EvidenceProblem many_minima(int triangles, Draw& draw) {
    example::WingShape shape;
    const TriMesh surface = wing_of(triangles, draw, shape);
    EvidenceProblem p = start_of({.name = "many_minima",
                                  .what = "wing bent and twisted by formula, objective with ripples",
                                  .surface = surface,
                                  .ends = {1, 0.05, {}},
                                  .max_displacement = 0.15});
    const TriMesh target = warped(surface, p.ends, bend_and_twist(shape, draw));
    recover_vertices(p, target);
    std::vector<std::vector<int>> parcels(6);  // strips along the span, the held root left out
    for (int v = 0; v < surface.num_vertices(); ++v) {
        const double s = (surface.vertices(v, 1) / shape.semi_span - 0.25) / 0.75;
        if (s >= 0) parcels[std::min<std::size_t>(5, static_cast<std::size_t>(6 * s))].push_back(v);
    }
    p.problem.quantities = {with_ripples("match", p.problem.quantities[0], surface, target.vertices, parcels, 0.1)};
    return p;
}

}  // namespace strake::evidence
