#pragma once
#include "core/mesh/mesh.hpp"

#include <span>

/// The mesh of a volume, as far as it takes to see whether its cells survive when its points move.
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
    std::vector<int> neighbour;  ///< per face: the cell behind it; -1: none, or that cell has a copy of its own
    int num_cells = 0;           ///< with a volume
    int num_unchecked = 0;       ///< of kinds whose faces are not known
    std::vector<BoundaryPart> boundary;
    int num_points() const { return static_cast<int>(points.rows()); }
};

/// Adds a cell of one of VTK's kinds: tetrahedron 10, voxel 11, hexahedron 12, wedge 13, pyramid 14, prisms 15 and 16,
/// and those with nodes within edges and faces, which are taken by their corners: 24, 25, 26, 27, 29, 32, 33, 37.
/// Points, lines and polygons have no volume and are left out; other kinds are counted as unchecked.
void add_cell(VolumeMesh& mesh, int kind, std::span<const int> corners, std::vector<int>& kinds);
/// How many corners a cell of this kind has; 0: not known.
int num_corners(int kind);

/// Programs disagree on which way round some kinds are numbered: where most cells of a kind have negative volume, all
/// of that kind are turned. @param kinds per cell, as `add_cell` made it.
void orient_by_majority(VolumeMesh& mesh, const std::vector<int>& kinds);

/// Triangles of a boundary's polygons, by fans, on all points of the mesh.
TriMesh triangulated(const Points& points, const Polygons& polygons);

}  // namespace strake
