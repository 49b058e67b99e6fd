#include "core/primo/linear/multigrid.hpp"

#include <gtest/gtest.h>

#include "../shells.hpp"
#include "cases/geometry/closed_body.hpp"
#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/wing.hpp"
#include "core/error.hpp"
#include "core/primo/energy.hpp"
#include "core/primo/linear/spd_solver.hpp"

/// What multigrid promises: as many iterations whatever the size of the triangles and the thickness of the prisms, the
/// answer of a direct factor, the same bits every time, and never an answer to an indefinite matrix.
namespace strake {
namespace {

/// The shell's system at rest: pinned where the least coordinate along `axis` is, pulled sideways elsewhere.
struct System {
    BlockMatrix H;
    Points centre;
    Eigen::VectorXd b;

    System(const TriMesh& mesh, double height, int axis, double spring = 0, bool pinned = true) {
        ShellOptions options = uniform(mesh, height);
        const double low = mesh.vertices.col(axis).minCoeff(), high = mesh.vertices.col(axis).maxCoeff();
        if (pinned)
            pin_where(mesh, options, fixed_prism,
                      [&](const Eigen::Vector3d& x) { return x[axis] < low + 0.05 * (high - low); });
        const RestState rest = rest_state(mesh, options);
        Loads loads = complete(traction_where(mesh, {0, 0, 1}, [&](const Eigen::Vector3d& x) { return x[axis] > 0; }),
                               mesh.num_vertices());
        loads.spring.setConstant(spring);
        const std::vector<Eigen::Matrix3d> turn(rest.num_prisms(), Eigen::Matrix3d::Zero());
        const Poses still{std::vector<Eigen::Quaterniond>(rest.num_prisms(), Eigen::Quaterniond::Identity()),
                          Points::Zero(rest.num_prisms(), 3)};
        H = hessian_pattern(rest);
        Loads springs = complete({}, mesh.num_vertices());
        springs.spring = loads.spring;
        assemble_hessian(rest, turn, jumps(rest, still, turn), springs, StressTerm::exact, H);
        if (spring > 0) add_lumped_springs(rest, turn, springs.spring, H);
        b = vertex_wrenches(rest, turn, loads.force);
        centre = rest.centroid(rest.free_prisms, Eigen::all);
    }
};

double edge_length(const TriMesh& mesh) { return std::sqrt(triangle_areas(mesh).mean() * 4 / std::sqrt(3.0)); }

struct Solved {
    KrylovResult end;
    double error = 0;  ///< against the direct factor, relative
    bool single = true;
};

Solved solve(const System& system) {
    Multigrid multigrid;
    EXPECT_TRUE(multigrid.setup(system.H, system.centre));
    Solved solved;
    solved.end = multigrid.solve(system.H, system.b, 1e-8);
    solved.single = multigrid.is_single_precision();
    EXPECT_TRUE(solved.end.positive);
    EXPECT_LE(solved.end.relative_residual, 1e-8);
    SpdSolver direct;
    direct.analyze(system.H);
    EXPECT_TRUE(direct.factorize(system.H));
    Eigen::VectorXd x = direct.solve(system.b);
    for (int step = 0; step < 4; ++step) x += direct.solve(Eigen::VectorXd(system.b - system.H.multiply(x)));
    solved.error = (solved.end.x - x).norm() / x.norm();
    return solved;
}

}  // namespace

TEST(Multigrid, NeedsAsManyIterationsAtEverySizeAndHeight) {
    for (const int triangles : {4000, 16000})
        for (const double edges : {2.0, 10.0}) {
            const TriMesh wing = example::wing(triangles), body = example::lifting_body(triangles);
            const Solved on_wing = solve(System(wing, edges * edge_length(wing), 1));
            const Solved on_body = solve(System(body, edges * edge_length(body), 0));
            for (const Solved& solved : {on_wing, on_body}) {
                EXPECT_LE(solved.end.iterations, 30) << triangles << " triangles, " << edges << " edges thick";
                EXPECT_LE(solved.error, 1e-8);
                EXPECT_TRUE(solved.single);
            }
        }
}

TEST(Multigrid, LongThinTrianglesDoNotStallIt) {
    const TriMesh mesh = example::naca_wing(0.1, 95, 57, 3);  // aspect ratios up to 190
    const Solved solved = solve(System(mesh, 0.02 * box_diagonal(mesh), 1));
    EXPECT_LE(solved.end.iterations, 60);
    EXPECT_LE(solved.error, 1e-7);
}

TEST(Multigrid, WhatIsTooSoftForSinglePrecisionIsSolvedInDouble) {
    TriMesh needle = example::lifting_body(6000);
    needle.vertices.col(0) *= 30;
    const Solved solved = solve(System(needle, 0.02 * box_diagonal(needle), 0));
    EXPECT_FALSE(solved.single);
    EXPECT_LE(solved.end.iterations, 100);
    EXPECT_LE(solved.error, 1e-6);
}

TEST(Multigrid, SpringsBesidePinsAndAlone) {
    const TriMesh mesh = example::sphere(3000);
    for (const bool pinned : {true, false}) {
        const Solved solved = solve(System(mesh, 0.1, 2, 1e-3, pinned));
        EXPECT_LE(solved.end.iterations, 30) << pinned;
        EXPECT_LE(solved.error, 1e-8) << pinned;
    }
}

TEST(Multigrid, SameBitsEveryTimeAndAfterAnUpdate) {
    const TriMesh mesh = example::wing(3000);
    const System system(mesh, 0.08, 1), thicker(mesh, 0.082, 1);
    Multigrid first, second;
    ASSERT_TRUE(first.setup(system.H, system.centre));
    const Eigen::VectorXd x = first.apply(system.b);
    EXPECT_EQ(x, first.apply(system.b));
    ASSERT_TRUE(second.setup(system.H, system.centre));
    EXPECT_EQ(x, second.apply(system.b));
    ASSERT_TRUE(second.update(thicker.H, thicker.centre));
    EXPECT_NE(x, second.apply(system.b));
    EXPECT_LE(second.solve(thicker.H, system.b, 1e-8).iterations, 30);
    ASSERT_TRUE(second.update(system.H, system.centre));
    EXPECT_EQ(x, second.apply(system.b));
}

TEST(Multigrid, AnIndefiniteMatrixIsNeverSolved) {
    const TriMesh mesh = example::wing(2000);
    System system(mesh, 0.02, 1);
    // Softer by a little more than its softest mode: only a smooth motion of the whole is unstable.
    SpdSolver direct;
    direct.analyze(system.H);
    ASSERT_TRUE(direct.factorize(system.H));
    Eigen::VectorXd mode = system.b;
    for (int step = 0; step < 30; ++step) mode = direct.solve(Eigen::VectorXd(mode.normalized()));
    const double softest = 1 / mode.norm();
    for (const double share : {1.5, 20.0}) {
        BlockMatrix H = system.H;
        for (Matrix6& block : H.diagonal) block -= share * softest * Matrix6::Identity();
        Multigrid multigrid;
        if (!multigrid.setup(H, system.centre)) continue;
        EXPECT_FALSE(multigrid.solve(H, system.b, 1e-8).positive) << share;
    }
}

TEST(Multigrid, PartsThatTouchNothingAndTinySystems) {
    BlockMatrix A = block_matrix(700, {{0, 1}, {1, 2}});
    for (Matrix6& block : A.diagonal) block = 2 * Matrix6::Identity();
    for (Matrix6& block : A.below) block = -0.5 * Matrix6::Identity();
    for (const int size : {1, 3, 700}) {
        BlockMatrix part = A;
        part.diagonal.resize(size);
        if (size == 1) part = block_matrix(1, {}), part.diagonal[0] = 3 * Matrix6::Identity();
        part.begin.resize(size + 1);
        const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(6 * size, -1, 2);
        Multigrid multigrid;
        ASSERT_TRUE(multigrid.setup(part, Points::Random(size, 3)));
        const KrylovResult end = multigrid.solve(part, b, 1e-10);
        EXPECT_LE((part.multiply(end.x) - b).norm(), 1e-9 * b.norm()) << size;
        EXPECT_EQ(multigrid.apply(Eigen::VectorXd::Zero(6 * size)).norm(), 0);
    }
}

TEST(Multigrid, WrongInputIsNamed) {
    const System system(example::wing(1000), 0.02, 1);
    Multigrid multigrid;
    EXPECT_THROW(multigrid.apply(system.b), SolverError);
    EXPECT_THROW((void)multigrid.setup(system.H, Points::Zero(3, 3)), InvalidInput);
    EXPECT_THROW((void)multigrid.setup(BlockMatrix(), Points::Zero(0, 3)), InvalidInput);
    for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        BlockMatrix H = system.H;
        H.below[7](1, 2) = wrong;
        EXPECT_THROW((void)multigrid.setup(H, system.centre), SolverError);
    }
    EXPECT_FALSE(multigrid.is_ready());
}

}  // namespace strake
