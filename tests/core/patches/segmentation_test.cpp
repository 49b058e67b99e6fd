#include "core/patches/segmentation.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "shapes.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <functional>
#include <tuple>

using namespace strake;

namespace {

PatchHierarchy segmented(const TriMesh& mesh, const std::vector<double>& angles,
                         const SegmentationOptions& options = {}) {
    return segment(mesh, adjacency(mesh), angles, options);
}
std::size_t patches_at(const TriMesh& mesh, double angle) { return segmented(mesh, {angle}).levels[1].patches.size(); }

/// Steps 1 to 6 by the plainest means: labels spread until nothing changes, merging rescans everything.
struct Naive {
    const TriMesh& mesh;
    const Adjacency& adjacent;
    std::vector<int> parent, label;
    std::map<int, bool> smooth;  // by label

    void spread(const std::function<bool(int)>& connects) {
        for (bool changed = true; changed;) {
            changed = false;
            for (int e = 0; e < adjacent.num_edges(); ++e) {
                if (!adjacent.is_regular(e) || !connects(e)) continue;
                int &a = label[adjacent.edge_triangles[e][0]], &b = label[adjacent.edge_triangles[e][1]];
                if (a != b) a = b = std::min(a, b), changed = true;
            }
        }
    }

    Naive(const TriMesh& m, const Adjacency& adj, const std::vector<int>& above, double tau_deg, double percent)
        : mesh(m), adjacent(adj), parent(above) {
        const double deg = std::numbers::pi / 180, tau = tau_deg * deg;
        const auto features = quadric_metric_tensor(mesh, adjacent);
        const Points normals = triangle_normals(mesh);
        const auto rough = [&](int v) {
            const auto& f = features[v];
            return f.eigenvalue_ratio >= std::pow(std::tan(tau / 2), 2) || f.mean_normal_squared < 0.5;
        };
        const auto angle = [&](int e) {
            const auto s = adjacent.edge_triangles[e];
            return dihedral(normals.row(s[0]), normals.row(s[1]));
        };
        const auto same_parent = [&](int e) {
            return parent[adjacent.edge_triangles[e][0]] == parent[adjacent.edge_triangles[e][1]];
        };
        const auto barrier = [&](int e) {
            return rough(adjacent.edges[e][0]) && rough(adjacent.edges[e][1]) && angle(e) >= tau / 2;
        };
        for (int t = 0; t < mesh.num_triangles(); ++t) label.push_back(t);
        spread([&](int e) { return same_parent(e) && !barrier(e); });
        for (int t = 0; t < mesh.num_triangles(); ++t)
            for (int k = 0; k < 3; ++k) smooth[label[t]] |= !rough(mesh.triangles(t, k));
        const auto seeded = smooth;
        const auto component = label;
        spread([&](int e) {
            const auto s = adjacent.edge_triangles[e];
            return same_parent(e) &&
                   (component[s[0]] == component[s[1]] ||
                    (!seeded.at(component[s[0]]) && !seeded.at(component[s[1]]) && barrier(e) && angle(e) < 40 * deg));
        });
        while (merge_one(percent)) {
        }
    }

    bool merge_one(double percent) {
        std::map<int, int> count, first;
        for (int t = mesh.num_triangles() - 1; t >= 0; --t) ++count[label[t]], first[label[t]] = t;
        std::set<std::pair<int, int>> beside;
        for (int e = 0; e < adjacent.num_edges(); ++e)
            for (const int a : adjacent.edge_triangles[e])
                for (const int b : adjacent.edge_triangles[e])
                    if (label[a] != label[b] && parent[a] == parent[b]) beside.insert({label[a], label[b]});
        std::set<std::tuple<int, int, int>> small;
        for (const auto& [l, n] : count)
            if (n < percent / 100 * mesh.num_triangles()) small.insert({n, first[l], l});
        for (const auto& [n, f, l] : small) {
            std::set<std::tuple<bool, int, int, int>> takers;
            for (const auto& [a, b] : beside)
                if (a == l) takers.insert({smooth[b] != smooth[a], -count[b], first[b], b});
            if (takers.empty()) continue;
            for (int& at : label)
                if (at == l) at = std::get<3>(*takers.begin());
            return true;
        }
        return false;
    }
};

}  // namespace

