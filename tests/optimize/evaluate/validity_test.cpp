#include "optimize/evaluate/validity.hpp"

#include "core/error.hpp"
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

TEST(Validity, AMessageSaysWhere) {
    const TriMesh mesh = turned_hinge(0);
    const ValidityGuard guard(mesh, adjacency(mesh));
    Points v = mesh.vertices;
    v.row(3) << -0.75, 0, 0;
    EXPECT_EQ(guard.defect(v, at_rest(mesh)), "triangle 1 is inverted (1 in all), at (-0.25, 0, 0)");
    v(2, 1) = std::numeric_limits<double>::infinity();
    EXPECT_EQ(guard.defect(v, at_rest(mesh)), "vertex 2 is not finite");
    EXPECT_THROW(guard.defect(v.topRows(3), at_rest(mesh)), InvalidInput);
}

TEST(Validity, AFixedVertexMayNotMoveByABit) {
    const TriMesh mesh = icosphere(1);
    const ValidityGuard guard(mesh, adjacency(mesh), {{5, 6}, std::nullopt});
    Points v = mesh.vertices;
    const int held = mesh.triangles(5, 1);
    v(held, 2) = std::nextafter(v(held, 2), 2.0);
    EXPECT_NE(guard.defect(v, at_rest(mesh)).find("fixed vertex " + std::to_string(held) + " has moved"),
              std::string::npos);
    EXPECT_EQ(ValidityGuard(mesh, adjacency(mesh)).defect(v, at_rest(mesh)), "");
    EXPECT_THROW(ValidityGuard(mesh, adjacency(mesh), {{mesh.num_triangles()}, std::nullopt}), InvalidInput);
}

namespace {

/// Every prism turned so that its normal is that of the mirror image in x: nothing is inverted by its own prism.
Poses following(const TriMesh& mesh, const TriMesh& now) {
    Poses poses = at_rest(mesh);
    const Points from = triangle_normals(mesh), to = triangle_normals(now);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        poses.rotation[t].setFromTwoVectors(Eigen::Vector3d(from.row(t)), Eigen::Vector3d(to.row(t)));
    return poses;
}

}  // namespace

TEST(Validity, AClosedPartTurnedInsideOutIsRefused) {
    const TriMesh mesh = icosphere(2);
    const TriMesh everted = with_vertices(mesh, mesh.vertices * Eigen::Vector3d(-1, 1, 1).asDiagonal());
    const Poses poses = following(mesh, everted);
    const std::string words = ValidityGuard(mesh, adjacency(mesh)).defect(everted.vertices, poses);
    EXPECT_NE(words.find("inside out"), std::string::npos) << words;
    // An inward surface, like that of a flow domain, may stay inward.
    TriMesh inward = mesh;
    inward.triangles.col(1).swap(inward.triangles.col(2));
    EXPECT_EQ(ValidityGuard(inward, adjacency(inward)).defect(mesh.vertices, at_rest(mesh)), "");
}

TEST(Validity, AHalfModelIsClosedTogetherWithItsPlane) {
    // The half y > 0 of a box, open on y = 0, mirrored in x: a valid surface but for its volume.
    TriMesh box = box_surface({1, 1, 1}, 2), half = box;
    half.triangles.resize(0, 3);
    for (int t = 0; t < box.num_triangles(); ++t) {
        if ((box.vertices(box.triangles(t, 0), 1) + box.vertices(box.triangles(t, 1), 1) +
             box.vertices(box.triangles(t, 2), 1)) == 0)
            continue;
        half.triangles.conservativeResize(half.triangles.rows() + 1, 3);
        half.triangles.bottomRows(1) = box.triangles.row(t);
    }
    const TriMesh mirrored = with_vertices(half, half.vertices * Eigen::Vector3d(-1, 1, 1).asDiagonal());
    const Poses poses = following(half, mirrored);
    const SymmetryPlane plane{Eigen::Vector3d::UnitY(), 0};
    EXPECT_EQ(ValidityGuard(half, adjacency(half)).defect(mirrored.vertices, poses), "");  // open: no volume
    EXPECT_NE(ValidityGuard(half, adjacency(half), {{}, plane}).defect(mirrored.vertices, poses).find("inside out"),
              std::string::npos);
    EXPECT_EQ(ValidityGuard(half, adjacency(half), {{}, plane}).defect(half.vertices, at_rest(half)), "");
}
