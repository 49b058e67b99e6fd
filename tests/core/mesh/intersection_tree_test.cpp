#include "core/mesh/intersection_tree.hpp"

#include "core/mesh/pair_test.hpp"
#include "core/mesh/weld.hpp"
#include "derivatives.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace strake {
namespace {

using Pairs = std::vector<std::array<int, 2>>;

/// All pairs by the exact test alone.
Pairs all_pairs(const TriMesh& mesh) {
    const std::vector<int> number = equal_points(mesh.vertices);
    const auto corners = [&](int t) {
        Corners c;
        for (int k = 0; k < 3; ++k) {
            c.at[k] = mesh.vertices.row(mesh.triangles(t, k));
            c.id[k] = number[mesh.triangles(t, k)];
        }
        return c;
    };
    Pairs pairs;
    for (int s = 0; s < mesh.num_triangles(); ++s)
        for (int t = s + 1; t < mesh.num_triangles(); ++t)
            if (exact_meeting(corners(s), corners(t)) != Meeting::none) pairs.push_back({s, t});
    return pairs;
}

Pairs minus(const Pairs& a, const Pairs& b) {
    Pairs result;
    std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(result));
    return result;
}

/// Moved by smooth waves that fold it through itself as they grow, and by noise on every third vertex.
Points crumpled(const Points& v, double amount, double noise, unsigned seed) {
    Points result = v;
    const Eigen::VectorXd r = random_vector(v.size(), seed);
    for (int i = 0; i < v.rows(); ++i) {
        const Eigen::RowVector3d p = v.row(i);
        result.row(i) += amount * Eigen::RowVector3d(std::sin(3 * p.y()), std::sin(4 * p.z() + 1), std::cos(3 * p.x()));
        if (i % 3 == 0) result.row(i) += noise * r.segment<3>(3 * i).transpose();
    }
    return result;
}

TEST(IntersectionTree, FindsExactlyWhatTheExactTestFindsOnEveryPair) {
    const std::vector<TriMesh> surfaces{icosphere(2), strip(3, 1, 10, 6), box_surface({1, 1, 0.01}, 4),
                                        capped_cylinder(12, 6, 0.2, 3)};
    std::size_t total = 0;
    unsigned seed = 1;
    for (const TriMesh& rest : surfaces) {
        const IntersectionTree tree(rest);
        EXPECT_TRUE(tree.at_rest().apart.empty() && tree.at_rest().adjacent.empty());
        for (const double amount : {0.0, 1e-3, 0.2, 0.6})
            for (const double noise : {0.0, 1e-9, 0.05, 0.3}) {
                const TriMesh now = with_vertices(rest, crumpled(rest.vertices, amount, noise, seed++));
                const Pairs expected = all_pairs(now);
                EXPECT_EQ(tree.fresh(now.vertices), expected) << amount << " " << noise;
                total += expected.size();
            }
    }
    EXPECT_GT(total, 2000u);
}

TEST(IntersectionTree, CoplanarOverlapsAreFound) {
    // Flat strips turned out of the axes: no plane of a triangle separates anything.
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    TriMesh rest = strip(2, 1, 8, 4);
    rest.vertices = rest.vertices * turn.transpose();
    const IntersectionTree tree(rest);
    TriMesh now = strip(2, 1, 8, 4);
    for (int v = 0; v < now.num_vertices(); ++v)  // folded in its plane over the line x = 1.1
        if (now.vertices(v, 0) > 1.1) now.vertices(v, 0) = 2.2 - now.vertices(v, 0);
    for (const bool turned : {false, true}) {
        if (turned) now.vertices = now.vertices * turn.transpose();
        const Pairs expected = all_pairs(now);
        EXPECT_GT(expected.size(), 20u);
        EXPECT_EQ(tree.fresh(now.vertices), expected);
    }
}