TEST(Segmentation, CubeHasSixPatches) {
    EXPECT_EQ(patches_at(box_surface(), 20), 6u);
    EXPECT_EQ(patches_at(box_surface({1, 1, 1}, 5), 20), 6u);
    EXPECT_EQ(patches_at(box_surface(), 90), 6u);
    EXPECT_EQ(patches_at(icosphere(4), 20), 1u);
}

TEST(Segmentation, CylinderOf32FacetsHasThreePatches) {
    for (const double angle : {20.0, 10.0, 5.0})
        for (const int rings : {1, 6}) EXPECT_EQ(patches_at(capped_cylinder(32, rings), angle), 3u) << angle;
    // Facets of 12 turn by 30 degrees, still below sigma; those of 8 turn by 45 and stay apart.
    EXPECT_EQ(patches_at(capped_cylinder(12, 2), 20), 3u);
    EXPECT_EQ(patches_at(capped_cylinder(8, 2), 20), 10u);
}

TEST(Segmentation, SharpWedgeHasTwoPatches) {
    for (const double angle : {60.0, 20.0, 5.0})
        for (const int cells : {1, 6}) EXPECT_EQ(patches_at(two_plates(172, cells), angle), 2u) << angle;
}

TEST(Segmentation, UpperAndLowerSurfaceOfAWingLieInDifferentPatches) {
    const int panels = 20;
    const TriMesh mesh = naca0012_wing(panels, 10);
    for (const double angle : {20.0, 2.5, 1.0}) {
        const auto label = segmented(mesh, {angle}).levels[1].label;
        std::set<int> upper, lower;
        for (int t = 0; t < mesh.num_triangles(); ++t) (t / 2 % (2 * panels) < panels ? upper : lower).insert(label[t]);
        for (const int p : upper) EXPECT_FALSE(lower.count(p)) << angle;
    }
}

TEST(Segmentation, FlatTriangleBetweenCreasesBelongsToTheSmoothPatchBesideIt) {
    // A corner of a face of 2 x 2 cells is cut off by a triangle whose three vertices lie on creases.
    const PatchHierarchy fine = segmented(box_surface({1, 1, 1}, 2), {20});
    EXPECT_EQ(fine.levels[1].patches.size(), 6u);
    for (const Patch& p : fine.levels[1].patches) EXPECT_EQ(p.patch_class, PatchClass::smooth);
    const PatchHierarchy coarse = segmented(box_surface(), {20});
    for (const Patch& p : coarse.levels[1].patches) EXPECT_EQ(p.patch_class, PatchClass::nonsmooth);
}

TEST(Segmentation, EqualsThePlainestImplementation) {
    TriMesh flipped = bumpy(icosphere(3), 0.15);
    std::swap(flipped.triangles(5, 0), flipped.triangles(5, 1));
    flipped.triangles.conservativeResize(flipped.num_triangles() + 1, 3);
    flipped.triangles.bottomRows(1) = flipped.triangles.row(0);  // three edges with three triangles
    const std::vector<TriMesh> surfaces{bumpy(icosphere(3), 0.15), flipped, naca0012_wing(8, 5),
                                        renumbered(bumpy(icosphere(3), 0.08), 3)};
    for (const TriMesh& mesh : surfaces)
        for (const double percent : {0.0, 0.5, 5.0}) {
            const Adjacency adjacent = adjacency(mesh);
            SegmentationOptions options;
            options.min_patch_percent = percent;
            const PatchHierarchy tree = segment(mesh, adjacent, {35, 22, 12, 6}, options);
            EXPECT_EQ(broken_rule(tree), "");
            for (std::size_t l = 1; l < tree.levels.size(); ++l) {
                Naive naive(mesh, adjacent, tree.levels[l - 1].label, tree.levels[l].angle_deg, percent);
                EXPECT_TRUE(same_partition(naive.label, tree.levels[l].label)) << percent << "% level " << l;
                for (const Patch& p : tree.levels[l].patches)
                    EXPECT_EQ(naive.smooth[naive.label[p.triangles[0]]], p.patch_class == PatchClass::smooth);
            }
        }
}

