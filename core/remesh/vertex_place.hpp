#pragma once
#include "core/remesh/passes.hpp"

#include <limits>
#include <numbers>

/// Vertices that are moved one after the other to the best place nearby. Internal to core/remesh.
namespace strake {

constexpr double well_shaped = 0.76;  ///< no angle below 30 degrees, or above 108

struct VertexPlace {
    Eigen::Vector3d point, normal;
    int foot;
    double s;  ///< shift along the curve
};
inline VertexPlace place_of(const WorkingMesh& mesh, int v) { return {mesh.pos[v], mesh.normal[v], mesh.foot[v], 0}; }

/// From `from` by `shift`, on the surface. @return whether it is there.
bool find_on_surface(const WorkingMesh& mesh, int v, const VertexPlace& from, const Eigen::Vector3d& shift,
                     VertexPlace& place);
/// On ridge v's curve, `shift` from where v is; the chords to its neighbours fit.
bool find_on_curve(const WorkingMesh& mesh, const StepGuard& guard, int v, double shift, VertexPlace& place);
void put(WorkingMesh& mesh, int v, const VertexPlace& place);

/// Sum of 1 / quality^4 around v were it at `place`; infinite where a triangle would face away, or, with `keeps_shape`,
/// fall below well_shaped and get worse.
double shape_cost(WorkingMesh& mesh, const StepGuard& guard, int v, const VertexPlace& place, bool keeps_shape = false);

/// The i-th trial place around `from` at `length`: six in the tangent plane of a free vertex v, two along a ridge.
/// @return whether it is there.
inline bool find_trial_place(const WorkingMesh& mesh, const StepGuard& guard, int v, const VertexPlace& from, int i,
                             double length, VertexPlace& next) {
    if (mesh.role[v] != VertexRole::free)
        return find_on_curve(mesh, guard, v, from.s + (i == 0 ? length : -length), next);
    const Eigen::Vector3d n = mesh.normal[v], u = n.unitOrthogonal(), w = n.cross(u);
    const double angle = i * std::numbers::pi / 3;
    return find_on_surface(mesh, v, from, length * (std::cos(angle) * u + std::sin(angle) * w), next);
}

/// Where cost(place, bound) is least, by steps that get shorter; a cost that surely exceeds the bound need not be
/// known.
/// @param start the cost where v is. @return whether that is noticeably better.
template <class Cost>
bool find_best_place(const WorkingMesh& mesh, const StepGuard& guard, int v, double start, const Cost& cost,
                     VertexPlace& best) {
    best = place_of(mesh, v);
    double least = start;
    const int trials = mesh.role[v] == VertexRole::free ? 6 : 2;
    for (double step = 0.2; step > 0.02; step *= 0.5)
        for (bool better = true; better;) {
            better = false;
            for (int i = 0; i < trials; ++i) {
                VertexPlace next;
                if (!find_trial_place(mesh, guard, v, best, i, step * mesh.size[v], next)) continue;
                const double c = cost(next, 0.999 * least);
                if (c > 0.999 * least) continue;
                least = c;
                best = next;
                better = true;
            }
        }
    return !(least > 0.98 * start);
}

}  // namespace strake
