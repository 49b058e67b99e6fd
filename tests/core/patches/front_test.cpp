#include "core/patches/front.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "core/patches/segmentation.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

PatchHierarchy tree_of(const TriMesh& mesh) {
    AutomaticLevels levels;
    levels.patches_per_level = {3, 9, 27};
    return segment_automatically(mesh, adjacency(mesh), levels);
}

void expect_partition(const Front& front, int triangles) {
    std::vector<int> owner(triangles, -1);
    for (const Patch& patch : front.patches.patches)
        for (const int t : patch.triangles) {
            EXPECT_EQ(owner[t], -1);
            owner[t] = patch.id;
        }
    EXPECT_EQ(owner, front.patches.label);
}

}  // namespace

TEST(Front, SplittingEverythingGivesTheLevelsOfTheTree) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    const PatchHierarchy tree = tree_of(mesh);
    Front front = front_at(tree, 1);
    for (int level = 2; level <= 3; ++level) {
        front = split_front(tree, front, std::vector<char>(front.depth.size(), 1));
        EXPECT_EQ(front.patches.label, tree.levels[level].label);
        for (const Patch& patch : front.patches.patches)
            EXPECT_EQ(patch.parent, tree.levels[level].patches[patch.id].parent);
    }
    for (const int parts : parts_of(tree, front)) EXPECT_EQ(parts, 1);
}

TEST(Front, SplitsTheChosenAndCarriesTheOthers) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    const PatchHierarchy tree = tree_of(mesh);
    const Front before = front_at(tree, 1);
    const std::vector<int> parts = parts_of(tree, before);
    std::vector<char> chosen(before.depth.size(), 0);
    chosen[1] = 1;
    const Front after = split_front(tree, before, chosen);
    expect_partition(after, mesh.num_triangles());
    EXPECT_EQ(after.depth.size(), before.depth.size() - 1 + parts[1]);
    int carried = 0;
    for (const Patch& patch : after.patches.patches) {
        const Patch& above = before.patches.patches[patch.parent];
        EXPECT_EQ(before.patches.label[patch.triangles.front()], patch.parent);
        if (patch.parent != 1) {
            EXPECT_EQ(patch.triangles, above.triangles);
            EXPECT_EQ(patch.name, above.name);
            ++carried;
        }
    }
    EXPECT_EQ(carried, static_cast<int>(before.depth.size()) - 1);
    // Patches of different depth split side by side; once all are at the bottom it is the finest level again.
    Front front = after;
    for (int round = 0; round < 3; ++round) front = split_front(tree, front, std::vector<char>(front.depth.size(), 1));
    EXPECT_EQ(front.patches.label, tree.levels[3].label);
}

TEST(Front, ALevelThatIsNotThereIsRefused) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 1);
    EXPECT_THROW(front_at(segment(mesh, adjacency(mesh), {45}), 2), InvalidInput);
}
