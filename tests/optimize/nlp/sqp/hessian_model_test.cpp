#include "optimize/nlp/sqp/hessian_model.hpp"

#include "programs.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

using namespace strake;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

double min_eigenvalue(const MatrixXd& m) { return Eigen::SelfAdjointEigenSolver<MatrixXd>(m).eigenvalues()[0]; }

}  // namespace

/// A guessed curvature of 1000 along one direction: a model that has started anew, of curvature 1, does not hold it.
TEST(HessianModel, WhatItHasNotGotIsNotTakenAway) {
    NonlinearProgram program = bowl().program;
    program.guessed = MatrixXd::Zero(3, 3);
    program.guessed(0, 0) = 1000;
    program.hessian = MatrixXd::Identity(3, 3) + program.guessed;
    const MinimizeOptions options;
    Guard guard(program, options);
    Evaluation evaluation;
    ASSERT_TRUE(guard.try_at(program.start, true, evaluation));
    const SqpIterate now(guard);
    HessianModel model(now, 0);
    model.start();
    const MatrixXd fresh = model.matrix();
    model.remove_guess(0.5);
    EXPECT_EQ(model.matrix(), fresh);
    model.start_from(program.hessian);
    model.remove_guess(0.5);
    EXPECT_EQ(model.matrix(), MatrixXd(program.hessian - 0.5 * program.guessed));
    model.start();
    model.remove_guess(1);
    EXPECT_GT(min_eigenvalue(model.matrix()), 0);
}

/// Steps along negative curvature while the gradient turns across them, as next to buckling: damping alone adds
/// curvature without limit across the steps, until the model is singular to rounding and no step can be computed.
TEST(HessianModel, StaysSolvableAlongNegativeCurvature) {
    const NonlinearProgram program = bowl().program;
    const MinimizeOptions options;
    Guard guard(program, options);
    Evaluation evaluation;
    ASSERT_TRUE(guard.try_at(program.start, true, evaluation));
    const SqpIterate now(guard);
    HessianModel model(now, 0);
    model.start();
    for (int i = 0; i < 12; ++i) {
        const VectorXd s = VectorXd::Unit(3, i % 2) + 0.1 * VectorXd::Unit(3, 2);
        const VectorXd Bs = model.matrix() * s;
        VectorXd across = VectorXd::Unit(3, 2) - 0.1 * VectorXd::Unit(3, i % 2);  // s.across = 0
        model.update(s, -0.1 * Bs + 300 * Bs.norm() * across);
        const VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<MatrixXd>(model.matrix()).eigenvalues();
        ASSERT_GT(eigenvalues[0], 1e-6 * eigenvalues[2]) << "update " << i;
    }
}

/// Undamped updates are BFGS's: the model has the curvature that was measured, however large.
TEST(HessianModel, LearnsALargeCurvatureAtOnce) {
    const NonlinearProgram program = bowl().program;
    const MinimizeOptions options;
    Guard guard(program, options);
    Evaluation evaluation;
    ASSERT_TRUE(guard.try_at(program.start, true, evaluation));
    const SqpIterate now(guard);
    HessianModel model(now, 0);
    model.start();
    const VectorXd s = VectorXd::Unit(3, 0), y = 1e4 * s;
    model.update(s, y);
    EXPECT_LE((model.matrix() * s - y).norm(), 1e-9 * y.norm());
}
