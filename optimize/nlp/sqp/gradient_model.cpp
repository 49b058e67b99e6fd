#include "optimize/nlp/sqp/gradient_model.hpp"

#include "optimize/nlp/sqp/trust_region.hpp"

#include <algorithm>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

GradientModel::GradientModel(const SqpIterate& now, const HessianModel& hessian) : now_(now), hessian_(hessian) {
    const NonlinearProgram& p = now.program;
    if (p.start_gradient && now.has_expensive_gradient())
        error_ = GradientError(p.metric, now.guard.best_x == p.start ? p.start_gradient->gradient_error : MatrixXd());
}

GradientGuess GradientModel::guess(const Evaluation& trial, const VectorXd& d) const {
    const Evaluation& at = now_.at;
    const VectorXd lambda = multipliers(now_.program, now_.x, at), Bd = hessian_.matrix() * d, Md = error_.metric() * d;
    const VectorXd slope = at.gradient + at.jacobian.transpose() * lambda;
    const VectorXd rise = trial.constraints - at.constraints;
    // The values at both ends give the change of the slope along d, if it changed evenly.
    const double curvature = 2 * (trial.objective - at.objective + lambda.dot(rise) - slope.dot(d));
    constexpr double tiny = std::numeric_limits<double>::min();
    const double times = std::clamp(curvature / std::max(d.dot(Bd), tiny), 0.0, trust_region.max_gradient_change);
    GradientGuess g;
    g.metric = error_.metric();
    g.jacobian = at.jacobian + 2 * (rise - at.jacobian * d) * Md.transpose() / std::max(d.dot(Md), tiny);
    g.gradient = at.gradient + times * Bd - (g.jacobian - at.jacobian).transpose() * lambda;
    return g;
}

bool GradientModel::differentiate(const VectorXd& x, Evaluation& trial) {
    const NonlinearProgram& p = now_.program;
    if (!p.start_gradient || !now_.has_expensive_gradient() || p.differences->central)
        return now_.guard.try_at(x, true, trial);
    GradientGuess g = guess(trial, x - now_.x);
    GradientError error = error_;
    error.add_change(hessian_.matrix() * (x - now_.x));
    std::vector<int> wanted = error.largest(trust_region.paid_share);
    if (static_cast<double>(wanted.size()) > trust_region.max_paid_directions * static_cast<double>(x.size()))
        wanted = error.largest(1);
    error.clear(wanted);
    g.directions = error.directions(wanted);
    g.is_complete = error.is_exact();
    if (!now_.guard.try_with(x, g, trial)) return false;
    if (!trial.is_partly_guessed) error.clear_all();
    error_ = error;
    return true;
}

bool GradientModel::estimate(const VectorXd& x, Evaluation& trial) {
    if (error_.metric().size() == 0) error_ = GradientError(now_.program.metric, MatrixXd());
    const VectorXd d = x - now_.x;
    GradientGuess g = guess(trial, d);
    g.directions = MatrixXd(x.size(), 0);
    error_.add_change(hessian_.matrix() * d);
    return now_.guard.try_with(x, g, trial);
}

bool GradientModel::complete(Evaluation& at) {
    if (error_.is_exact()) return false;
    const std::vector<int> wanted = error_.largest(1);
    const GradientGuess g{at.gradient, at.jacobian, error_.directions(wanted), error_.metric(), true};
    Evaluation evaluation = at;
    if (!now_.guard.try_refined(now_.x, g, evaluation)) {
        // After a failure the search goes on with what it knows.
        if (now_.guard.cause == StopCause::failure) now_.guard.cause = StopCause::none;
        return false;
    }
    at = evaluation;
    error_.clear_all();
    return true;
}

}  // namespace strake
