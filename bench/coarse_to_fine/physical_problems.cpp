#include "bench/coarse_to_fine/makers.hpp"
#include "cases/geometry/closed_body.hpp"
#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/slender_body.hpp"
#include "cases/geometry/wing.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/aero/newtonian.hpp"
#include "objectives/aero/projected_area.hpp"
#include "objectives/aero/wave_drag.hpp"
#include "objectives/fit/target_shape.hpp"
#include "objectives/geometry/bending.hpp"
#include "objectives/geometry/measures.hpp"
#include "objectives/geometry/section_area.hpp"
#include "objectives/geometry/thickness.hpp"

#include <algorithm>
#include <cmath>

/// Problems whose optimum nobody has drawn: no parametrisation fits it by construction.
namespace strake::evidence {
namespace {

using Eigen::Vector3d;

Constraint at_least(const std::string& value, double share) {
    return {.quantity = value, .min = share, .max = {}, .equals = {}, .relative = true};
}
Constraint at_most(const std::string& value, double share) {
    return {.quantity = value, .min = {}, .max = share, .equals = {}, .relative = true};
}

/// The limit of the shape itself, so that no parametrisation ends at bounds of its own: the mean square displacement.
void limit_motion(EvidenceProblem& p, double share_of_diagonal) {
    const double moved = share_of_diagonal * box_diagonal(p.problem.surface);
    p.problem.quantities.push_back(target_shape_same("moved", p.problem.surface, p.problem.surface));
    p.problem.constraints.push_back(
        {.quantity = "moved", .min = {}, .max = moved * moved, .equals = {}, .relative = false});
}

TriMesh together(const TriMesh& a, const TriMesh& b) {
    TriMesh both;
    both.vertices.resize(a.num_vertices() + b.num_vertices(), 3);
    both.vertices << a.vertices, b.vertices;
    both.triangles.resize(a.num_triangles() + b.num_triangles(), 3);
    both.triangles << a.triangles, b.triangles.array() + a.num_vertices();
    return both;
}

/// Of the surface together with a body that is given.
Quantity beside(const TriMesh& given, const TriMesh& start, const std::function<Quantity(const TriMesh&)>& make) {
    Quantity quantity = make(together(start, given));
    quantity.fields = {};
    quantity.evaluate = [of_both = quantity.evaluate, given](const QuantityRequest& request) {
        const TriMesh both = together(request.surface, given);
        QuantityResult result = of_both({both, request.want_sensitivities, request.evaluation, request.level, {}});
        for (Points& d : result.dJ_dv)
            if (d.rows() > 0) d.conservativeResize(request.surface.num_vertices(), 3);
        return result;
    };
    return quantity;
}

/// Mean square of value / wanted - 1.
Quantity mean_square_miss(const std::string& name, const std::vector<Quantity>& values,
                          const std::vector<double>& wanted) {
    Quantity quantity;
    quantity.names = {name};
    quantity.evaluate = [=](const QuantityRequest& request) {
        QuantityResult sum;
        sum.values = {0};
        if (request.want_sensitivities) sum.dJ_dv = {Points::Zero(request.surface.num_vertices(), 3)};
        for (std::size_t i = 0; i < values.size(); ++i) {
            const QuantityResult one = values[i].evaluate(request);
            if (one.failure) return one;
            const double miss = one.values[0] / wanted[i] - 1, share = 1 / double(values.size());
            sum.values[0] += share * miss * miss;
            if (request.want_sensitivities) sum.dJ_dv[0] += 2 * share * miss / wanted[i] * one.dJ_dv[0];
        }
        return sum;
    };
    return quantity;
}

}  // namespace

EvidenceProblem wave_drag_beside_fuselage(int triangles, Draw& draw) {
    const TriMesh surface = example::tube(triangles, {.length = 4, .half_width = 0.3, .half_height = 0.25});
    EvidenceProblem p = start_of({.name = "wave_drag",
                                  .what = "pod beside a given fuselage: least wave drag of both, no less volume",
                                  .surface = surface,
                                  .ends = {0, 0.3, 3.7},
                                  .kinds = {VariableKind::normal_load},
                                  .max_displacement = 0.06,
                                  .prism_height = 0.04});
    TriMesh fuselage = example::wavy_body(400, {.length = 8,
                                                .max_radius = draw.between(0.35, 0.5),
                                                .waviness = draw.between(0.15, 0.3),
                                                .waves = draw.between(1.5, 3)});
    fuselage.vertices.rowwise() += Eigen::RowVector3d(draw.between(-2.5, -1.5), 1.5, 0);
    p.problem.quantities = {beside(fuselage, surface, [](const TriMesh& both) { return wave_drag("drag", both, {}); }),
                            volume(surface)};
    p.problem.objective = "drag";
    p.problem.constraints = {at_least("volume", 1)};
    limit_motion(p, 0.015);
    return p;
}

EvidenceProblem newtonian_lift_over_drag(int triangles, Draw& draw) {
    example::LiftingBodyShape shape;
    shape.half_width = draw.between(0.26, 0.34);
    shape.canopy_height = draw.between(0.04, 0.06);
    const TriMesh surface = example::lifting_body(std::max(triangles, 1500), shape);
    EvidenceProblem p = start_of({.name = "lift_over_drag",
                                  .what = "lifting body: most lift over drag by Newtonian pressures, no less volume",
                                  .surface = surface,
                                  .ends = {0, 0.1 * shape.length, 0.97 * shape.length},
                                  .max_displacement = 0.05});
    NewtonianFlow flow;
    flow.stream.alpha.value = radians(draw.between(8, 14));
    flow.mach = 8;
    flow.shadows = false;
    p.problem.quantities = {newtonian("aero", surface, flow), volume(surface)};
    p.problem.objective = "aero.lift_to_drag";
    p.problem.maximize = true;
    p.problem.constraints = {at_least("volume", 1)};
    limit_motion(p, 0.01);
    return p;
}

EvidenceProblem min_bending(int triangles, Draw& draw) {
    const Vector3d axes(draw.between(0.9, 1.2), draw.between(0.5, 0.7), draw.between(0.4, 0.6));
    const TriMesh surface = example::superellipsoid(triangles, {.half_axes = axes, .exponent = draw.between(3, 4)});
    EvidenceProblem p = start_of({.name = "bending_energy",
                                  .what = "brick with round edges, one end held: least bending energy, the same volume",
                                  .surface = surface,
                                  .ends = {0, -0.7 * axes.x(), {}},
                                  .kinds = {VariableKind::normal_load},
                                  .max_displacement = 0.1,
                                  .prism_height = 0.05});
    p.problem.quantities = {bending_energy("bending", surface), volume(surface)};
    p.problem.objective = "bending";
    p.problem.constraints = {{.quantity = "volume", .min = {}, .max = {}, .equals = 1, .relative = true}};
    return p;
}

EvidenceProblem wing_within_thickness(int triangles, Draw& draw) {
    example::WingShape shape;
    shape.sweep_deg = draw.between(15, 35);
    shape.taper = draw.between(0.4, 0.7);
    shape.thickness = draw.between(0.095, 0.125);
    const TriMesh surface = example::wing(std::max(triangles, 1000), shape);
    EvidenceProblem p = start_of({.name = "wing_volume",
                                  .what = "wing: most volume with no more thickness at six stations and 1 % more area",
                                  .surface = surface,
                                  .ends = {1, 0.05, {}},
                                  .kinds = {VariableKind::normal_load},
                                  .max_displacement = 0.05});
    p.problem.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
    std::vector<ThicknessLine> lines;
    for (const double span : {0.25, 0.55, 0.85})
        for (const double chord : {0.25, 0.6}) {
            const double y = span * shape.semi_span;
            const double x =
                y * std::tan(radians(shape.sweep_deg)) + chord * shape.root_chord * (1 + span * (shape.taper - 1));
            lines.push_back({Vector3d(x, y, 0), Vector3d::UnitZ(), {}});
        }
    p.problem.quantities = {volume(surface, p.problem.symmetry), area(),
                            thickness("thickness", surface, lines, ThicknessValues::each)};
    p.problem.objective = "volume";
    p.problem.maximize = true;
    p.problem.constraints = {at_most("area", 1.01)};
    for (std::size_t i = 1; i <= lines.size(); ++i)
        p.problem.constraints.push_back(at_most(text("thickness.", i), draw.between(1, 1.1)));
    limit_motion(p, 0.01);
    return p;
}

EvidenceProblem min_frontal_area(int triangles, Draw& draw) {
    example::FuselageShape shape;
    shape.nacelle_angle_deg = draw.between(65, 95);
    shape.nacelle_height = draw.between(0.45, 0.65);
    const TriMesh surface = example::fuselage(triangles, shape);
    EvidenceProblem p = start_of({.name = "frontal_area",
                                  .what = "fuselage with nacelles: least frontal area, no less volume, 1 % more area",
                                  .surface = surface,
                                  .ends = {0, 0.1 * shape.length, 0.95 * shape.length},
                                  .max_displacement = 0.05});
    p.problem.quantities = {projected_area("frontal", surface, {}), volume(surface), area()};
    p.problem.objective = "frontal";
    p.problem.constraints = {at_least("volume", 1), at_most("area", 1.01)};
    limit_motion(p, 0.01);
    return p;
}

EvidenceProblem wanted_section_areas(int triangles, Draw& draw) {
    example::FuselageShape shape;
    shape.nacelle_angle_deg = draw.between(65, 95);
    const TriMesh surface = example::fuselage(triangles, shape);
    EvidenceProblem p = start_of({.name = "section_areas",
                                  .what = "fuselage with nacelles: areas of ten sections as wanted, 2 % more area",
                                  .surface = surface,
                                  .ends = {0, 0.05 * shape.length, 0.97 * shape.length},
                                  .kinds = {VariableKind::normal_load},
                                  .max_displacement = 0.06});
    std::vector<Quantity> sections;
    std::vector<double> wanted;
    for (int i = 0; i < 10; ++i) {
        const double at = (0.14 + 0.075 * i + 1e-4) * shape.length;
        sections.push_back(section_area(text("section_", i), surface, {Vector3d::UnitX(), at, {}}));
        wanted.push_back(draw.between(0.85, 1.2) * sections.back().evaluate({surface, false, 0, 0, {}}).values.at(0));
    }
    p.problem.quantities = {mean_square_miss("miss", sections, wanted), area()};
    p.problem.objective = "miss";
    p.problem.constraints = {at_most("area", 1.02)};
    return p;
}

}  // namespace strake::evidence
