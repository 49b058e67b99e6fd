#pragma once
#include "core/mesh/mesh.hpp"

#include <span>

/// A volume mesh, with the data to check its cells after its points have moved.
namespace strake {

/// Polygons one after the other: polygon f has the points corners[first[f]] .. corners[first[f + 1] - 1].
struct Polygons {
    std::vector<int> first{0}, corners;
    int size() const { return static_cast<int>(first.size()) - 1; }
    std::span<const int> operator[](int f) const {
        return {corners.data() + first[f], static_cast<std::size_t>(first[f + 1] - first[f])};
    }
    void add(std::span<const int> polygon);
};

/// A named part of the boundary: a patch of OpenFOAM, a marker of SU2.
struct BoundaryPart {
    std::string name;
    Polygons faces;
};

struct VolumeMesh {
    Points points;               ///< P x 3
    Polygons faces;              ///< of cells; the normal points out of the owner
    std::vector<int> owner;      ///< per face: its cell
    std::vector<int> neighbour;  ///< per face: the cell on the other side; -1: none, or that cell has its own copy
    int num_cells = 0;           ///< with a volume
    int num_unchecked = 0;       ///< of unknown kinds
    std::vector<BoundaryPart> boundary;
    int num_points() const { return static_cast<int>(points.rows()); }
};

/// Adds a cell of one of VTK's kinds: tetrahedron 10, voxel 11, hexahedron 12, wedge 13, pyramid 14, prisms 15 and 16,
/// and their higher-order versions, taken by their corners: 24, 25, 26, 27, 29, 32, 33, 37.
/// Skips points, lines and polygons; counts other kinds as unchecked.
void add_cell(VolumeMesh& mesh, int kind, std::span<const int> corners, std::vector<int>& kinds);
/// How many corners a cell of this kind has; 0: not known.
int num_corners(int kind);

/// Triangles of a boundary's polygons, by fans, on all points of the mesh.
TriMesh triangulated(const Points& points, const Polygons& polygons);

}  // namespace strake
