#pragma once
#include "core/mesh/symmetry_plane.hpp"

#include <Eigen/Core>
#include <optional>
#include <string>

namespace strake {

enum class HoleFill {
    planar,  ///< no new vertices: flat if the hole is, else of least bending and area
    smooth   ///< new vertices at the density around the hole, continuing its tangent planes
};

struct RepairOptions {
    std::optional<double> weld;    ///< merge vertices at most this far apart; a length >= 0, 0: equal coordinates
    bool duplicates = false;       ///< remove triangles with the vertices of another one
    bool degenerate = false;       ///< remove triangles of zero area (1e-14 diagonal^2) without opening the surface
    std::optional<double> cracks;  ///< join open edges at most this far apart, splitting edges at T-junctions; > 0
    bool orient = false;           ///< turn triangles until neighbours agree; outward where that is defined
    bool split = false;            ///< separate parts that meet only in a vertex or an edge
    std::optional<double> holes;   ///< close open loops whose box has at most this diagonal; > 0, may be infinity
    HoleFill fill = HoleFill::planar;
    bool keep_symmetry_loops = false;  ///< `holes` leaves loops that look like the cut of a half model
    /// Open loops in this plane belong to a half model: neither closed nor reported.
    std::optional<SymmetryPlane> symmetry = {};
    int keep_largest = 0;          ///< keep only this many components of the largest area; 0: all
    double min_area_share = 0;     ///< drop components with less than this share of the area; in [0, 1)
    int min_triangles = 0;         ///< drop components with fewer triangles
    std::optional<double> joints;  ///< halve edges of triangles that another part cuts until they are at most this long
    bool isolated = false;         ///< remove unused vertices
};
enum class RepairKind { weld, duplicate, degenerate, crack, orient, split, component, hole, joint, isolated };

/// One repair, in numbers of the input.
struct RepairItem {
    RepairKind kind = RepairKind::weld;
    int vertex = -1, triangle = -1;  ///< -1: none, or made by an earlier repair
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    double size = 0;    ///< distance, area or loop's diagonal, by kind
    int triangles = 0;  ///< number removed, turned or added
    std::string words;
};

}  // namespace strake
