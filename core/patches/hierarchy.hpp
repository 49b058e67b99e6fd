#pragma once
#include "core/mesh/adjacency.hpp"

#include <string>
#include <variant>
#include <vector>

/// The nested tree of patches (paper, III.B). Level 0 is the whole surface; every patch of a level lies in
/// exactly one patch of the level above it, by construction.
///
/// Names are paths: the whole surface is `all`; the parts it is split into are `p1`, `p2`, …; those of `p2` are `p2.1`,
/// `p2.2`, … A patch that is carried over or not split keeps its name at the next level, and no name means two
/// different sets of triangles. Siblings are numbered by their centroids along the coordinate axis of largest spread:
/// names follow places, not triangle numbers. They need no quotes in YAML.
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

/// Level and id of the patch of that name on the finest level at which it exists.
struct PatchPlace {
    int level, id;
};
/// @throws InvalidInput for an unknown name, with the nearest one.
PatchPlace find_patch(const PatchHierarchy& tree, const std::string& name);

}  // namespace strake
