#pragma once
#include "core/mesh/adjacency.hpp"

#include <string>
#include <variant>
#include <vector>

/// The nested tree of patches (paper, III.B). Level 0 is the whole surface; every patch of a level lies in
/// exactly one patch of the level above it, by construction.
///
/// Names are paths: the whole surface is `all`; the parts it is split into are `p1`, `p2`, …; those of `p2` are `p2.1`,
/// `p2.2`, … A patch that is carried over, or not split, keeps its name at the next level, and no name ever means two
/// different sets of triangles. Siblings are counted in the order of their centroids along the coordinate axis on which
/// these spread most, so names follow places, not triangle numbers. They need no quotes in YAML.
namespace strake {

enum class PatchClass { smooth, nonsmooth };

struct Patch {
    int id = 0;        ///< number within its level, in the order of the smallest triangle
    std::string name;  ///< see below
    int parent = -1;   ///< id in the level above
    PatchClass patch_class = PatchClass::smooth;
    std::vector<int> triangles;  ///< ascending
    double area = 0;
};

struct PatchLevel {
    double angle_deg = 0;  ///< threshold tau of this level; 0 for level 0
    std::vector<Patch> patches;
    std::vector<int> label;  ///< patch id per triangle
};

struct PatchHierarchy {
    std::vector<PatchLevel> levels;  ///< [0] is the whole surface
};

struct SplitAll {};
struct SplitLargest {
    int count = 1;
};  ///< by number of triangles, tie: smaller id
struct SplitContaining {
    std::vector<int> triangles;
};  ///< the patches that hold these triangles
using Split = std::variant<SplitAll, SplitLargest, SplitContaining>;

struct SegmentationOptions {
    double sharp_angle_deg = 40;   ///< sigma of step 4
    double min_patch_percent = 0;  ///< p: smaller patches are merged, percent of all triangles, in [0, 100)
    Split split = SplitAll{};
};

/// Levels at stated thresholds, DESIGN sections 2 and 3, steps 1 to 7; never splits geometrically.
/// @param angles_deg tau_1 > tau_2 > ..., each in (0, 90]. @throws InvalidInput naming the value and the limit.
PatchHierarchy segment(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<double>& angles_deg,
                       const SegmentationOptions& options = {});

struct AutomaticLevels {
    std::vector<int> patches_per_level{4, 16, 64};    ///< wanted numbers, not falling
    std::vector<double> max_share{0.50, 0.25, 0.12};  ///< of the area; the last holds for deeper levels
    double sharp_angle_deg = 40;   ///< what counts as a crease, about (see below); used within [10, 53]
    double min_patch_percent = 0;  ///< no patch below this percentage of the area is cut off, in [0, 100)
    Split split = SplitAll{};
};

/// Levels that fit the surface: about the wanted number of patches (between half and twice), none above its share of
/// the area (but single triangles). Deterministic, independent of numbering and rigid motion, and stable under
/// remeshing, for which reason it uses only what converges with the mesh. Each chosen patch gets a number of parts in
/// proportion to its area and is cut, again and again, in the first of these ways that yields two parts worth having:
///  1. along creases: chains of edges above the level's threshold, gaps bridged. The threshold is the largest of three
///     (30 degrees apart at most) at which creases alone give the wanted number, else the smallest: 9/8, 8/8, 7/8, 6/8
///     of the sharp angle at levels 1 to 4, 45 degrees at the first. A smaller angle between neighbouring triangles
///     tells the edge length, not the shape;
///  2. a sheet with two sides (a wing) into these, where the normal is square to the sheet's own direction;
///  3. by a plane across the principal axis of the body along which the patch extends most, at equal areas.
/// Parts below half a fair share join the neighbour with which they share most smooth border. Patches are
/// edge-connected where the surface is; many tiny components are joined with the nearest part. Exactly symmetric bodies
/// without own axes (cube, sphere, body of revolution) are cut along coordinate axes and so do not turn with the body.
/// `SplitLargest` goes by area here. Cost: O(m log m) a level.
/// @throws InvalidInput on an empty, falling or non-positive list, a share outside (0, 1], a surface without area.
PatchHierarchy segment_automatically(const TriMesh& mesh, const Adjacency& adjacent,
                                     const AutomaticLevels& options = {});

/// Level and id of the patch of that name on the finest level at which it exists.
struct PatchPlace {
    int level, id;
};
/// @throws InvalidInput for an unknown name, with the nearest one.
PatchPlace find_patch(const PatchHierarchy& tree, const std::string& name);

}  // namespace strake
