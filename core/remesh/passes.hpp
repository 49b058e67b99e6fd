#pragma once
#include "core/parallel.hpp"
#include "core/remesh/working_mesh.hpp"

#include <algorithm>
#include <cmath>

/// The four operations of Algorithm 2, each as one pass over the surface. Internal to core/remesh.
namespace strake {

/// Limits that every operation respects.
struct StepGuard {
    double chord_slack;         ///< largest distance of the input's curves from their chords
    double cos_natural;         ///< normals may always deviate from the input's by this
    double cos_turn, sin_turn;  ///< and by this much more where they already do
    int threads;
};

/// One triangle compared with the input.
struct Facing {
    double dot;      ///< smallest cosine between its normal and the input's at its free corners; 2: no free corner
    double quality;  ///< shape_quality
    Eigen::Vector3d normal;
};
inline Facing facing(const WorkingMesh& mesh, int a, int b, int c, const Eigen::Vector3d& pa, const Eigen::Vector3d& pb,
                     const Eigen::Vector3d& pc) {
    Facing f;
    f.normal = (pb - pa).cross(pc - pa);
    const double twice_area = f.normal.norm();
    const double ab = (pb - pa).squaredNorm(), bc = (pc - pb).squaredNorm(), ca = (pa - pc).squaredNorm();
    f.quality = ab + bc + ca > 0 ? 3.4641016151377544 * twice_area / (ab + bc + ca) : 0;
    if (twice_area > 0) f.normal /= twice_area;
    f.dot = 2;
    for (const int v : {a, b, c})
        if (mesh.role[v] == VertexRole::free && !mesh.bent[v]) f.dot = std::min(f.dot, f.normal.dot(mesh.normal[v]));
    return f;
}
inline Facing facing(const WorkingMesh& mesh, int a, int b, int c) {
    return facing(mesh, a, b, c, mesh.pos[a], mesh.pos[b], mesh.pos[c]);
}
/// The smallest cosine allowed where it was `before`. Backward-facing triangles are never accepted: they would spread.
/// Barely forward-facing ones are: at a rounded edge all triangles are.
inline double allowed_dot(const StepGuard& guard, double before) {
    if (before >= guard.cos_natural) return guard.cos_natural;
    const double sine = std::sqrt(std::max(0.0, 1 - before * before));
    return std::clamp(before * guard.cos_turn - sine * guard.sin_turn, before > 0 ? 0.005 : 0.05, guard.cos_natural);
}
constexpr double no_area = 1e-6;  ///< quality below which a triangle's normal is meaningless
/// Whether `made` faces another direction than `old`, or that direction was wrong or unknown.
inline bool has_turned(const StepGuard& guard, const Facing& old, const Facing& made) {
    return old.quality < 0.02 || old.dot < 0.05 || made.normal.dot(old.normal) < guard.cos_turn;
}

int split_long(WorkingMesh& mesh, double factor);
int collapse_short(WorkingMesh& mesh, const StepGuard& guard, double factor, double longest);
int flip_edges(WorkingMesh& mesh, const StepGuard& guard);
/// Centres spread vertices evenly; equilateral triangles are the finish, with the worst of them counting most.
enum class Towards { centres, equilateral };
/// Moves vertices along the surface. @return the largest move in target lengths.
double smooth(WorkingMesh& mesh, const StepGuard& guard, Towards goal);

/// Moves the vertices of triangles with quality below `below` to maximize the worst quality around each.
/// @return how many moved.
int polish(WorkingMesh& mesh, const StepGuard& guard, double below);

/// No edge becomes folded by more than `max_fold`, radians. Brings edges that deviate from the input by more than
/// `share` of their target length closer to it, worst first.
/// @return number of flips and moves
int approach(WorkingMesh& mesh, const StepGuard& guard, double share, double max_fold);

/// Restores the fold of creases of the input, sharper than `angle`, radians, that adjacent triangles have flattened.
/// @return their number
int restore_folds(WorkingMesh& mesh, const StepGuard& guard, double angle);

/// The two features at a ridge: the one that ends there and the one that begins there; -1: none.
struct RidgeEdges {
    int before = -1, after = -1;
};
RidgeEdges ridge_edges(const WorkingMesh& mesh, int v);

/// Quickly rules out most edges that cannot be far from the input. Smoothly varying normals would hide a fold between
/// long triangles.
inline bool may_be_far(const WorkingMesh& mesh, int h) {
    const int a = mesh.from(h), b = mesh.to(h);
    const bool a_tells = mesh.role[a] == VertexRole::free, b_tells = mesh.role[b] == VertexRole::free;
    if (!a_tells || !b_tells) return a_tells || b_tells;
    return mesh.base->normal[mesh.foot[a]].dot(mesh.base->normal[mesh.foot[b]]) < 0.985;
}

/// Calls f(begin, end) on parts of 0..n; results must not depend on the partition.
template <class Work>
void in_parts(int n, int threads, const Work& f) {
    for_blocks(n, 500, f, threads);
}

}  // namespace strake
