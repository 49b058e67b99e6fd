#include "core/patches/automatic.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "shapes.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <tuple>

using namespace strake;

namespace {

PatchHierarchy automatic(const TriMesh& mesh, const AutomaticLevels& options = {}) {
    return segment_automatically(mesh, adjacency(mesh), options);
}

/// Share of the area of `b` on which the labels agree, patches matched greedily by overlap. Triangles of `b` look up
/// the closest triangle of `a`.
double overlap(const TriMesh& a, const std::vector<int>& label_a, const TriMesh& b, const std::vector<int>& label_b) {
    const ClosestPointTree tree(a);
    const Points centroids = triangle_centroids(b);
    const Eigen::VectorXd areas = triangle_areas(b);
    std::map<std::pair<int, int>, double> common;
    for (int t = 0; t < b.num_triangles(); ++t)
        common[{label_a[tree.find(centroids.row(t)).triangle], label_b[t]}] += areas[t];
    std::vector<std::tuple<double, int, int>> pairs;
    for (const auto& [labels, area] : common) pairs.push_back({-area, labels.first, labels.second});
    std::sort(pairs.begin(), pairs.end());
    std::set<int> used_a, used_b;
    double matched = 0;
    for (const auto& [area, la, lb] : pairs)
        if (!used_a.count(la) && !used_b.count(lb)) used_a.insert(la), used_b.insert(lb), matched -= area;
    return matched / areas.sum();
}

bool edge_connected(const TriMesh& mesh, const Adjacency& adjacent, const Patch& patch) {
    std::set<int> left(patch.triangles.begin(), patch.triangles.end());
    std::vector<int> stack{*left.begin()};
    left.erase(left.begin());
    while (!stack.empty()) {
        const int t = stack.back();
        stack.pop_back();
        for (int k = 0; k < 3; ++k)
            for (const int n : adjacent.edge_triangles[adjacent.triangle_edges(t, k)])
                if (left.erase(n)) stack.push_back(n);
    }
    return left.empty() && mesh.num_triangles() > 0;
}

/// The promises of every automatic hierarchy of three levels of a connected surface.
void expect_decreases(const TriMesh& mesh, const PatchHierarchy& tree, const std::string& name) {
    const Adjacency adjacent = adjacency(mesh);
    const double area = surface_area(mesh), share[] = {0.5, 0.25, 0.12};
    EXPECT_EQ(broken_rule(tree), "") << name;
    ASSERT_EQ(tree.levels.size(), 4u) << name;
    for (int l = 1, wanted = 4; l <= 3; ++l, wanted *= 4) {
        const int count = static_cast<int>(tree.levels[l].patches.size());
        EXPECT_LE(wanted / 2, count) << name;
        EXPECT_LE(count, 2 * wanted) << name;
        EXPECT_GT(tree.levels[l].angle_deg, 0);
        for (const Patch& p : tree.levels[l].patches) {
            EXPECT_LE(p.area, share[l - 1] * area) << name << " level " << l << " " << p.name;
            EXPECT_TRUE(edge_connected(mesh, adjacent, p)) << name << " level " << l << " " << p.name;
        }
    }
}

void expect_unmoved(const TriMesh& mesh, const std::string& name) {
    const PatchHierarchy tree = automatic(mesh), turned = automatic(moved_rigidly(mesh));
    std::vector<int> order;
    const PatchHierarchy shuffled = automatic(renumbered(mesh, 9, nullptr, &order));
    for (int l = 1; l <= 3; ++l) {
        EXPECT_EQ(tree.levels[l].label, turned.levels[l].label) << name;
        std::vector<int> expected;
        for (const int t : order) expected.push_back(tree.levels[l].label[t]);
        EXPECT_TRUE(same_partition(expected, shuffled.levels[l].label)) << name;
    }
}

TriMesh lopsided() { return bumpy(ellipsoid({3, 2, 1.2}, 5), 0.07); }

}  // namespace

TEST(AutomaticLevels, CubeAndBoxAreCutAlongTheirEdges) {
    for (const TriMesh& mesh : {box_surface({1, 1, 1}, 12), box_surface({1.3, 1, 0.8}, 12)}) {
        const PatchHierarchy tree = automatic(mesh);
        expect_decreases(mesh, tree, "box");
        EXPECT_EQ(tree.levels[1].patches.size(), 6u);
        const Points normals = triangle_normals(mesh);
        for (const Patch& p : tree.levels[3].patches)
            for (const int t : p.triangles) EXPECT_NEAR(normals.row(t).dot(normals.row(p.triangles[0])), 1, 1e-12);
    }
}

TEST(AutomaticLevels, UpperAndLowerSurfaceOfAWingArePartedAtTheFirstLevel) {
    const int panels = 24;
    const TriMesh mesh = naca0012_wing(panels, 48, 4);
    const PatchHierarchy tree = automatic(mesh);
    expect_decreases(mesh, tree, "wing");
    std::set<int> upper, lower;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        (t / 2 % (2 * panels) < panels ? upper : lower).insert(tree.levels[1].label[t]);
    for (const int p : upper) EXPECT_FALSE(lower.count(p));
    EXPECT_EQ(upper.size(), 2u);
}

TEST(AutomaticLevels, SmoothBodiesAlwaysEnd) {
    expect_decreases(icosphere(4), automatic(icosphere(4)), "sphere");
    expect_decreases(lopsided(), automatic(lopsided()), "lopsided");
}

