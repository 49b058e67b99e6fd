#include <gtest/gtest.h>

#include <cmath>

#include "core/primo/shell_impl.hpp"
#include "shells.hpp"

using namespace strake;

namespace {

struct Body {
    TriMesh mesh = ellipsoid({1, 0.5, 0.3}, 3);
    ShellOptions options = make_options(mesh);
    static ShellOptions make_options(const TriMesh& mesh) {
        ShellOptions o = uniform(mesh, 0.06);
        pin_where(mesh, o, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < -0.7; });
        return o;
    }
    static Loads loads(const TriMesh& mesh) {
        return traction_where(mesh, {1e-4, 5e-4, 1e-3}, [](const Eigen::Vector3d& c) { return c.x() > 0.5; });
    }
};

}  // namespace

TEST(Invariance, RigidMotionCostsNoEnergy) {
    Body body;
    PrimoShell shell(body.mesh, uniform(body.mesh, 0.06));
    const Eigen::Quaterniond R(Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, 2, -0.5).normalized()));
    Poses poses = shell.poses();
    const Points centroids = triangle_centroids(body.mesh);
    for (int i = 0; i < body.mesh.num_triangles(); ++i) {
        poses.rotation[i] = R;
        const Eigen::Vector3d c = centroids.row(i);
        poses.displacement.row(i) = (R * c - c + Eigen::Vector3d(3, -1, 2)).transpose();
    }
    shell.set_poses(poses);
    EXPECT_LT(shell.energy(), 1e-25);  // squares of round-off, 1e-16 * size
    EXPECT_LT(shell.gradient().cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Invariance, NoLoadReturnsTheInputBitForBit) {
    Body body;
    PrimoShell shell(body.mesh, body.options);
    ASSERT_EQ(shell.solve({}).status, SolveStatus::converged);
    EXPECT_TRUE((shell.vertices().array() == body.mesh.vertices.array()).all());
}

TEST(Invariance, FixedVerticesAreBitIdentical) {
    Body body;
    PrimoShell shell(body.mesh, body.options);
    ASSERT_EQ(shell.solve(Body::loads(body.mesh)).status, SolveStatus::converged);
    const Points v = shell.vertices();
    int fixed = 0;
    for (int k = 0; k < v.rows(); ++k)
        if (shell.fixed_vertices()[k]) {
            ++fixed;
            EXPECT_TRUE((v.row(k).array() == body.mesh.vertices.row(k).array()).all());
        }
    EXPECT_GT(fixed, 10);
    EXPECT_GT((v - body.mesh.vertices).cwiseAbs().maxCoeff(), 0.01);
}

TEST(Invariance, RenumberingChangesNothing) {
    Body body;
    PrimoShell shell(body.mesh, body.options);
    ASSERT_EQ(shell.solve(Body::loads(body.mesh)).status, SolveStatus::converged);
    const Points v = shell.vertices();
    std::vector<int> order;
    const TriMesh other = renumbered(body.mesh, 3, &order);
    PrimoShell again(other, Body::make_options(other));
    ASSERT_EQ(again.solve(Body::loads(other)).status, SolveStatus::converged);
    const Points w = again.vertices();
    for (int k = 0; k < v.rows(); ++k) EXPECT_LT((w.row(k) - v.row(order[k])).norm(), 1e-10);
}

// A scattered order is made local inside, by the free prisms' numbers, and nobody outside sees that.
TEST(Invariance, AScatteredOrderIsMadeLocalInside) {
    Body body;
    body.mesh = ellipsoid({1, 0.5, 0.3}, 4);
    body.options = Body::make_options(body.mesh);
    std::vector<int> order;
    const TriMesh other = renumbered(body.mesh, 3, &order);
    PrimoShell a(body.mesh, body.options), b(other, Body::make_options(other));
    const RestState& rest = b.impl().rest;
    for (int f = 0; f < rest.num_free(); ++f) {
        ASSERT_EQ(rest.free_index[rest.free_prisms[f]], f);
        ASSERT_EQ(rest.pin[rest.free_prisms[f]], free_prism);
    }
    double apart = 0, file_apart = 0;
    for (const SharedFace& face : rest.faces) {
        if (rest.pin[face.i] != free_prism || rest.pin[face.j] != free_prism) continue;
        apart = std::max(apart, std::abs(1.0 * rest.free_index[face.i] - rest.free_index[face.j]));
        file_apart = std::max(file_apart, std::abs(1.0 * face.i - face.j));
    }
    EXPECT_GT(file_apart, 0.9 * rest.num_prisms());
    EXPECT_LT(apart, 0.1 * rest.num_prisms());
    ASSERT_EQ(a.solve(Body::loads(body.mesh)).status, SolveStatus::converged);
    ASSERT_EQ(b.solve(Body::loads(other)).status, SolveStatus::converged);
    const Points moved = a.vertices(), seen = b.vertices();
    const ShellSensitivities da = a.adjoint({moved})[0], db = b.adjoint({seen})[0];
    for (int k = 0; k < moved.rows(); ++k) {
        ASSERT_LT((seen.row(k) - moved.row(order[k])).norm(), 1e-9);
        ASSERT_LT((db.force.row(k) - da.force.row(order[k])).norm(), 1e-7 * da.force.norm());
    }
}