TEST(IntersectionTree, PairsOfTheStartAndPairsThatStayedAreOmitted) {
    const TriMesh one = icosphere(1);
    TriMesh three;
    three.vertices.resize(3 * one.num_vertices(), 3);
    three.vertices << one.vertices, one.vertices.rowwise() + Eigen::RowVector3d(1.4, 0.1, 0),
        one.vertices.rowwise() + Eigen::RowVector3d(6, 0, 0);
    three.triangles.resize(3 * one.num_triangles(), 3);
    three.triangles << one.triangles, one.triangles.array() + one.num_vertices(),
        one.triangles.array() + 2 * one.num_vertices();
    const IntersectionTree tree(three);
    const Pairs before = all_pairs(three);
    EXPECT_GT(before.size(), 10u);
    EXPECT_EQ(tree.at_rest().apart, before);
    EXPECT_TRUE(tree.fresh(three.vertices).empty());
    TriMesh now = three;
    now.vertices.bottomRows(one.num_vertices()).rowwise() -= Eigen::RowVector3d(3.2, 0.05, 0);
    const Pairs fresh = tree.fresh(now.vertices);
    EXPECT_EQ(fresh, minus(all_pairs(now), before));
    for (const auto& pair : fresh) EXPECT_GE(pair[1], 2 * one.num_triangles());
}

TEST(IntersectionTree, ASeamMayMoveToRoundOffButNotOpenIntoTheOtherSide) {
    // Two strips that share the line x = 1 by coordinates only.
    const TriMesh one = strip(1, 1, 3, 3);
    TriMesh both;
    both.vertices.resize(2 * one.num_vertices(), 3);
    both.vertices << one.vertices, one.vertices.rowwise() + Eigen::RowVector3d(1, 0, 0);
    both.triangles.resize(2 * one.num_triangles(), 3);
    both.triangles << one.triangles, one.triangles.array() + one.num_vertices();
    const IntersectionTree tree(both);
    const auto moved_by = [&](double x, double y, double z) {
        Points moved = both.vertices;
        moved.bottomRows(one.num_vertices()).rowwise() += Eigen::RowVector3d(x, y, z);
        return tree.fresh(moved);
    };
    EXPECT_TRUE(moved_by(-1e-15, 1e-15, 1e-15).empty());
    EXPECT_FALSE(moved_by(-1e-3, 0, 0).empty());
    EXPECT_TRUE(moved_by(0.1, 0, 0).empty());
}

TEST(IntersectionTree, VerdictsDoNotDependOnTheOrderOfTheTriangles) {
    const TriMesh rest = icosphere(2);
    std::vector<int> vertex_order, triangle_order;
    const TriMesh other = renumbered(rest, 5, &vertex_order, &triangle_order);
    const Points now = crumpled(rest.vertices, 0.6, 0, 3);
    Points other_now = now;
    for (int v = 0; v < rest.num_vertices(); ++v) other_now.row(v) = now.row(vertex_order[v]);
    Pairs mapped;
    for (const auto& [s, t] : IntersectionTree(other).fresh(other_now))
        mapped.push_back(
            {std::min(triangle_order[s], triangle_order[t]), std::max(triangle_order[s], triangle_order[t])});
    std::sort(mapped.begin(), mapped.end());
    EXPECT_FALSE(mapped.empty());
    EXPECT_EQ(IntersectionTree(rest).fresh(now), mapped);
}

TEST(PairSeparation, IsNeverWrongAndSeldomUndecided) {
    // Nearly touching pairs at all scales: whatever is called disjoint must be so exactly.
    int sure = 0, disjoint = 0;
    for (unsigned seed = 0; seed < 4000; ++seed) {
        const Eigen::VectorXd r = random_vector(24, seed);
        const double scale = std::pow(10.0, 30 * r[23]), gap = std::pow(10.0, -8 + 8 * r[22]);
        Corners a, b;
        const int shared = static_cast<int>(seed % 3);
        for (int k = 0; k < 3; ++k) {
            a.at[k] = scale * r.segment<3>(3 * k);
            b.at[k] = scale * r.segment<3>(9 + 3 * k);
            if (seed % 2) {  // flat on each other, but for the gap
                a.at[k].z() = 0;
                b.at[k].z() = scale * gap * r[20];
            }
            a.id[k] = k;
            b.id[k] = 10 + k;
        }
        for (int k = 0; k < shared; ++k) {
            b.at[2 - k] = a.at[k];
            b.id[2 - k] = k;
        }
        const bool meet = exact_meeting(a, b) != Meeting::none;
        disjoint += !meet;
        if (!surely_disjoint(a, b)) continue;
        ++sure;
        EXPECT_FALSE(meet) << seed;
    }
    EXPECT_GT(disjoint, 1000);
    EXPECT_GT(sure, 0.95 * disjoint);
}

}  // namespace
}  // namespace strake
