#pragma once
#include "core/patches/body.hpp"

#include <vector>

namespace strake {

struct AutomaticLevels {
    std::vector<int> patches_per_level{4, 16, 64};    ///< target numbers, non-decreasing
    std::vector<double> max_share{0.50, 0.25, 0.12};  ///< of the area; the last applies to deeper levels
    double sharp_angle_deg = 40;   ///< approximate threshold of a crease (see below); clamped to [10, 53]
    double min_patch_percent = 0;  ///< no smaller patch is cut off, percent of the area in [0, 100)
    Split split = SplitAll{};
};

/// Levels adapted to the surface: about the target number of patches (between half and twice), none above its share of
/// the area (except single triangles). Deterministic, independent of numbering and rigid motion, and stable under
/// remeshing, because it uses only measures that converge with the mesh. Each chosen patch gets a number of parts in
/// proportion to its area and is cut repeatedly, in the first of these ways that yields two usable parts:
///  1. along creases: chains of edges above the level's threshold, gaps bridged. The threshold is the largest of three
///     (30 degrees apart at most) at which creases alone give the target number, else the smallest: 9/8, 8/8, 7/8, 6/8
///     of the sharp angle at levels 1 to 4, 45 degrees at the first. A smaller angle between neighbouring triangles
///     depends on the edge length, not on the shape;
///  2. a sheet with two sides (a wing) into these sides, where the normal is perpendicular to the sheet's direction;
///  3. by a plane across the principal axis of the body along which the patch extends most, at equal areas.
/// Parts below half a fair share join the neighbour with the longest smooth common border. Patches are
/// edge-connected where the surface is; many tiny components are joined with the nearest part. Exactly symmetric bodies
/// without principal axes (cube, sphere, body of revolution) are cut along coordinate axes; these cuts do not rotate
/// with the body. `SplitLargest` compares areas here. Cost: O(m log m) a level.
/// @throws InvalidInput on an empty, falling or non-positive list, a share outside (0, 1], a surface without area.
PatchHierarchy segment_automatically(const TriMesh& mesh, const Adjacency& adjacent,
                                     const AutomaticLevels& options = {});

/// Appends the next automatic level: the chosen patches (flags by id) of the last level are cut as in
/// `segment_automatically`, the others carried over. A run that chooses its patches adaptively calls it step by step.
/// @param due target areas of the patches of the last level (start: the whole area); replaced by those of the new level
/// @pre `options` are valid for `segment_automatically` and have a number for this level.
void refine_automatically(PatchHierarchy& tree, const Body& body, std::vector<double>& due,
                          const std::vector<char>& chosen, const AutomaticLevels& options);

}  // namespace strake
