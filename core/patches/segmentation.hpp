#pragma once
#include "core/patches/features.hpp"
#include "core/patches/hierarchy.hpp"

#include <vector>

/// One refinement of a hierarchy at one threshold (docs/theory.md, *Patches*). `segment` calls it level by level;
/// a run that chooses its patches as it goes calls it itself.
namespace strake {

struct SegmentationOptions {
    double sharp_angle_deg = 40;   ///< sigma of step 4
    double min_patch_percent = 0;  ///< p: smaller patches are merged, percent of all triangles, in [0, 100)
    Split split = SplitAll{};
};

/// Levels at stated thresholds (docs/theory.md, *Patches*); never splits geometrically.
/// @param angles_deg tau_1 > tau_2 > ..., each in (0, 90]. @throws InvalidInput naming the value and the limit.
PatchHierarchy segment(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<double>& angles_deg,
                       const SegmentationOptions& options = {});

/// Surface data for refinement at any threshold, computed once. Refers to mesh and adjacency, which must outlive it.
struct SurfaceFeatures {
    const TriMesh& mesh;
    const Adjacency& adjacent;
    std::vector<VertexFeature> vertices;
    std::vector<double> dihedral;  ///< per edge, radians; 0 where the edge is not regular
    Eigen::VectorXd areas;         ///< per triangle
};
SurfaceFeatures surface_features(const TriMesh& mesh, const Adjacency& adjacent);

/// Step 1: per edge, whether it is a barrier at threshold tau (radians): regular (two triangles that agree), both ends
/// nonsmooth, dihedral >= tau / 2. Boundary, non-manifold and misoriented edges always bound patches and are not
/// listed.
std::vector<char> nonsmooth_edges(const SurfaceFeatures& features, double tau);

/// The tree of one level: the whole surface as patch "all". @throws InvalidInput without triangles.
PatchHierarchy whole_surface(const TriMesh& mesh);

/// Patches of the last level that `split` chooses, as flags by id. @throws InvalidInput naming a wrong count or
/// triangle.
std::vector<char> chosen_patches(const PatchLevel& level, const Split& split);

/// Appends a level at threshold `angle_deg`: the chosen patches (flags by id) of the last level are split by steps 1 to
/// 6, the others carried over as their own single child. Uses sharp_angle_deg and min_patch_percent of the options;
/// the caller chooses the patches. Cost: O(m log m).
/// @throws InvalidInput on an angle outside (0, 90], a bad option, or a wrong number of flags.
void refine(PatchHierarchy& tree, const SurfaceFeatures& features, double angle_deg, const std::vector<char>& chosen,
            const SegmentationOptions& options = {});

/// Appends the level that a label per triangle (any numbers >= 0, each within one patch of the last level) describes:
/// numbers by smallest triangle, names, areas; classes by label. Shared by every way to split.
void append_level(PatchHierarchy& tree, const SurfaceFeatures& features, double angle_deg,
                  const std::vector<int>& label, const std::vector<PatchClass>& class_of_label);

}  // namespace strake
