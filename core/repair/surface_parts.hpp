#pragma once
#include "core/repair/checkup.hpp"
#include "core/repair/repair_options.hpp"

#include <functional>

/// The surface under repair, and the individual repairs. Internal to repair.cpp.
namespace strake::mending {

/// Vertices keep their numbers until the end; new ones are appended.
struct Surface {
    TriMesh mesh;
    std::vector<int> source;  ///< per triangle, as RepairResult::source_triangle
    int input_vertices = 0;
    double diagonal = 0;  ///< of the input
    std::vector<RepairItem> items;

    int input_vertex(int v) const { return v < input_vertices ? v : -1; }
    Eigen::Vector3d center(int t) const;
    /// Removes the triangles marked; the others keep their order.
    void remove(const std::vector<char>& is_gone);
    /// Appends a triangle with source and group of its own.
    void append(const std::vector<std::array<int, 3>>& triangles, const std::vector<int>& source,
                const std::vector<int>& group);
    void append_vertices(const std::vector<Eigen::Vector3d>& points);
};

/// Representative per vertex: itself, or the smallest of those that stay within `tolerance`. Those that stay are
/// farther than that from each other. Vertices without a mark represent themselves. `marked` empty: all.
std::vector<int> near_vertices(const Points& points, double tolerance, const std::vector<char>& marked);

void weld(Surface& surface, double tolerance);
void remove_duplicates(Surface& surface);
void remove_degenerate(Surface& surface);
void close_cracks(Surface& surface, double tolerance);
void orient(Surface& surface);
void split_nonmanifold(Surface& surface);
void drop_components(Surface& surface, const RepairOptions& options);
void split_joints(Surface& surface, double limit);
/// Returns the number of loops left open because their fill would pass through the surface.
int fill_holes(Surface& surface, const RepairOptions& options);

/// Open loops in the sense of their triangles, each simple (touching loops are separated where the fans allow).
/// `blocked` counts loops that orientation faults or non-manifold edges make untraversable.
struct OpenLoop {
    std::vector<int> vertices;   ///< in the sense of the open edges' triangles
    std::vector<int> triangles;  ///< at the edge from vertex i to i + 1
};
std::vector<OpenLoop> open_loops(const TriMesh& mesh, const Adjacency& adjacent, int& blocked);

/// Whether an edge from vertex a to b exists: a fill must not use it.
using IsTaken = std::function<bool(int a, int b)>;

/// Triangles that close a polygon of n >= 3 points, in the opposite sense: planar if it is flat (to `flat`), else of
/// least bending against `normals`, the faces along its sides, then of least area. Empty when every triangulation needs
/// an existing edge.
std::vector<std::array<int, 3>> fill_polygon(const Points& polygon, const Points& normals, double flat,
                                             const IsTaken& is_taken);
/// Flips inner edges until the triangulation is Delaunay on the surface, without bending normals.
void flip_to_delaunay(const std::function<Eigen::Vector3d(int)>& at, std::vector<std::array<int, 3>>& triangles,
                      const IsTaken& is_taken);

/// A smooth fill, refined to the density of its surroundings.
struct Patch {
    std::vector<Eigen::Vector3d> points;        ///< new vertices
    std::vector<std::array<int, 3>> triangles;  ///< vertex numbers of the mesh, then of the new points
};
Patch smooth_patch(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<int>& loop,
                   std::vector<std::array<int, 3>> fill, int first_new);

/// The loop lies in the plane of `options.symmetry`.
bool is_meant(const RepairOptions& options, const BoundaryLoop& loop, double diagonal);
std::vector<std::string> what_remains(const Checkup& after, const RepairOptions& options, int refused_fills);

}  // namespace strake::mending
