#include "bench/coarse_to_fine/makers.hpp"
#include "cases/geometry/closed_body.hpp"
#include "cases/geometry/lifting_body.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/fit/target_shape.hpp"
#include "objectives/geometry/measures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace strake::evidence {

using Eigen::Vector3d;

EvidenceProblem lifting_body_recovery(int triangles, Draw& draw) {
    example::LiftingBodyShape shape;
    shape.half_width = draw.between(0.27, 0.33);
    const TriMesh surface = example::lifting_body(std::max(triangles, 1500), shape);
    const double L = shape.length, droop = draw.sign() * draw.between(0.03, 0.05) * L;
    const double at = draw.between(0.45, 0.6) * L, height = draw.between(0.012, 0.02) * L;
    EvidenceProblem p = start_of({.name = "lifting_body",
                                  .what = "lifting body with the nose drooped and a higher canopy, by formula",
                                  .surface = surface,
                                  .ends = {0, {}, 0.97 * L},
                                  .max_displacement = 0.08});
    recover_vertices(p, warped(surface, p.ends, [=](const Vector3d& q) {
                         const double s = 1 - q.x() / L;
                         const double canopy =
                             gauss(std::hypot(q.x() - at, q.y()), 0.1 * L) * smooth_step(q.z() / (0.05 * L));
                         return Vector3d(0, 0, droop * s * s + height * canopy);
                     }));
    return p;
}

EvidenceProblem fuselage_recovery(int triangles, Draw& draw) {
    example::FuselageShape shape;
    shape.nacelle_angle_deg = draw.between(65, 95);
    const TriMesh surface = example::fuselage(triangles, shape);
    const double L = shape.length, droop = -draw.between(0.02, 0.04) * L, grow = draw.between(0.12, 0.2);
    const double a = radians(shape.nacelle_angle_deg), r = 1.2 * shape.radius;
    const Vector3d centre(0.5 * L * (shape.nacelle_begin + shape.nacelle_end), r * std::sin(a), r * std::cos(a));
    EvidenceProblem p = start_of({.name = "fuselage_nacelle",
                                  .what = "fuselage with larger nacelles and a drooped nose, by formula",
                                  .surface = surface,
                                  .ends = {0, {}, 0.88 * L},
                                  .max_displacement = 0.06,
                                  .prism_height = 0.03});
    recover_shape(p, warped(surface, p.ends, [=](const Vector3d& q) {
                      const Vector3d mirrored(q.x(), std::abs(q.y()), q.z()), arm = mirrored - centre;
                      const double near = gauss(arm.norm(), 0.13 * L), s = 1 - q.x() / L;
                      Vector3d d = grow * near * Vector3d(0.3 * arm.x(), mirrored.y(), mirrored.z());
                      if (q.y() < 0) d.y() = -d.y();
                      return Vector3d(d + droop * s * s * Vector3d::UnitZ());
                  }));
    return p;
}

namespace {

/// Point of a straight tube carried to a circular arc in the plane of x and z that turns by `angle` over `length`.
Vector3d on_arc(const Vector3d& p, double length, double angle) {
    const double radius = length / angle, phi = p.x() / radius;
    return {(radius - p.z()) * std::sin(phi), p.y(), radius - (radius - p.z()) * std::cos(phi)};
}

}  // namespace

EvidenceProblem bent_tube(int triangles, Draw& draw) {
    const example::TubeShape shape{.length = 4, .half_width = 0.4, .half_height = 0.4};
    const double before = radians(draw.between(35, 45)), after = before + radians(draw.between(5, 9));
    const double sway = draw.sign() * draw.between(0.15, 0.25), elbow = draw.between(0.45, 0.65);
    const TriMesh straight = example::tube(triangles, shape);
    TriMesh surface = straight, target = straight;
    for (int k = 0; k < straight.num_vertices(); ++k) {
        const Vector3d p = straight.vertices.row(k);
        const double t = smooth_step((p.x() - 0.35) / 0.4), s = p.x() / shape.length;
        const Vector3d from = on_arc(p, shape.length, before), to = on_arc(p, shape.length, after);
        surface.vertices.row(k) = from;
        target.vertices.row(k) =
            from + t * (to - from + sway * shape.length * soft_ramp(s - elbow, 0.08) * Vector3d::UnitY());
    }
    EvidenceProblem p = start_of({.name = "bent_tube",
                                  .what = "bent tube bent further, with an elbow out of its plane, by formula",
                                  .surface = surface,
                                  .ends = {0, 0.3, {}},
                                  .max_displacement = 0.15,
                                  .prism_height = 0.04});
    recover_vertices(p, target);
    return p;
}

