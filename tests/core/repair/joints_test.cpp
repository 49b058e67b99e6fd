#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/topology.hpp"
#include "core/repair/joint_gap.hpp"
#include "core/repair/repair.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

/// Two long boxes of twelve triangles that pass through each other.
TriMesh crossing_boxes() {
    const TriMesh along = box_surface({4, 0.5, 0.6}, 1);
    TriMesh across = box_surface({0.7, 3, 0.2}, 1);
    across.vertices.rowwise() += Eigen::RowVector3d(1.61, -1.27, 0.18);
    TriMesh both;
    both.vertices.resize(16, 3);
    both.vertices << along.vertices, across.vertices;
    both.triangles.resize(24, 3);
    both.triangles << along.triangles, Triangles(across.triangles.array() + 8);
    return both;
}

Points bent(const Points& x) {
    Points moved = x;
    for (Eigen::Index v = 0; v < x.rows(); ++v) moved(v, 2) += 0.02 * x(v, 0) * x(v, 0) + 0.03 * x(v, 1) * x(v, 1);
    return moved;
}

double gap_of_joints(const TriMesh& mesh) { return joint_gap(mesh, self_intersections(mesh), bent(mesh.vertices)); }

RepairResult with_joints(const TriMesh& mesh, double limit) {
    RepairOptions options;
    options.joints = limit;
    return repair(mesh, options);
}

TEST(Joints, StayClosedWithTheSquareOfTheirEdges) {
    const TriMesh mesh = crossing_boxes();
    const double before = gap_of_joints(mesh);
    EXPECT_GT(before, 0.01) << "as long triangles leave it";
    EXPECT_LT(joint_gap(mesh, self_intersections(mesh), 2 * mesh.vertices), 1e-14) << "linear maps open none";
    for (const double limit : {0.2, 0.1, 0.05}) {
        const RepairResult mended = with_joints(mesh, limit);
        // Both leave the bent shape by at most edge^2 / 8 times its curvature, 0.06.
        EXPECT_LT(gap_of_joints(mended.mesh), 2 * limit * limit * 0.06 / 8 + 1e-12) << limit;
        for (const auto& pair : self_intersections(mended.mesh))
            for (const int t : pair)
                for (int k = 0; k < 3; ++k) {
                    const int a = mended.mesh.triangles(t, k), b = mended.mesh.triangles(t, (k + 1) % 3);
                    EXPECT_LE((mended.mesh.vertices.row(a) - mended.mesh.vertices.row(b)).norm(), limit);
                }
    }
}

TEST(Joints, LeaveTheSurfaceWhereItIs) {
    const TriMesh mesh = crossing_boxes();
    const RepairResult mended = with_joints(mesh, 0.1);
    EXPECT_TRUE(mended.after.facts.closed);
    EXPECT_EQ(mended.after.facts.components, 2);
    EXPECT_EQ(mended.mesh.vertices.topRows(16), mesh.vertices);
    EXPECT_NEAR(surface_area(mended.mesh), surface_area(mesh), 1e-12);
    EXPECT_EQ(with_joints(mended.mesh, 0.1).items.size(), 0) << "nothing is left to halve";
    ASSERT_GT(mended.count(RepairKind::joint), 4);
    EXPECT_EQ(mended.mesh.num_triangles(), static_cast<int>(mended.source_triangle.size()));
    int added = 0;
    for (const RepairItem& item : mended.items) added += item.triangles;
    EXPECT_EQ(mended.mesh.num_triangles(), 24 + added);
    // Only where the parts meet: the ends of the long box stay coarse.
    EXPECT_LT(mended.mesh.num_triangles(), 8000);
    for (int t = 0; t < mended.mesh.num_triangles(); ++t) {
        const int source = mended.source_triangle[static_cast<std::size_t>(t)];
        const Eigen::RowVector3d a = mesh.vertices.row(mesh.triangles(source, 0));
        const Eigen::Vector3d n = triangle_normals(mesh).row(source);
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR((mended.mesh.vertices.row(mended.mesh.triangles(t, k)) - a) * n, 0, 1e-14) << "in its plane";
    }
}

TEST(Joints, WithoutACutNothingIsHalvedAndALengthMustBePositive) {
    const TriMesh box = box_surface({1, 1, 1}, 1);
    EXPECT_EQ(with_joints(box, 0.01).mesh.num_triangles(), 12);
    EXPECT_THROW(with_joints(box, 0), InvalidInput);
    EXPECT_THROW(with_joints(crossing_boxes(), 1e-7), InvalidInput) << "too many triangles";
}

}  // namespace
}  // namespace strake
