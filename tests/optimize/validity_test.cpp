#include "optimize/validity.hpp"

#include "problems.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

namespace {

Poses at_rest(const TriMesh& mesh) {
    return {std::vector<Eigen::Quaterniond>(mesh.num_triangles(), Eigen::Quaterniond::Identity()),
            Points::Zero(mesh.num_triangles(), 3)};
}

/// The flap of the hinge (edge along y, apexes at -1 and 1) turned by an angle about the edge.
TriMesh turned_hinge(double angle_deg) {
    TriMesh mesh = hinge(1, 1);
    const double a = angle_deg * std::numbers::pi / 180;
    mesh.vertices.row(3) << std::cos(a), 0, std::sin(a);
    return mesh;
}

}  // namespace

TEST(Validity, RestAndRigidMotionAreValid) {
    TriMesh mesh = icosphere(1);
    const ValidityGuard guard(mesh, adjacency(mesh));
    Poses poses = at_rest(mesh);
    EXPECT_EQ(guard.defect(mesh.vertices, poses), "");
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, 3).normalized()));
    for (auto& rotation : poses.rotation) rotation = turn;
    const Points moved = mesh.vertices * turn.toRotationMatrix().transpose();
    EXPECT_EQ(guard.defect(moved, poses), "");
    EXPECT_NE(guard.defect(moved, at_rest(mesh)), "");  // turned over without its prisms: inverted
}

TEST(Validity, InvertedCollapsedAndFoldedAreTold) {
    const TriMesh mesh = turned_hinge(0);
    const ValidityGuard guard(mesh, adjacency(mesh));
    Poses poses = at_rest(mesh);
    Points v = mesh.vertices;
    v.row(3) << -0.5, 0, 0;
    EXPECT_NE(guard.defect(v, poses).find("triangle 1 is inverted (1 in all)"), std::string::npos);
    v.row(3) << 5e-4, 0, 0;
    EXPECT_NE(guard.defect(v, poses).find("triangle 1 is collapsed"), std::string::npos);
    v.row(3) << 5e-3, 0, 0;
    EXPECT_EQ(guard.defect(v, poses), "");
    const double angle = 175 * std::numbers::pi / 180;
    poses.rotation[1] = Eigen::Quaterniond(Eigen::AngleAxisd(-angle, Eigen::Vector3d::UnitY()));
    EXPECT_NE(guard.defect(turned_hinge(175).vertices, poses).find("folded"), std::string::npos);
    EXPECT_EQ(guard.defect(turned_hinge(165).vertices, poses), "");
    v(0, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(guard.defect(v, poses), "");
}

TEST(Validity, AnEdgeThatIsSharpAtRestMayClose) {
    const TriMesh mesh = turned_hinge(150);
    const ValidityGuard guard(mesh, adjacency(mesh));
    Poses poses = at_rest(mesh);
    poses.rotation[1] = Eigen::Quaterniond(Eigen::AngleAxisd(-0.4, Eigen::Vector3d::UnitY()));
    EXPECT_EQ(guard.defect(turned_hinge(172).vertices, poses), "");
}

TEST(Validity, ASurfacePushedThroughItselfIsRefusedUnlessItWasSoAtTheStart) {
    // Two spheres side by side; one is moved into the other.
    const TriMesh one = icosphere(1);
    TriMesh two;
    two.vertices.resize(2 * one.num_vertices(), 3);
    two.vertices << one.vertices, one.vertices.rowwise() + Eigen::RowVector3d(3, 0, 0);
    two.triangles.resize(2 * one.num_triangles(), 3);
    two.triangles << one.triangles, one.triangles.array() + one.num_vertices();
    Poses poses;
    poses.rotation.assign(two.num_triangles(), Eigen::Quaterniond::Identity());
    poses.displacement = Points::Zero(two.num_triangles(), 3);
    Points moved = two.vertices;
    moved.bottomRows(one.num_vertices()).rowwise() -= Eigen::RowVector3d(1.5, 0.1, 0.2);
    const ValidityGuard apart(two, adjacency(two));
    EXPECT_EQ(apart.defect(two.vertices, poses), "");
    EXPECT_NE(apart.defect(moved, poses).find("intersect"), std::string::npos) << apart.defect(moved, poses);
    const ValidityGuard joined(with_vertices(two, moved), adjacency(two));
    EXPECT_EQ(joined.defect(moved, poses), "");
}
