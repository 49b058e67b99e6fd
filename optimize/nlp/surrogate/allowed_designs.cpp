#include "optimize/nlp/surrogate/allowed_designs.hpp"

#include "optimize/nlp/model/quadratic_model.hpp"
#include "optimize/nlp/surrogate/local_models.hpp"

#include <limits>

namespace strake {

using Eigen::VectorXd;

namespace {

constexpr int max_projections = 8, max_turns = 5;
constexpr double way_kept = 0.6;  ///< of a step to where there is no shape
constexpr int max_cuts = 8, max_ways_back = 12;
constexpr double same_directions = 1e-9;

}  // namespace

bool AllowedDesigns::look_from(const VectorXd& x) {
    if (here_ && from_ == x) return false;
    from_ = x;
    here_ = known_.at(x, true);
    return true;
}

double AllowedDesigns::missed(const VectorXd& x) const {
    const auto found = known_.at(x, false);
    return found ? known_.violation(*found) : std::numeric_limits<double>::infinity();
}

bool AllowedDesigns::limit_step_to(const VectorXd& x, StepLimits& limits) {
    const StepLimits more = guard_.beyond(from_, x);
    if (guard_.cause != StopCause::none || more.values.size() == 0) return false;
    append(limits, more);
    return true;
}

AllowedDesigns::Shape AllowedDesigns::with_shape(const VectorXd& x) {
    Shape there{guard_.inside(x)};
    if (from_.size() == 0) return there;
    for (int k = 0; k < max_cuts && guard_.cause == StopCause::none && !guard_.is_defined(there.x); ++k) {
        there.x = guard_.inside(from_ + way_kept * (there.x - from_));
        there.is_shortened = true;
    }
    return there;
}

AllowedDesigns::Shape AllowedDesigns::within(const SampledPoints& points, const VectorXd& x) {
    VectorXd asked = points.within_directions(x);
    for (int k = 0;; ++k) {
        Shape there = has_turns() ? Shape{guard_.inside(asked)} : with_shape(asked);
        const VectorXd back = points.within_directions(there.x);
        const bool is_there = (back - there.x).norm() <= same_directions * there.x.norm();
        if (is_there || k == max_ways_back || guard_.cause != StopCause::none) return there;
        asked = back;
    }
}

VectorXd AllowedDesigns::nearest(const VectorXd& asked) {
    const Shape begin = with_shape(asked);
    VectorXd best = begin.x, x = begin.is_shortened ? best : asked;
    double least = missed(best);
    StepLimits limits;
    for (int k = 0; k < max_projections && least > known_.tolerance(); ++k) {
        const bool is_beyond = limit_step_to(x, limits);
        const VectorXd there = guard_.inside(x);
        if (guard_.cause != StopCause::none) break;
        const auto found = known_.at(there, true);
        if (!found || !found->has_slopes()) break;
        const double violation = known_.violation(*found);
        // Where curvature outweighs slopes every step leads farther away.
        if (k > 0 && violation >= least && !is_beyond) break;
        if (violation < least) best = there, least = violation;
        // Later from there: from far away slopes alone never end (a circle from more than its radius).
        x = known_.nearest_by_slopes(k == 0 ? x : there, *found, from_, limits);
    }
    return best;
}

VectorXd AllowedDesigns::nearest_by_turns(const VectorXd& asked) {
    VectorXd x = guard_.inside(asked);
    for (int round = 0; round < max_turns && missed(x) > known_.tolerance(); ++round) {
        const auto found = known_.at(x, true);
        if (!found) break;
        const VectorXd next = guard_.inside(known_.nearest(x, *found));
        if (guard_.cause != StopCause::none || missed(next) >= known_.violation(*found)) break;
        x = next;
    }
    return x;
}

}  // namespace strake