TEST(Segmentation, DoesNotDependOnNumberingOrRigidMotion) {
    for (const TriMesh& mesh : {bumpy(icosphere(4), 0.1), naca0012_wing(20, 10), capped_cylinder(32, 6)}) {
        const PatchHierarchy tree = segmented(mesh, {20, 10, 5});
        EXPECT_EQ(broken_rule(tree), "");
        const PatchHierarchy turned = segmented(moved_rigidly(mesh), {20, 10, 5});
        std::vector<int> order;
        const TriMesh other = renumbered(mesh, 4, nullptr, &order);
        const PatchHierarchy shuffled = segmented(other, {20, 10, 5});
        for (int l = 1; l <= 3; ++l) {
            EXPECT_EQ(tree.levels[l].label, turned.levels[l].label);
            std::vector<int> expected;
            for (const int t : order) expected.push_back(tree.levels[l].label[t]);
            EXPECT_TRUE(same_partition(expected, shuffled.levels[l].label));
        }
    }
}

TEST(Segmentation, UnchosenPatchesAreCarriedOver) {
    const TriMesh mesh = bumpy(icosphere(4), 0.15);
    SegmentationOptions options;
    options.split = SplitLargest{1};
    const PatchHierarchy tree = segmented(mesh, {16, 10, 6}, options);
    EXPECT_EQ(broken_rule(tree), "");
    ASSERT_GT(tree.levels[1].patches.size(), 3u);
    ASSERT_GT(tree.levels[3].patches.size(), tree.levels[1].patches.size() + 3);
    for (int l = 2; l <= 3; ++l) {
        std::map<int, int> children;
        for (const Patch& p : tree.levels[l].patches) ++children[p.parent];
        const auto chosen = chosen_patches(tree.levels[l - 1], options.split);
        for (const Patch& p : tree.levels[l - 1].patches) EXPECT_TRUE(chosen[p.id] || children[p.id] == 1) << p.name;
    }
    options.split = SplitContaining{{17}};
    const PatchHierarchy around = segmented(mesh, {16, 10, 6}, options);
    for (int l = 2; l <= 3; ++l)
        for (const Patch& p : around.levels[l].patches) {
            const Patch& parent = around.levels[l - 1].patches[p.parent];
            if (parent.id != around.levels[l - 1].label[17]) {
                EXPECT_EQ(p.triangles, parent.triangles);
                EXPECT_EQ(p.name, parent.name);
                EXPECT_EQ(p.patch_class, parent.patch_class);
            }
        }
}

TEST(Segmentation, NamesAreFoundAtTheFinestLevel) {
    const PatchHierarchy tree = segmented(box_surface({3, 2, 1}, 3), {40, 20});
    const PatchPlace place = find_patch(tree, "p3");
    EXPECT_EQ(place.level, 2);
    EXPECT_EQ(tree.levels[2].patches[place.id].name, "p3");
    EXPECT_EQ(find_patch(tree, "all").level, 0);
    try {
        find_patch(tree, "p33");
        FAIL();
    } catch (const InvalidInput& e) {
        EXPECT_NE(std::string(e.what()).find("did you mean 'p3'"), std::string::npos) << e.what();
    }
}

TEST(Segmentation, WrongOptionsAreNamedWithTheirLimits) {
    const TriMesh mesh = box_surface();
    EXPECT_THROW(segmented(mesh, {0}), InvalidInput);
    EXPECT_THROW(segmented(mesh, {91}), InvalidInput);
    EXPECT_THROW(segmented(mesh, {std::nan("")}), InvalidInput);
    EXPECT_THROW(segmented(mesh, {20, 20}), InvalidInput);
    EXPECT_THROW(segmented(mesh, {20}, {.min_patch_percent = 100}), InvalidInput);
    EXPECT_THROW(segmented(mesh, {20}, {.split = SplitContaining{{12}}}), InvalidInput);
    EXPECT_THROW(segmented(mesh, {20}, {.split = SplitLargest{0}}), InvalidInput);
    EXPECT_THROW(segmented(TriMesh{}, {20}), InvalidInput);
}
