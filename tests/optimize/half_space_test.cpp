#include "programs.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

/// Evaluations fail beyond a plane, as flow solvers do beyond some thickness: what can be reached is reached, at a
/// bounded price, and the verdict says what happened.
namespace strake {
namespace {

struct HalfSpace {
    NonlinearProgram clean, failing;
    double start = 0, attainable = 0;  ///< objective at the start, and the least on the side that does not fail
};

/// A quadratic of 2 to 6 variables whose optimum lies at `beyond` times the way from the start to the border of
/// failure.
HalfSpace half_space(int n, double beyond, unsigned seed) {
    std::srand(seed);
    const Eigen::MatrixXd A = Eigen::MatrixXd::Random(n, n);
    const Eigen::MatrixXd H = A.transpose() * A + 0.5 * Eigen::MatrixXd::Identity(n, n);
    const Eigen::VectorXd at = 0.5 * Eigen::VectorXd::Random(n);
    const Eigen::VectorXd start = -0.6 * at.normalized();
    const Eigen::VectorXd normal = (at - start).normalized() + 0.3 * Eigen::VectorXd::Random(n).normalized();
    const double border = normal.dot(start) + normal.dot(at - start) / beyond;
    HalfSpace h;
    h.clean = program_of(
        start, Eigen::VectorXd::Constant(n, -1.5), Eigen::VectorXd::Constant(n, 1.5), 0, 0,
        [=](const Eigen::VectorXd& x) { return vec({1 + 0.5 * (x - at).dot(H * (x - at))}); },
        [=](const Eigen::VectorXd& x) { return Eigen::MatrixXd((H * (x - at)).transpose()); });
    h.failing = h.clean;
    h.failing.evaluate = [=, sound = h.clean.evaluate](const Eigen::VectorXd& x) {
        Evaluation s = sound(x);
        if (normal.dot(x) > border) s.failure = "the flow separates";
        return s;
    };
    h.start = h.clean.evaluate(start).objective;
    // The least on the border, by projection in the metric of H.
    const Eigen::VectorXd d = H.llt().solve(normal);
    const double excess = std::max(0.0, normal.dot(at) - border);
    h.attainable = 1 + 0.5 * excess * excess / normal.dot(d);
    return h;
}

class FailingHalfSpace : public testing::TestWithParam<Method> {};

TEST_P(FailingHalfSpace, WhatCanBeReachedIsReachedWithinFiveTimesTheEvaluations) {
    const Method method = GetParam();
    const char* more = std::getenv("STRAKE_SEEDS");
    const unsigned seeds = more ? static_cast<unsigned>(std::atoi(more)) : method == Method::crs2 ? 6 : 18;
    // Within 1e-3 of what is attainable (crs2: 1e-2), all of them; with many seeds (STRAKE_SEEDS) one in 300 may stay a
    // little short: where the clean run takes 3 evaluations, 15 hardly tell a plane.
    int short_of_it = 0;
    for (const int n : {2, 4, 6})
        for (const double beyond : {0.7, 1.3, 2.0})
            for (unsigned seed = 1; seed <= seeds; ++seed) {
                SCOPED_TRACE(text(n, " variables, optimum at ", beyond, " of the way to the border, seed ", seed));
                const HalfSpace h = half_space(n, beyond, seed);
                MinimizeOptions o;
                o.method = method;
                o.max_evaluations = method == Method::crs2 ? 2000 : 600;
                const MinimizeResult clean = minimize(h.clean, o);
                o.max_evaluations = 5 * clean.evaluations;
                const MinimizeResult r = minimize(h.failing, o);
                const double share = (h.start - r.best.objective) / (h.start - h.attainable);
                if (std::getenv("STRAKE_TELL"))
                    std::cout << "TELL " << method_facts(method).name << " " << n << " " << beyond << " " << seed
                              << ": " << 1 - share << " after " << r.evaluations << " (" << clean.evaluations << "), "
                              << r.reason << "\n";
                const double wanted = method == Method::crs2 ? 0.99 : 0.999;
                if (share < wanted) ++short_of_it;
                EXPECT_GE(share, seeds > 50 && beyond > 1 ? wanted - 0.007 : wanted)
                    << r.evaluations << " (clean: " << clean.evaluations << "): " << r.reason;
                if (r.failures > 0) {
                    EXPECT_NE(r.reason.find("fail"), std::string::npos) << r.reason;
                }
            }
    EXPECT_LE(short_of_it, static_cast<int>(9 * seeds) / 300);
}

INSTANTIATE_TEST_SUITE_P(Methods, FailingHalfSpace,
                         testing::Values(Method::sqp, Method::mma, Method::lbfgs, Method::cobyla, Method::bobyqa,
                                         Method::crs2),
                         [](const auto& info) { return std::string(method_facts(info.param).name); });

}  // namespace
}  // namespace strake
