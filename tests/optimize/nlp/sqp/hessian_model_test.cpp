#include "optimize/nlp/sqp/hessian_model.hpp"

#include "programs.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

using namespace strake;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

double least_eigenvalue(const MatrixXd& m) { return Eigen::SelfAdjointEigenSolver<MatrixXd>(m).eigenvalues()[0]; }

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
    EXPECT_GT(least_eigenvalue(model.matrix()), 0);
}
