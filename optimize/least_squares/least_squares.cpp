#include "optimize/least_squares/least_squares.hpp"

#include "core/error.hpp"
#include "optimize/least_squares/least_squares_watch.hpp"

namespace strake {
namespace {

/// Everything that Ceres would answer with an abort.
void validate(const LeastSquares& p, const LeastSquaresOptions& o) {
    if (p.start.size() < 1 || p.num_residuals < 1)
        throw InvalidInput(text("least squares: ", p.start.size(), " variables and ", p.num_residuals,
                                " residuals; there must be at least one of each"));
    if (p.lower.size() != p.start.size() || p.upper.size() != p.start.size())
        throw InvalidInput("least squares: start and bounds differ in size");
    for (Eigen::Index j = 0; j < p.start.size(); ++j)
        if (!(p.lower[j] <= p.start[j] && p.start[j] <= p.upper[j]) || !std::isfinite(p.start[j]))
            throw InvalidInput(text("least squares: start ", p.start[j], " of variable ", j, " must lie in [",
                                    p.lower[j], ", ", p.upper[j], "]"));
    if (o.max_iterations < 0 || o.max_failures < 1 || !(o.radius > 0) || !(o.objective_tolerance >= 0) ||
        !(o.step_tolerance >= 0))
        throw InvalidInput(text("least squares: iterations ", o.max_iterations, ", failures ", o.max_failures,
                                ", radius ", o.radius, ", tolerances ", o.objective_tolerance, " and ",
                                o.step_tolerance, "; a limit is below its least value"));
}

LeastSquaresStop stop_of(const LeastSquaresWatch& watch, LeastSquaresEnd end) {
    if (!std::isfinite(watch.best)) return LeastSquaresStop::no_start;
    if (watch.stopped) return LeastSquaresStop::stopped;
    // Steps that were refused often enough are short, which passes for convergence.
    if (watch.failures > 1) return LeastSquaresStop::no_valid_step;
    if (end == LeastSquaresEnd::converged) return LeastSquaresStop::converged;
    if (end == LeastSquaresEnd::limit) return LeastSquaresStop::limit;
    return LeastSquaresStop::no_better_step;
}

}  // namespace

LeastSquaresResult least_squares_by(LeastSquaresEnd (*search)(LeastSquaresWatch&, double&), const LeastSquares& problem,
                                    const LeastSquaresOptions& options) {
    validate(problem, options);
    LeastSquaresWatch watch{problem, options};
    double radius = options.radius;
    const LeastSquaresEnd end = search(watch, radius);
    if (watch.exception) std::rethrow_exception(watch.exception);
    return {watch.best_x, stop_of(watch, end), radius};
}

LeastSquaresResult least_squares(const LeastSquares& problem, const LeastSquaresOptions& options) {
    return least_squares_by(search_least_squares, problem, options);
}

}  // namespace strake
