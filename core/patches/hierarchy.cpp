#include "core/patches/hierarchy.hpp"

#include "core/error.hpp"
#include "core/patches/segmentation.hpp"

#include <algorithm>
#include <numeric>

namespace strake {
namespace {

/// Levenshtein distance, for suggestions.
int edit_distance(const std::string& a, const std::string& b) {
    std::vector<int> row(b.size() + 1);
    std::iota(row.begin(), row.end(), 0);
    for (std::size_t i = 0; i < a.size(); ++i) {
        int diagonal = row[0]++;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const int change = diagonal + (a[i] != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = std::min({change, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

}  // namespace

PatchHierarchy segment(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<double>& angles_deg,
                       const SegmentationOptions& options) {
    for (std::size_t i = 0; i < angles_deg.size(); ++i) {
        if (!(angles_deg[i] > 0 && angles_deg[i] <= 90))
            throw InvalidInput(text("segment: angle ", i + 1, " = ", angles_deg[i], " deg must be in (0, 90]"));
        if (i > 0 && !(angles_deg[i] < angles_deg[i - 1]))
            throw InvalidInput(text("segment: angle ", i + 1, " = ", angles_deg[i], " deg must be below angle ", i,
                                    " = ", angles_deg[i - 1], " deg"));
    }
    PatchHierarchy tree = whole_surface(mesh);
    const SurfaceFeatures features = surface_features(mesh, adjacent);
    for (const double angle : angles_deg) {
        std::vector<char> chosen = chosen_patches(tree.levels.back(), options.split);
        if (tree.levels.size() == 1) chosen.assign(1, 1);  // level 1 always splits the whole surface
        refine(tree, features, angle, chosen, options);
    }
    return tree;
}

PatchPlace find_patch(const PatchHierarchy& tree, const std::string& name) {
    std::string nearest;
    for (int l = static_cast<int>(tree.levels.size()) - 1; l >= 0; --l)
        for (const Patch& patch : tree.levels[l].patches) {
            if (patch.name == name) return {l, patch.id};
            if (nearest.empty() || edit_distance(name, patch.name) < edit_distance(name, nearest)) nearest = patch.name;
        }
    throw InvalidInput(text("no patch is named '", name, "'; did you mean '", nearest, "'?"));
}

}  // namespace strake
