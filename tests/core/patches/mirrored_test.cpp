#include "core/patches/mirrored.hpp"

#include "cases/geometry/lifting_body.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <map>
#include <set>

namespace strake {
namespace {

std::vector<int> images(const TriMesh& mesh, const SymmetryPlane& plane) {
    const ClosestPointTree tree(mesh);
    const Points c = triangle_centroids(mesh);
    std::vector<int> image;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::Vector3d x = c.row(t);
        image.push_back(tree.find(x - 2 * (plane.normal.dot(x) - plane.offset) * plane.normal).triangle);
    }
    return image;
}

/// Triangles whose image is not in the patch that has the images of most of their patch.
int without_image(const PatchLevel& level, const std::vector<int>& image) {
    std::vector<std::map<int, int>> met(level.patches.size());
    for (std::size_t t = 0; t < image.size(); ++t) ++met[level.label[t]][level.label[image[t]]];
    int off = 0;
    for (const auto& others : met) {
        int all = 0, most = 0;
        for (const auto& [other, count] : others) all += count, most = std::max(most, count);
        off += all - most;
    }
    return off;
}

void expect_nested_and_connected(const TriMesh& mesh, const PatchHierarchy& tree) {
    const Adjacency adjacent = adjacency(mesh);
    for (std::size_t k = 1; k < tree.levels.size(); ++k) {
        const PatchLevel& level = tree.levels[k];
        std::set<std::string> names;
        for (const Patch& patch : level.patches) {
            names.insert(patch.name);
            std::vector<char> reached(mesh.num_triangles(), 0);
            std::vector<int> stack{patch.triangles.front()};
            reached[stack[0]] = 1;
            std::size_t count = 0;
            while (!stack.empty()) {
                const int t = stack.back();
                stack.pop_back();
                ++count;
                EXPECT_EQ(tree.levels[k - 1].label[t], patch.parent);
                for (int e = 0; e < 3; ++e)
                    for (const int n : adjacent.edge_triangles[adjacent.triangle_edges(t, e)])
                        if (!reached[n] && level.label[n] == patch.id) reached[n] = 1, stack.push_back(n);
            }
            EXPECT_EQ(count, patch.triangles.size()) << "level " << k << ", patch " << patch.name;
        }
        EXPECT_EQ(names.size(), level.patches.size());
    }
}

/// An ellipsoid whose triangles are not mirror images: its own image as a shape only.
TriMesh ellipsoid_of_turned_triangles() {
    TriMesh mesh = icosphere(4);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    mesh.vertices = (mesh.vertices * turn * Eigen::Vector3d(2, 1, 0.4).asDiagonal()).eval();
    return mesh;
}

TEST(Mirrored, PatchesOfALiftingBodyAreImagesTriangleForTriangle) {
    const SymmetryPlane plane{Eigen::Vector3d::UnitY(), 0};
    for (const int triangles : {3000, 9000}) {
        const TriMesh mesh = example::lifting_body(triangles);
        const Adjacency adjacent = adjacency(mesh);
        const PatchHierarchy tree = segment_automatically(mesh, adjacent, {{4, 12, 32}});
        const PatchHierarchy made = mirrored(tree, mesh, adjacent, plane);
        const std::vector<int> image = images(mesh, plane);
        ASSERT_EQ(made.levels.size(), tree.levels.size());
        int before = 0;
        for (std::size_t k = 1; k < made.levels.size(); ++k) {
            before += without_image(tree.levels[k], image);
            EXPECT_EQ(without_image(made.levels[k], image), 0) << "level " << k;
            EXPECT_NEAR(static_cast<double>(made.levels[k].patches.size()),
                        static_cast<double>(tree.levels[k].patches.size()), 0.35 * tree.levels[k].patches.size());
            int alike = 0;
            for (int t = 0; t < mesh.num_triangles(); ++t) {
                const auto& other = tree.levels[k].patches[tree.levels[k].label[t]].triangles;
                const auto& mine = made.levels[k].patches[made.levels[k].label[t]].triangles;
                alike +=
                    std::abs(static_cast<double>(other.size()) - static_cast<double>(mine.size())) < 0.1 * other.size();
            }
            EXPECT_GT(alike, 0.95 * mesh.num_triangles()) << "level " << k;
        }
        EXPECT_GT(before, 0) << "the test sees the difference";
        expect_nested_and_connected(mesh, made);
    }
}

TEST(Mirrored, WhereOnlyTheShapeIsSymmetricPatchesStayWhole) {
    const TriMesh mesh = ellipsoid_of_turned_triangles();
    const Adjacency adjacent = adjacency(mesh);
    for (int axis = 0; axis < 3; ++axis) {
        const SymmetryPlane plane{Eigen::Vector3d::Unit(axis), 0};
        const PatchHierarchy tree = segment_automatically(mesh, adjacent, {{3, 12, 40}});
        const PatchHierarchy made = mirrored(tree, mesh, adjacent, plane);
        expect_nested_and_connected(mesh, made);
        const std::vector<int> image = images(mesh, plane);
        for (std::size_t k = 1; k < made.levels.size(); ++k) {
            // No more than the triangles that borders cut.
            EXPECT_LT(without_image(made.levels[k], image), 0.03 * mesh.num_triangles()) << "level " << k;
            EXPECT_LT(without_image(made.levels[k], image), without_image(tree.levels[k], image));
        }
    }
}

TEST(Mirrored, WhatIsSymmetricStaysAsItIs) {
    const TriMesh mesh = example::lifting_body(3000);
    const Adjacency adjacent = adjacency(mesh);
    const SymmetryPlane plane{Eigen::Vector3d::UnitY(), 0};
    const PatchHierarchy once = mirrored(segment_automatically(mesh, adjacent), mesh, adjacent, plane);
    const PatchHierarchy twice = mirrored(once, mesh, adjacent, plane);
    for (std::size_t k = 0; k < once.levels.size(); ++k) {
        EXPECT_EQ(once.levels[k].label, twice.levels[k].label);
        for (std::size_t p = 0; p < once.levels[k].patches.size(); ++p)
            EXPECT_EQ(once.levels[k].patches[p].name, twice.levels[k].patches[p].name);
    }
}

}  // namespace
}  // namespace strake
