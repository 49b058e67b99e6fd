#include "optimize/sqp_search.hpp"

#include "core/error.hpp"

#include <cmath>
#include <vector>

namespace strake {

using Eigen::VectorXd;

namespace {

/// In standard deviations. Less than 0, a step that would gain most is more likely to fail than not, and tells little.
const std::vector<double> surenesses = {0, 0.5, 1}, of_many = {0.3};
constexpr int many = 20;                 ///< variables: their models cost more than what a choice among several gains
constexpr int most_rounds = 3;           ///< of a step under a cut that is linear about the step before
constexpr double settled = 0.05;         ///< of the sureness
constexpr double shares[] = {0.6, 0.2};  ///< of the step that there would be without the border

}  // namespace

double SqpSearch::promised(const VectorXd& d) const {
    const double relief = total_violation(p_, tightened(at_.constraints)) -
                          total_violation(p_, tightened(at_.constraints + at_.jacobian * d));
    return -(at_.gradient.dot(d) + 0.5 * d.dot(B_ * d)) + guard_.penalty * std::max(relief, 0.0);
}

void SqpSearch::look_at_border() {
    cut_.reset();
    expected_ = 0;
    const std::optional<BorderBelief> belief = guard_.border.belief(x_, p_.metric);
    if (!belief) return;
    VectorXd d = model_step(at_.constraints);
    if (d.size() == 0) d = VectorXd::Zero(x_.size());
    std::optional<FailureCut> best;
    for (const double sureness : x_.size() > many ? of_many : surenesses) {
        VectorXd about = d;
        for (int round = 0; round < most_rounds; ++round) {
            cut_ = belief->cut(x_ + about, sureness);
            const VectorXd next = solve_model(model(at_.constraints, damping_));
            if (next.size() == 0) break;
            d = next;
            if (std::abs(belief->sureness(x_ + d) - sureness) < settled) break;
            about += 0.5 * (d - about);
        }
        const double probability = 0.5 * std::erfc(-belief->sureness(x_ + d) / M_SQRT2);
        const double expected = promised(d) * probability;
        if (!best || expected > expected_) best = cut_, expected_ = expected;
    }
    cut_ = best;
}

bool SqpSearch::end_at_border() {
    // What failed there may have been bad luck.
    const QuadraticModel without_cut = model(at_.constraints, 0, std::nullopt);
    if (const VectorXd free = solve_model(without_cut); free.size() > 0)
        for (const double share : shares) {
            const VectorXd d = share * std::min(1.0, radius_ / metric_norm(p_, free)) * free;
            Sample trial;
            if (evaluate(x_ + d, false, trial)) {
                const double decrease = merit(at_) - merit(trial);
                if (decrease > 0) return accept(x_ + d, trial, decrease, held(without_cut, free));
                continue;
            }
            if (guard_.cause != Cause::failure) return ended_by_guard();
            guard_.cause = Cause::none;
        }
    end_.is_at_border = true;
    return end(MinimizeStop::blocked,
               text("evaluations fail beyond a border next to the best point, up to which nothing is left to gain (",
                    guard_.failures, " of ", guard_.evaluations, " failed); the last failure: ", guard_.failure));
}

bool SqpSearch::is_cut_off(const VectorXd& d) const {
    if (!cut_) return false;
    const VectorXd free = solve_model(model(at_.constraints, 0, std::nullopt));
    return free.size() == 0 || (free - d).lpNorm<Eigen::Infinity>() > guard_.options.step_tolerance;
}

}  // namespace strake
