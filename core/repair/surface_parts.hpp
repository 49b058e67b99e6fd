#pragma once
#include "core/repair/repair.hpp"

#include <functional>

/// The surface while it is being mended, and the single repairs. Internal to repair.cpp.
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
/// Returns the number of loops left open because what fills them would pass through the surface.
int fill_holes(Surface& surface, const RepairOptions& options);

/// Open loops as the triangles run along them, each simple (loops that touch are cut apart where the fans allow).
/// Empty where orientation faults or non-manifold edges leave no way: `blocked` counts those.
struct OpenLoop {
    std::vector<int> vertices;   ///< in the sense of the open edges' triangles
    std::vector<int> triangles;  ///< at the edge from vertex i to i + 1
};
std::vector<OpenLoop> open_loops(const TriMesh& mesh, const Adjacency& adjacent, int& blocked);

/// Whether an edge from vertex a to b is there already: a fill must not use it.
using IsTaken = std::function<bool(int a, int b)>;

/// Triangles that close a polygon of n >= 3 points and run against it: with its flat plane's diagonals where it is flat
/// (to `flat`), else of least bending, `normals` being those of the faces along its sides, then of least area. Empty
/// where every way needs an edge that is taken.
std::vector<std::array<int, 3>> fill_polygon(const Points& polygon, const Points& normals, double flat,
                                             const IsTaken& is_taken);
/// Flips inner edges until no two triangles can be better (Delaunay on the surface) without a bend of their normals.
void flip_to_delaunay(const std::function<Eigen::Vector3d(int)>& at, std::vector<std::array<int, 3>>& triangles,
                      const IsTaken& is_taken);

/// A fill refined to the density of its surroundings and made smooth.
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
