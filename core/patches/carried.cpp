#include "core/patches/carried.hpp"

#include "core/mesh/geometry.hpp"

namespace strake {

std::vector<int> carried(const std::vector<int>& label, const std::vector<int>& from) {
    std::vector<int> out;
    out.reserve(from.size());
    for (const int t : from) out.push_back(label[static_cast<std::size_t>(t)]);
    return out;
}

PatchHierarchy carried(const PatchHierarchy& tree, const std::vector<int>& from, const TriMesh& mesh) {
    const Eigen::VectorXd area = triangle_areas(mesh);
    PatchHierarchy out = tree;
    for (std::size_t k = 0; k < tree.levels.size(); ++k) {
        PatchLevel& level = out.levels[k];
        for (Patch& patch : level.patches) patch.triangles.clear(), patch.area = 0;
        level.label = carried(tree.levels[k].label, from);
        for (std::size_t t = 0; t < from.size(); ++t) {
            Patch& patch = level.patches[static_cast<std::size_t>(level.label[t])];
            patch.triangles.push_back(static_cast<int>(t));
            patch.area += area[static_cast<Eigen::Index>(t)];
        }
    }
    return out;
}

}  // namespace strake
