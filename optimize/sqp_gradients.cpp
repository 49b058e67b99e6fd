#include "optimize/sqp_search.hpp"

#include <algorithm>

/// Gradients by differences below the first level: what the level above, the model and the values tell is not paid.
namespace strake {

using Eigen::VectorXd;

namespace {

constexpr int dear_gradient = 6;     ///< differences: from so many variables on
constexpr double most_change = 4;    ///< of the gradient over a step, as a multiple of what the model expects
constexpr double paid_share = 0.9;   ///< of the doubt
constexpr double most_of_all = 0.3;  ///< directions that may hold it; spread over more, the gradient is paid whole

}  // namespace

bool SqpSearch::is_dear() const { return p_.differences && p_.differences->objective && x_.size() >= dear_gradient; }

GradientGuess SqpSearch::guess(const Sample& trial, const VectorXd& d) const {
    const VectorXd lambda = multipliers(p_, x_, at_), Bd = B_ * d, Md = doubt_.metric() * d;
    const VectorXd slope = at_.gradient + at_.jacobian.transpose() * lambda;
    const VectorXd rise = trial.constraints - at_.constraints;
    // The values at both ends tell how much the slope along d has changed, if it changed evenly.
    const double bent = 2 * (trial.objective - at_.objective + lambda.dot(rise) - slope.dot(d));
    constexpr double tiny = std::numeric_limits<double>::min();
    const double times = std::clamp(bent / std::max(d.dot(Bd), tiny), 0.0, most_change);
    GradientGuess g;
    g.metric = doubt_.metric();
    g.jacobian = at_.jacobian + 2 * (rise - at_.jacobian * d) * Md.transpose() / std::max(d.dot(Md), tiny);
    g.gradient = at_.gradient + times * Bd - (g.jacobian - at_.jacobian).transpose() * lambda;
    return g;
}

bool SqpSearch::differentiate(const VectorXd& x, Sample& trial) {
    if (!p_.start_gradient || !is_dear() || p_.differences->central) return evaluate(x, true, trial);
    GradientGuess g = guess(trial, x - x_);
    GradientDoubt doubt = doubt_;
    doubt.moved(B_ * (x - x_));
    std::vector<int> wanted = doubt.most_doubtful(paid_share);
    if (static_cast<double>(wanted.size()) > most_of_all * static_cast<double>(x.size()))
        wanted = doubt.most_doubtful(1);
    doubt.paid(wanted);
    g.directions = doubt.directions(wanted);
    g.is_complete = doubt.is_certain();
    if (!guard_.try_with(x, g, trial)) return false;
    if (!trial.is_partly_guessed) doubt.paid_all();
    doubt_ = doubt;
    return true;
}

bool SqpSearch::pay_doubt() {
    if (doubt_.is_certain()) return false;
    const std::vector<int> wanted = doubt_.most_doubtful(1);
    const GradientGuess g{at_.gradient, at_.jacobian, doubt_.directions(wanted), doubt_.metric(), true};
    Sample sample = at_;
    if (!guard_.try_refined(x_, g, sample)) {
        if (guard_.cause == Cause::failure) guard_.cause = Cause::none;  // the search goes on with what it knows
        return false;
    }
    at_ = sample;
    doubt_.paid_all();
    raise_penalty(1.5 * multipliers(p_, x_, at_).lpNorm<Eigen::Infinity>());
    look_at_border();
    return true;
}

bool SqpSearch::ends_here() {
    if (doubt_.is_certain()) return true;
    if (pay_doubt()) return false;
    return guard_.cause == Cause::none || ended_by_guard();
}

}  // namespace strake
