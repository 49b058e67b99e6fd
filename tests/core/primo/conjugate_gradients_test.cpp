#include "core/primo/conjugate_gradients.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/primo/shell_impl.hpp"
#include "shells.hpp"

/// Systems with several right-hand sides end solved, or in words.
namespace strake {
namespace {

class SolveColumns : public testing::Test {
protected:
    TriMesh mesh = strip(1, 0.2, 30, 6);
    PrimoShell::Impl shell{rest_state(mesh, options(mesh)), LinearSolver::direct, 1};
    std::vector<Eigen::Matrix3d> still = rotation_differences(shell.poses);
    Loads none = complete({}, mesh.num_vertices());

    static ShellOptions options(const TriMesh& mesh) {
        ShellOptions options = uniform(mesh, 0.01);
        pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < 0.05; });
        return options;
    }
    void assemble(const Loads& loads) {
        shell.prepare(loads.spring);
        shell.assemble(still, jumps(shell.rest, shell.poses, still), loads, StressTerm::none);
    }
    Eigen::MatrixXd right_sides(int count) const {
        Eigen::MatrixXd B(6 * shell.rest.num_free(), count);
        for (Eigen::Index i = 0; i < B.size(); ++i) B.data()[i] = std::sin(0.7 * static_cast<double>(i));
        return B;
    }
    Eigen::MatrixXd solved_by_own_factor(const Eigen::MatrixXd& B) {
        assemble(none);
        EXPECT_TRUE(shell.factorize());
        return solve_columns(shell, B, 1e-10);
    }
};

/// After so many iterations it used to return whatever it had, without a word.
TEST_F(SolveColumns, APreconditionerThatDoesNotLeadThereIsReplaced) {
    const Eigen::MatrixXd B = right_sides(3), right = solved_by_own_factor(B);
    Loads stiff = none;
    for (int v = 0; v < mesh.num_vertices(); v += 3) stiff.spring[v] = 1e3 * (1 + v % 7);
    assemble(stiff);
    ASSERT_TRUE(shell.factorize());
    assemble(none);
    const Eigen::MatrixXd X = solve_columns(shell, B, 1e-10);
    EXPECT_LT((X - right).norm(), 1e-6 * right.norm());
}

TEST_F(SolveColumns, ARightSideThatIsNotFiniteIsNotSolvedByZero) {
    Eigen::MatrixXd B = right_sides(2);
    B(5, 1) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(solved_by_own_factor(B), SolverError);
    EXPECT_TRUE(solved_by_own_factor(Eigen::MatrixXd::Zero(B.rows(), 2)).isZero(0));
}

/// Of two almost equal stiffnesses one is given, the other kept: nothing is built anew.
TEST_F(SolveColumns, AGoodPreconditionerIsKept) {
    const Eigen::MatrixXd B = right_sides(3), right = solved_by_own_factor(B);
    const double building = shell.seconds.factorization;
    const Eigen::MatrixXd X = solve_columns(shell, 2 * B, 1e-10, right);
    EXPECT_LT((X - 2 * right).norm(), 1e-8 * right.norm());
    EXPECT_EQ(shell.seconds.factorization, building);
}

}  // namespace
}  // namespace strake
