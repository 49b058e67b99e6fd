#pragma once
#include "core/mesh/adjacency.hpp"

#include <string>
#include <variant>
#include <vector>

/// The nested tree of patches (paper, III.B). Level 0 is the whole surface; every patch of a level lies in
/// exactly one patch of the level above it, by construction.
namespace strake {

enum class PatchClass { smooth, nonsmooth };

struct Patch {
    int id = 0;        ///< number within its level, in the order of the smallest triangle
    std::string name;  ///< stable and readable, unique within the tree: a single child keeps its parent's
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
    std::vector<int> patches_per_level{4, 16, 64};    ///< wanted numbers, rising
    std::vector<double> max_share{0.50, 0.25, 0.12};  ///< of the area; the last holds for deeper levels
    double sharp_angle_deg = 40;
    Split split = SplitAll{};
};

/// Levels with thresholds chosen from the distribution of theta, sizes by area, and what curvature leaves
/// too large split into compact parts. Deterministic, independent of numbering and rigid motion, and stable
/// under remeshing. The wanted number of a level is met between one half and twice.
PatchHierarchy segment_automatically(const TriMesh& mesh, const Adjacency& adjacent,
                                     const AutomaticLevels& options = {});

/// Level and id of the patch of that name on the finest level at which it exists.
struct PatchPlace {
    int level, id;
};
/// @throws InvalidInput for an unknown name, with the nearest one.
PatchPlace find_patch(const PatchHierarchy& tree, const std::string& name);

}  // namespace strake
