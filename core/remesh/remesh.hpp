#pragma once
#include "core/mesh/mesh.hpp"

#include <functional>
#include <string>
#include <vector>

/// Feature-preserving remeshing (Berkenstock & Aftosmis 2008, section V, Algorithm 2): a surface of the same shape made
/// of nearly equilateral triangles. Split, collapse, flip, smooth along the surface, project back; the quadric metric
/// tensor and the dihedral angles of the input classify vertices as smooth, ridge or corner.
///
/// Preserved: corners exactly; creases, open boundaries and borders between groups as chains of edges whose
/// vertices lie on the input's chains; every other vertex on the input surface; topology; groups. Edges with other than
/// two consistently oriented triangles stay unchanged, with their vertices.
namespace strake {

struct RemeshOptions {
    /// Target; 0: the mean edge length of the input. For an already remeshed input with shorter edges where its shape
    /// needs them: the mean of the others.
    double edge_length = 0;
    double angle_deg = 40;  ///< tau: an edge of at least this dihedral is a crease; in (0, 90]
    int iterations = 10;    ///< >= 1; stops early when nothing is left to do
    /// > 0: largest distance of an edge from the surface (l^2 / 8R): edges shrink where it bends; 0: uniform.
    double chord_error = 0;
    double shortest_edge = 0;  ///< limit where edges shrink (bends, narrow strips); 0: a tenth of edge_length
    double gradation = 0.3;    ///< target lengths change by at most this times the distance; in (0, 1]
    double turn_deg = 2;  ///< no operation turns a normal away from the input's by more than this plus the turn over
                          ///< one target edge length; in (0, 90]
    int max_triangles = 20'000'000;  ///< more are refused at the start
    int threads = 0;                 ///< 0: STRAKE_NUM_THREADS, else all processors; the same result for any
};
void validate(const RemeshOptions& options);  ///< throws InvalidInput: field, value, limit

struct RemeshRecord {
    int iteration, splits, collapses, flips, triangles;
    double largest_move;  ///< of a vertex by smoothing, in edge lengths
    double seconds;       ///< since the start
};

struct RemeshResult {
    TriMesh mesh;
    double edge_length = 0;                                      ///< the target, in the surface's unit
    bool cancelled = false;                                      ///< the mesh is valid anyway
    int crease_edges = 0, boundary_edges = 0, border_edges = 0;  ///< of the output
    int corners = 0, kept_edges = 0;                             ///< unchanged vertices and edges
    /// Creases, boundaries and borders have corners so close to each other that the target cannot be had: edges are at
    /// most 1.4 times as long as the mean piece between two corners.
    bool features_are_dense = false;
    double expected_triangles = 0;  ///< that edges of the target length alone would make
    int frozen_triangles = 0;       ///< of the input, left unchanged near new intersections
    int new_intersections = 0;      ///< pairs of triangles that intersect where the input does not; rarely above 0
    std::vector<RemeshRecord> records;
};
using RemeshProgress =
    std::function<bool(const RemeshRecord&)>;  ///< return false to cancel; asked after each iteration

/// Which features keep most edges shorter than the target, and what would help; empty where nothing does.
std::string short_edge_words(const RemeshResult& result);

/// Triangles with a repeated corner and vertices without a triangle are left out.
/// @throws InvalidInput on a bad option, without triangles of positive area, on an index out of range or a coordinate
/// that is not finite, or where more than `max_triangles` would be needed.
/// Cost: about 0.1 s of CPU per iteration and 100 000 triangles.
RemeshResult remesh(const TriMesh& mesh, const RemeshOptions& options = {}, const RemeshProgress& progress = {});

}  // namespace strake