TEST(AutomaticLevels, DoNotDependOnNumberingOrRigidMotion) {
    expect_unmoved(lopsided(), "lopsided");
    TriMesh wing = naca0012_wing(24, 48, 4);  // swept and twisted: no symmetry
    for (int v = 0; v < wing.num_vertices(); ++v) {
        const double y = wing.vertices(v, 1);
        wing.vertices(v, 0) = wing.vertices(v, 0) * (1 - 0.1 * y) + 0.4 * y;
        wing.vertices(v, 2) += 0.02 * y * wing.vertices(v, 0);
    }
    expect_unmoved(wing, "wing");
}

TEST(AutomaticLevels, RefinedSurfaceGivesTheSamePatches) {
    for (const TriMesh& mesh : {lopsided(), naca0012_wing(40, 80, 4), box_surface({1.3, 1, 0.8}, 24)}) {
        const TriMesh fine = refined(mesh);
        const PatchHierarchy a = automatic(mesh), b = automatic(fine);
        for (int l = 1; l <= 3; ++l) EXPECT_GT(overlap(mesh, a.levels[l].label, fine, b.levels[l].label), 0.9) << l;
    }
}

TEST(AutomaticLevels, ManyTinyComponentsAreJoined) {
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 3>> triangles;
    const TriMesh ball = icosphere(1);
    for (int i = 0; i < 300; ++i) {
        const int first = static_cast<int>(points.size());
        for (int v = 0; v < ball.num_vertices(); ++v)
            points.push_back(0.3 * ball.vertices.row(v).transpose() + Eigen::Vector3d(i % 20, 1.1 * (i / 20), 0));
        for (int t = 0; t < ball.num_triangles(); ++t)
            triangles.push_back(
                {first + ball.triangles(t, 0), first + ball.triangles(t, 1), first + ball.triangles(t, 2)});
    }
    const TriMesh mesh = mesh_of(points, triangles);
    const PatchHierarchy tree = automatic(mesh);
    EXPECT_EQ(broken_rule(tree), "");
    for (int l = 1, wanted = 4; l <= 3; ++l, wanted *= 4) {
        EXPECT_GE(tree.levels[l].patches.size(), wanted / 2u);
        EXPECT_LE(tree.levels[l].patches.size(), wanted * 2u);
    }
}

TEST(AutomaticLevels, OptionsAreKept) {
    AutomaticLevels options;
    options.patches_per_level = {2, 6};
    const PatchHierarchy tree = automatic(lopsided(), options);
    ASSERT_EQ(tree.levels.size(), 3u);
    for (int l = 1; l <= 2; ++l) {
        EXPECT_GE(tree.levels[l].patches.size(), options.patches_per_level[l - 1] / 2u);
        EXPECT_LE(tree.levels[l].patches.size(), options.patches_per_level[l - 1] * 2u);
    }
    options.split = SplitLargest{1};
    const PatchHierarchy one = automatic(lopsided(), options);
    std::map<int, int> children;
    for (const Patch& p : one.levels[2].patches) ++children[p.parent];
    int split = 0;
    for (const auto& [parent, count] : children) split += count > 1;
    EXPECT_EQ(split, 1);
    EXPECT_THROW(automatic(lopsided(), {.patches_per_level = {}}), InvalidInput);
    EXPECT_THROW(automatic(lopsided(), {.patches_per_level = {4, 2}}), InvalidInput);
    EXPECT_THROW(automatic(lopsided(), {.max_share = {0.5, 0}}), InvalidInput);
    EXPECT_THROW(automatic(mesh_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}})), InvalidInput);
}

TEST(AutomaticLevels, RealSurfacesKeepAllProperties) {
    const char* folder = std::getenv("STRAKE_DATA");
    if (!folder) GTEST_SKIP() << "STRAKE_DATA is not set";  // the surfaces are not ours to ship
    for (const char* file : {"zeroebwb_93k.ply", "bunny_closed_cgal.off", "wing717_pyhyp.ply",
                             "supersonic_wing_body_pypan.stl", "turbineblade_vtkdata.ply"}) {
        const TriMesh mesh = read_surface(std::filesystem::path(folder) / file).mesh;
        const PatchHierarchy tree = automatic(mesh);
        expect_decreases(mesh, tree, file);
        if (mesh.num_triangles() > 80000) continue;  // the others are large enough for the time a test may take
        expect_unmoved(mesh, file);
        const TriMesh fine = refined(mesh);
        const PatchHierarchy finer = automatic(fine);
        for (int l = 1; l <= 3; ++l)
            EXPECT_GT(overlap(mesh, tree.levels[l].label, fine, finer.levels[l].label), 0.9) << file << " level " << l;
    }
}

TEST(AutomaticLevels, TwoTriangulationsOfTheBunnyGiveTheSamePatches) {
    const char* folder = std::getenv("STRAKE_DATA");
    if (!folder) GTEST_SKIP() << "STRAKE_DATA is not set";  // the surfaces are not ours to ship
    const TriMesh a = read_surface(std::filesystem::path(folder) / "bunny_closed_cgal.off").mesh;
    TriMesh b = read_surface(std::filesystem::path(folder) / "bunny_pmp.off").mesh;
    const Box box_a = bounding_box(a), box_b = bounding_box(b);  // the files differ by scale and offset
    b.vertices = ((b.vertices.rowwise() - box_b.min.transpose()) * (box_diagonal(a) / box_diagonal(b))).rowwise() +
                 box_a.min.transpose();
    const PatchHierarchy tree_a = automatic(a), tree_b = automatic(b);
    for (int l = 1; l <= 3; ++l) EXPECT_GT(overlap(a, tree_a.levels[l].label, b, tree_b.levels[l].label), 0.9) << l;
}