namespace {

/// Along the radius: bumps (amplitude, width) about directions.
struct RadialBump {
    Vector3d direction;
    double amplitude, width;
};

Displacement radial(const std::vector<RadialBump>& bumps) {
    return [=](const Vector3d& p) {
        double sum = 0;
        for (const RadialBump& b : bumps) sum += b.amplitude * gauss((p.normalized() - b.direction).norm(), b.width);
        return Vector3d(sum * p.normalized());
    };
}

}  // namespace

EvidenceProblem blob(int triangles, Draw& draw) {
    const TriMesh surface = example::sphere(triangles);
    std::vector<RadialBump> bumps;
    while (bumps.size() < 7) {
        const Vector3d direction = draw.direction();
        if (direction.z() < -0.4) continue;
        bumps.push_back({direction, draw.sign() * draw.between(0.08, 0.16), draw.between(0.45, 0.75)});
    }
    EvidenceProblem p = start_of({.name = "blob",
                                  .what = "sphere to a bumpy one, by formula",
                                  .surface = surface,
                                  .ends = {2, -0.8, {}},
                                  .kinds = {VariableKind::normal_load},
                                  .max_displacement = 0.08,
                                  .prism_height = 0.05});
    recover_shape(p, warped(surface, p.ends, radial(bumps)));
    return p;
}

EvidenceProblem bunny_like(int triangles, Draw& draw) {
    const Vector3d head = Vector3d(1, 0, draw.between(0.5, 0.8)).normalized();
    const double apart = draw.between(0.22, 0.32);
    const Vector3d left = Vector3d(0.45, -apart, 1).normalized(), right = Vector3d(0.45, apart, 1).normalized();
    const std::vector<RadialBump> bumps{{head, draw.between(0.15, 0.22), 0.55},
                                        {left, draw.between(0.22, 0.3), 0.24},
                                        {right, draw.between(0.22, 0.3), 0.24},
                                        {Vector3d(-0.95, 0, -0.3).normalized(), draw.between(0.08, 0.14), 0.3},
                                        {Vector3d(-0.5, 0, 0.87), draw.between(-0.12, -0.06), 0.6}};
    const HeldEnds ends{2, -0.8, {}};
    EvidenceProblem p =
        start_of({.name = "bunny_like",
                  .what = "sphere to head, ears and tail, by formula, on other triangles (closest point)",
                  .surface = example::sphere(triangles),
                  .ends = ends,
                  .max_displacement = 0.1,
                  .prism_height = 0.05});
    recover_shape(p, warped(example::sphere(2 * triangles), ends, radial(bumps)));
    return p;
}

EvidenceProblem lifting_body_volume(int triangles, Draw& draw) {
    example::LiftingBodyShape shape;
    shape.half_width = draw.between(0.26, 0.34);
    shape.canopy_height = draw.between(0.04, 0.06);
    EvidenceProblem p = start_of(
        {.name = "volume_under_area",
         .what = "lifting body: most volume, area at most 1 % more, moved by at most 1 % of the diagonal (rms)",
         .surface = example::lifting_body(std::max(triangles, 1500), shape),
         .ends = {0, 0.1 * shape.length, 0.97 * shape.length},
         .kinds = {VariableKind::normal_load},
         .max_displacement = 0.08});
    // Limits of the shape itself, so that none of the parametrisations ends at bounds of its own.
    const double moved = 0.01 * box_diagonal(p.problem.surface);
    p.problem.quantities = {volume(p.problem.surface), area(),
                            target_shape_same("moved", p.problem.surface, p.problem.surface)};
    p.problem.objective = "volume";
    p.problem.maximize = true;
    p.problem.constraints = {{.quantity = "area", .min = {}, .max = 1.01, .equals = {}, .relative = true},
                             {.quantity = "moved", .min = {}, .max = moved * moved, .equals = {}, .relative = false}};
    p.second = Method::mma;
    return p;
}

