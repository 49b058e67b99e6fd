#pragma once
#include "optimize/problem/problem.hpp"

#include <cmath>

/// Are the gradients right? The Taylor test of the whole chain from the design variables over the equilibrium to the
/// values: along a direction d the remainder |J(x + h d) - J(x) - h g.d| falls as h squared if g is the gradient, as h
/// if it is not.
///
///     GradientCheck check = check_gradients(problem);
///     for (const TaylorTest& test : check.tests) std::cout << test.name << ": " << test.verdict << "\n";
namespace strake {

struct TaylorStep {
    double h = 0;
    double value = std::numeric_limits<double>::quiet_NaN();  ///< J(x + h d); NaN: the evaluation failed
    double remainder = std::numeric_limits<double>::quiet_NaN();
    double order = std::numeric_limits<double>::quiet_NaN();  ///< from the step before to this one
};

struct TaylorTest {
    std::string name;               ///< of the value
    double value = 0;               ///< J(x)
    double slope = 0;               ///< g.d
    double differences_slope = 0;   ///< the same by the values alone, extrapolated to h = 0
    double uncertainty = 0;         ///< of `differences_slope`
    double order = 0;               ///< largest that two successive intervals both reach; 0 where none
    std::vector<TaylorStep> steps;  ///< by falling h
    bool passed = false;
    std::string verdict;  ///< one sentence: what was seen, and if it fails by which factor the slopes differ
};

/// Judges one functional. Passes when the slope agrees with the differences to 1e-5 or to their own uncertainty,
/// and the remainder falls with order 1.7 or more over two successive intervals, or differs from a straight line by
/// less than 1e-6 of the slope. A value that is constant to round-off, with a gradient that says so, passes.
/// @param size the slope that is to be expected (a norm of the gradient), >= 0: errors below 1e-6 of it do not count.
/// @param h falling, > 0, as many as `values`; NaN where there is none.
/// @param accept in [0, 1): also passes where the slopes differ by no more than this share of `size` or of the larger
/// one, and the differences themselves are certain to half of it: for gradients that are approximate by nature, as
/// those of continuous adjoints. 0: no.
/// @throws InvalidInput on other numbers.
TaylorTest taylor_test(const std::string& name, double value, double slope, double size, const std::vector<double>& h,
                       const std::vector<double>& values, double accept = 0);

struct GradientCheckOptions {
    int level = -1;         ///< of the tree, >= 1; -1: the finest, or with `Problem::start` that design's own patches
    bool at_start = false;  ///< at the start (x = 0, or that design); otherwise at a random point beside it
    unsigned seed = 1;      ///< of point and direction
    double away = 0.3;      ///< size of the random point in the metric of the space (about 1: `max_displacement`), > 0
    double accept = 0;      ///< `taylor_test`'s
    std::vector<double> h{1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};  ///< at least three, falling, > 0; d has size 1
};

struct GradientCheck {
    int level = 0, variables = 0;
    int evaluations = 0;             ///< that it took
    double size = 0;                 ///< of the point in the metric
    std::vector<TaylorTest> tests;   ///< objective, constrained values, fitted values; each once
    std::vector<std::string> notes;  ///< evaluations that failed, and why
    bool passed() const {
        for (const TaylorTest& test : tests)
            if (!test.passed) return false;
        return !tests.empty();
    }
};

/// Names of the values that a check of this problem tests. @throws InvalidInput where there are none.
std::vector<std::string> checked_values(const Problem& problem);

/// The point and the direction are random, drawn from the seed and the same on every platform. A point whose shape is
/// refused is moved half-way to the start, at most five times. Parameters stay within their bounds.
/// Cost: one evaluation with gradients and one without for each h.
/// @throws InvalidInput: bad options, unknown names, no variables, values without sensitivities; SolverError when no
/// shape is reached, with the reason; UnheldPart.
GradientCheck check_gradients(const Problem& problem, const GradientCheckOptions& options = {});

}  // namespace strake