TEST(Invariance, ChangeOfUnitScalesTractionInversely) {
    Body body;
    const double s = 1000;
    PrimoShell shell(body.mesh, body.options);
    const Loads loads = Body::loads(body.mesh);
    ASSERT_EQ(shell.solve(loads).status, SolveStatus::converged);
    TriMesh big = body.mesh;
    big.vertices *= s;
    ShellOptions options = body.options;
    options.prism_height *= s;
    PrimoShell other(big, options);
    ASSERT_EQ(other.solve({loads.force * s, {}}).status, SolveStatus::converged);  // traction / s on s^2 the area
    EXPECT_LT((other.vertices() / s - shell.vertices()).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(Symmetry, HalfModelGivesTheFullModelsShape) {
    // Half a cylinder about the x axis, cut by the plane y = 0, and the same with its mirror image.
    const TriMesh cylinder = capped_cylinder(24, 16, 0.4, 2);
    TriMesh half = cylinder, full;
    half.vertices = (half.vertices.array().abs() < 1e-12).select(0, half.vertices);
    std::vector<int> above;
    for (int t = 0; t < cylinder.num_triangles(); ++t) {
        double lowest = 1;
        for (int k = 0; k < 3; ++k) lowest = std::min(lowest, half.vertices(cylinder.triangles(t, k), 1));
        if (lowest >= 0) above.push_back(t);
    }
    ASSERT_EQ(2 * static_cast<int>(above.size()), cylinder.num_triangles());
    half.triangles.resize(above.size(), 3);
    for (std::size_t i = 0; i < above.size(); ++i) half.triangles.row(i) = cylinder.triangles.row(above[i]);
    full.vertices.resize(2 * half.num_vertices(), 3);
    full.vertices << half.vertices, half.vertices * Eigen::Vector3d(1, -1, 1).asDiagonal();
    full.triangles.resize(2 * half.num_triangles(), 3);
    for (int t = 0; t < half.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int v = half.triangles(t, k), mirrored = half.vertices(v, 1) == 0 ? v : v + half.num_vertices();
            full.triangles(t, k) = v;
            full.triangles(half.num_triangles() + t, 2 - k) = mirrored;
        }

    const auto traction = [](const Eigen::Vector3d& x) { return x.x() > 1.5; };
    const auto pinned = [](const TriMesh& mesh) {
        ShellOptions options = uniform(mesh, 0.06);
        pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < 0.2; });
        return options;
    };
    PrimoShell whole(full, pinned(full));
    ASSERT_EQ(whole.solve(traction_where(full, {0, 0, 2e-3}, traction)).status, SolveStatus::converged);
    ShellOptions options = pinned(half);
    options.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    PrimoShell part(half, options);
    ASSERT_EQ(part.solve(traction_where(half, {0, 0, 2e-3}, traction)).status, SolveStatus::converged);
    const Points v = whole.vertices(), w = part.vertices();
    double moved = 0, apart = 0;
    for (int t = 0; t < half.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int at = half.triangles(t, k);
            moved = std::max(moved, (w.row(at) - half.vertices.row(at)).norm());
            apart = std::max(apart, (w.row(at) - v.row(at)).norm());
        }
    EXPECT_GT(moved, 0.02);
    EXPECT_LT(apart, 1e-10);
}

TEST(Held, UnheldPartIsNamed) {
    Body body;
    PrimoShell shell(body.mesh, uniform(body.mesh, 0.06));
    try {
        shell.solve(Body::loads(body.mesh));
        FAIL() << "not refused";
    } catch (const UnheldPart& e) {
        EXPECT_NE(std::string(e.what()).find("6 free rigid motions"), std::string::npos) << e.what();
    }
    Loads sprung = Body::loads(body.mesh);
    sprung.spring = Eigen::VectorXd::Zero(body.mesh.num_vertices());
    sprung.spring.head(2).setConstant(1);  // two points leave the rotation about their line
    EXPECT_THROW(shell.solve(sprung), UnheldPart);
    sprung.spring.setConstant(0.01);
    EXPECT_EQ(shell.solve(sprung).status, SolveStatus::converged);
}

TEST(Held, DegenerateTrianglesAreRefusedWithTheirNumbers) {
    TriMesh mesh = icosphere(1);
    mesh.vertices.row(mesh.triangles(7, 1)) = mesh.vertices.row(mesh.triangles(7, 0));
    EXPECT_THROW(PrimoShell(mesh, uniform(mesh, 0.1)), std::invalid_argument);
}
