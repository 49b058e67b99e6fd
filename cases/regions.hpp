#pragma once
#include "cases/case.hpp"
#include "core/mesh/adjacency.hpp"

/// Which triangles the regions of a case hold.
namespace strake {

/// The start surface, and what is known about it.
struct StartSurface {
    TriMesh mesh;
    Adjacency adjacent;
    Eigen::VectorXd area;  ///< m
    double diagonal = 0;
    int file_triangles = 0;            ///< of the surface file
    bool is_remeshed = false;          ///< numbers in the file mean nothing any more
    std::vector<int> source_triangle;  ///< number in the file, -1: new; empty: as in the file
};

/// Triangles of a region, ascending, never empty. Box, sphere and half space hold the triangles whose three vertices
/// lie inside, borders included (1e-9 of the diagonal). @param tree may be empty unless the region names a patch.
/// @throws InvalidInput: nothing inside, unknown solid, component or patch, wrong triangle file.
std::vector<int> region_triangles(const Region& region, const StartSurface& start, const PatchHierarchy& tree);

}  // namespace strake
