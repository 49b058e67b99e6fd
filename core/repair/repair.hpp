#pragma once
#include "core/repair/checkup.hpp"
#include "core/repair/repair_options.hpp"

#include <string>
#include <vector>

/// Repairs surfaces. Each kind of repair is requested separately and nothing else changes: untouched vertices keep
/// their coordinates exactly, triangles keep order, corners and groups. Same input, same bits.
namespace strake {

void validate(const RepairOptions& options);  ///< throws InvalidInput: field, value, limit
std::string name_of(RepairKind kind);         ///< "weld", "duplicate", ...

/// Options for most surfaces: weld 1e-9, cracks 1e-5, holes 10 % of the diagonal (except symmetry planes), and all
/// other repairs except dropping components and halving edges at joints.
RepairOptions all_repairs(double diagonal);

struct RepairResult {
    TriMesh mesh;
    std::vector<int>
        source_triangle;            ///< per triangle: the input's triangle that it is or belongs to; -1: fills a hole
    std::vector<RepairItem> items;  ///< in order of execution
    std::vector<std::string> remaining;  ///< remaining defects with reasons
    Checkup before, after;

    int count(RepairKind kind) const;  ///< items of that kind
};

/// The repairs in this order: weld, duplicates, degenerate, cracks, orient (these repeat until nothing changes),
/// holes, split, orient, components, holes again, degenerate again, joints, isolated.
///
/// - weld: vertices within the distance merge into the one of the smallest number; triangles that lose a corner are
/// removed.
/// - duplicates: of copies, the one consistent with its neighbours stays; back-to-back sheets on surroundings that are
/// closed without them (a common wall of two parts, a flap) are removed entirely.
/// - degenerate: edges below 1e-7 of the diagonal collapse; for a triangle with a corner on its longest edge, the
/// neighbours at that edge are split at this corner.
/// - orient: triangles connected across edges of two agree with the majority of their area; a closed part (or one that
///   flat lids would close) turns outward, unless it lies inside another one: a void stays a void. A non-orientable
///   part is unchanged.
/// - split: at edges of more than two triangles, the pairs that bound the same solid stay together, else the flattest
/// consistent pair; then every fan gets its own vertex.
/// - joints: edges of triangles that another part cuts are halved, in all triangles at them, until those are short
/// enough. The surface stays where it is.
/// - holes: each loop separately, unless its fill would pass through the surface; new triangles take the group of most
/// of the loop's edges.
///
/// @throws InvalidInput on a bad option, no triangles, an index out of range or a coordinate that is not finite.
RepairResult repair(const TriMesh& mesh, const RepairOptions& options);

/// The items as CSV: kind,vertex,triangle,x,y,z,size,triangles,words; missing numbers stay empty.
std::string repair_csv(const RepairResult& result);

}  // namespace strake
