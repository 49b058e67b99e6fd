#include "core/repair/joint_gap.hpp"

#include "core/mesh/disjoint_sets.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace strake {
namespace {

using Eigen::Vector3d;

std::array<Vector3d, 3> corners(const TriMesh& mesh, const Points& x, int t) {
    return {x.row(mesh.triangles(t, 0)), x.row(mesh.triangles(t, 1)), x.row(mesh.triangles(t, 2))};
}

/// Of the points where edges of triangle s pierce triangle t.
double gap_of(const TriMesh& mesh, const Points& moved, int s, int t) {
    const auto edge = corners(mesh, mesh.vertices, s), edge_now = corners(mesh, moved, s),
               face = corners(mesh, mesh.vertices, t), face_now = corners(mesh, moved, t);
    const Vector3d& a = face[0];
    const Vector3d ab = face[1] - a, ac = face[2] - a, n = ab.cross(ac);
    double gap = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3;
        const double along = n.dot(a - edge[k]) / n.dot(edge[l] - edge[k]);
        if (!(along >= 0 && along <= 1)) continue;
        const Vector3d x = edge[k] + along * (edge[l] - edge[k]);
        const double b = n.dot((x - a).cross(ac)) / n.squaredNorm(), c = n.dot(ab.cross(x - a)) / n.squaredNorm();
        if (!(b >= 0 && c >= 0 && b + c <= 1)) continue;
        const Vector3d of_edge = (1 - along) * edge_now[k] + along * edge_now[l],
                       of_face = (1 - b - c) * face_now[0] + b * face_now[1] + c * face_now[2];
        gap = std::max(gap, (of_edge - of_face).norm());
    }
    return gap;
}

}  // namespace

std::vector<int> part_of_triangles(const TriMesh& mesh) {
    DisjointSets sets(mesh.num_vertices());
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 1; k < 3; ++k) sets.join(mesh.triangles(t, 0), mesh.triangles(t, k));
    std::vector<int> part(static_cast<std::size_t>(mesh.num_triangles()));
    for (int t = 0; t < mesh.num_triangles(); ++t) part[static_cast<std::size_t>(t)] = sets.root(mesh.triangles(t, 0));
    return part;
}

double joint_gap(const TriMesh& mesh, const std::vector<std::array<int, 2>>& intersecting, const Points& moved) {
    const std::vector<int> part = part_of_triangles(mesh);
    double gap = 0;
    for (const auto& [s, t] : intersecting)
        if (part[static_cast<std::size_t>(s)] != part[static_cast<std::size_t>(t)])
            gap = std::max({gap, gap_of(mesh, moved, s, t), gap_of(mesh, moved, t, s)});
    return gap;
}

}  // namespace strake
