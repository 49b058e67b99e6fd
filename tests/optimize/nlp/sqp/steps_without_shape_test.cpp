#include "optimize/nlp/minimizer.hpp"

#include "programs.hpp"

#include <gtest/gtest.h>

/// Steps of sqp that lead to no valid shape: what the program can tell without an evaluation costs none.
namespace strake {
namespace {

using Eigen::VectorXd;

/// A bowl whose first steps are far too long; where the variables are farther than 0.4 from each other, nothing has a
/// shape. The minimum, all variables 0.8, has one.
NonlinearProgram bowl(int& failed) {
    const auto has_shape = [](const VectorXd& x) { return x.maxCoeff() - x.minCoeff() <= 0.4; };
    NonlinearProgram p;
    p.start = VectorXd::Zero(5);
    p.lower = VectorXd::Constant(5, -2);
    p.upper = VectorXd::Constant(5, 2);
    p.evaluate = [has_shape, &failed](const VectorXd& x) {
        Evaluation at;
        at.objective = 0;
        for (int i = 0; i < 5; ++i) at.objective += (1 + 4 * i) * std::pow(x[i] - 0.8, 2);
        if (!has_shape(x)) at.failure = "no shape", ++failed;
        return at;
    };
    p.differentiate = [](const VectorXd& x, Evaluation& at) {
        at.gradient.resize(5);
        for (int i = 0; i < 5; ++i) at.gradient[i] = 2 * (1 + 4 * i) * (x[i] - 0.8);
        at.jacobian.resize(0, 5);
    };
    p.refusal = [has_shape](const VectorXd& x) { return std::string(has_shape(x) ? "" : "the variables differ"); };
    return p;
}

TEST(StepsWithoutShape, AreNotEvaluated) {
    int failed = 0;
    const NonlinearProgram p = bowl(failed);
    MinimizeOptions how;
    how.method = Method::sqp;
    how.max_evaluations = 200;
    std::string events;
    how.on_event = [&](const std::string& words) { events += words + '\n'; };
    const MinimizeResult r = minimize(p, how);
    EXPECT_EQ(failed, 0);
    EXPECT_EQ(r.failures, 0);
    const double start = p.evaluate(p.start).objective;
    EXPECT_LT(r.best.objective, 10 * how.objective_tolerance * start) << r.reason;
    EXPECT_NE(events.find("led to no valid shape and were not evaluated"), std::string::npos) << events;
    how.steps_pay_without_shape = true;
    const MinimizeResult before = minimize(p, how);
    EXPECT_GT(failed, 0) << "else this says nothing";
    EXPECT_EQ(before.failures, failed);
    EXPECT_LT(r.evaluations, before.evaluations);
}

/// Nothing but the start has a shape: the search ends, says why, and has paid for the start alone.
TEST(StepsWithoutShape, EndASearchThatHasNoOthers) {
    int failed = 0;
    NonlinearProgram p = bowl(failed);
    p.refusal = [](const VectorXd& x) { return std::string(x.norm() > 0 ? "a triangle is inverted" : ""); };
    MinimizeOptions how;
    how.method = Method::sqp;
    how.max_evaluations = 200;
    const MinimizeResult r = minimize(p, how);
    EXPECT_EQ(r.stop, MinimizeStop::no_valid_step);
    EXPECT_NE(r.reason.find("steps led to no valid shape); the last failure: a triangle is inverted"),
              std::string::npos)
        << r.reason;
    EXPECT_LE(r.evaluations, 3);
}

/// What ends the run while a shape is looked at ends the search, too.
TEST(StepsWithoutShape, AnExceptionReachesTheCaller) {
    int failed = 0;
    NonlinearProgram p = bowl(failed);
    p.refusal = [](const VectorXd&) -> std::string { throw std::runtime_error("interrupted"); };
    MinimizeOptions how;
    how.method = Method::sqp;
    EXPECT_THROW(minimize(p, how), std::runtime_error);
}

}  // namespace
}  // namespace strake