EvidenceProblem local_bump(int triangles, Draw& draw) {
    const TriMesh surface = example::tube(triangles, {.length = 4, .half_width = 0.6, .half_height = 0.6});
    EvidenceProblem p = start_of({.name = "local_bump",
                                  .what = "tube with a bump about as large as one patch of the last level, by formula",
                                  .surface = surface,
                                  .ends = {0, 0.3, {}},
                                  .kinds = {VariableKind::normal_load},
                                  .max_displacement = 0.15});
    const auto& patches = p.problem.tree.levels.back().patches;
    std::vector<std::pair<Vector3d, double>> places;  // of patches well inside: centre and radius
    for (const Patch& patch : patches) {
        const Vector3d centre = area_centroid(surface, patch.triangles);
        if (centre.x() > 1 && centre.x() < 3.2) places.emplace_back(centre, std::sqrt(patch.area / 3.14159));
    }
    const auto [inner, radius] = places.at(static_cast<std::size_t>(draw.between(0, 1) * double(places.size())));
    const Vector3d outward = Vector3d(0, inner.y(), inner.z()).normalized();
    const Vector3d centre = Vector3d(inner.x(), 0, 0) + 0.6 * outward;
    const double height = draw.between(0.06, 0.09), reach = 2 * radius;
    recover_shape(p, warped(surface, p.ends, [=](const Vector3d& q) {
                      const double s = std::max(0.0, 1 - (q - centre).squaredNorm() / (reach * reach));
                      return Vector3d(height * s * s * s * Vector3d(0, q.y(), q.z()).normalized());
                  }));
    return p;
}

EvidenceProblem global_twist(int triangles, Draw& draw) {
    const TriMesh surface = example::tube(triangles, {.length = 4, .half_width = 0.7, .half_height = 0.35});
    EvidenceProblem p = start_of({.name = "global_twist",
                                  .what = "flat tube twisted about its axis, by formula; strain variables",
                                  .surface = surface,
                                  .ends = {0, 0.4, {}},
                                  .kinds = {VariableKind::strain},
                                  .max_displacement = 0.08,
                                  .patches = {4, 12, 36},
                                  .prism_height = 0.04});
    const double twist = radians(draw.sign() * draw.between(12, 18));
    recover_vertices(p, warped(surface, p.ends, [=](const Vector3d& q) {
                         const double t = std::max(0.0, (q.x() - 0.4) / 3.6);
                         return Vector3d(Eigen::AngleAxisd(twist * t, Vector3d::UnitX()) * q - q);
                     }));
    return p;
}

EvidenceProblem noisy(int triangles, Draw& draw) {
    const TriMesh surface = example::tube(triangles, {.length = 4, .half_width = 0.5, .half_height = 0.4});
    EvidenceProblem p = start_of({.name = "noisy",
                                  .what = "tube bent and swollen by formula, objective with relative noise of 1e-4",
                                  .surface = surface,
                                  .ends = {0, 0.3, {}},
                                  .prism_height = 0.04});
    const double bend = draw.sign() * draw.between(0.15, 0.3), swell = draw.between(0.12, 0.2);
    const double at = draw.between(1.5, 2.5);
    recover_shape(p, warped(surface, p.ends, [=](const Vector3d& q) {
                      const double t = q.x() / 4, grow = swell * gauss(q.x() - at, 0.7);
                      return Vector3d(0, grow * q.y(), grow * q.z() + bend * t * t);
                  }));
    p.problem.quantities = {
        with_noise("match", p.problem.quantities[0], surface, static_cast<std::uint64_t>(draw.between(0, 1e9)))};
    return p;
}

}  // namespace strake::evidence
