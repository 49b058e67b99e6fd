#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "core/repair/checkup.hpp"

#include <optional>
#include <string>
#include <vector>

/// Mends surfaces. Every kind of repair is asked for by itself; what was not asked for does not change: vertices that
/// no repair moves keep their bits, triangles their order, corners and groups. Same input, same bits.
namespace strake {

enum class HoleFill {
    planar,  ///< no new vertices: flat where the hole is, else of least bending and area
    smooth   ///< new vertices as dense as around the hole, going on with its tangent planes
};

struct RepairOptions {
    std::optional<double> weld;  ///< merge vertices at most this far apart; a length >= 0, 0: equal coordinates
    bool duplicates = false;     ///< remove triangles with the vertices of another one
    bool degenerate = false;     ///< remove triangles of no area (DESIGN: 1e-14 diagonal^2) without opening the surface
    std::optional<double> cracks;  ///< join open edges at most this far apart, splitting edges at T-junctions; > 0
    bool orient = false;           ///< turn triangles until neighbours agree; outward where that is defined
    bool split = false;            ///< separate what meets in a vertex or an edge only
    std::optional<double> holes;   ///< close open loops whose box has at most this diagonal; > 0, may be infinity
    HoleFill fill = HoleFill::planar;
    bool keep_symmetry_loops = false;  ///< `holes` leaves loops that look like the cut of a half model
    /// Open loops in this plane are what a half model has there: neither closed nor told as left.
    std::optional<SymmetryPlane> symmetry = {};
    int keep_largest = 0;       ///< drop all components but so many of the largest area; 0: none
    double min_area_share = 0;  ///< drop components with less than this share of the area; in [0, 1)
    int min_triangles = 0;      ///< drop components with fewer triangles
    bool isolated = false;      ///< remove vertices that no triangle uses
};
void validate(const RepairOptions& options);  ///< throws InvalidInput: field, value, limit

/// What suits most surfaces: weld 1e-9, cracks 1e-5, holes 10 % of the diagonal without symmetry planes, and everything
/// else but dropping components.
RepairOptions all_repairs(double diagonal);

enum class RepairKind { weld, duplicate, degenerate, crack, orient, split, component, hole, isolated };
std::string name_of(RepairKind kind);  ///< "weld", "duplicate", ...

/// One thing that was mended, in numbers of the input.
struct RepairItem {
    RepairKind kind = RepairKind::weld;
    int vertex = -1, triangle = -1;  ///< -1: none, or made by an earlier repair
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    double size = 0;    ///< distance, area or loop's diagonal, by kind
    int triangles = 0;  ///< that it removed, turned or added
    std::string words;
};

struct RepairResult {
    TriMesh mesh;
    std::vector<int> source_triangle;    ///< per triangle the input's that it is or is part of; -1: fills a hole
    std::vector<RepairItem> items;       ///< in the order in which they were done
    std::vector<std::string> remaining;  ///< what is still wrong, and why, in words
    Checkup before, after;

    int count(RepairKind kind) const;  ///< items of that kind
};

/// The repairs in this order: weld, duplicates, degenerate, cracks, orient (these until nothing is left for them),
/// holes, split, orient, components, holes again, degenerate again, isolated.
///
/// - weld: the vertex of the smallest number stays, those not farther away become it; triangles that lose a corner go.
/// - duplicates: of copies the one that agrees with its neighbours stays; sheets that lie back to back on
///   surroundings that are closed without them (a common wall of two parts, a flap) go altogether.
/// - degenerate: edges below 1e-7 of the diagonal collapse; of a triangle whose corner lies on its longest edge the
///   neighbours at that edge are split in this corner.
/// - orient: triangles connected across edges of two agree with the majority of their area; a closed part (or one that
///   flat lids would close) turns outward, unless it lies inside of another one: a void stays a void. A part that is
///   not orientable stays as it is.
/// - split: at edges of more than two triangles those that bound the same solid, else the flattest pair that agrees,
///   stay together; then every fan gets a vertex of its own.
/// - holes: each loop by itself, unless what fills it passes through the surface; new triangles take the group that has
/// most of the loop's edges.
///
/// @throws InvalidInput on a bad option, no triangles, an index out of range or a coordinate that is not finite.
RepairResult repair(const TriMesh& mesh, const RepairOptions& options);

/// The items as CSV: kind,vertex,triangle,x,y,z,size,triangles,words; numbers that there are not stay empty.
std::string repair_csv(const RepairResult& result);

}  // namespace strake
