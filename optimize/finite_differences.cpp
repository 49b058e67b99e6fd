#include "optimize/finite_differences.hpp"

#include "core/error.hpp"
#include "optimize/minimizer.hpp"

namespace strake {
namespace {

using Eigen::VectorXd;

/// Objective and constraints in one vector.
VectorXd values_of(const Sample& s) {
    VectorXd all(1 + s.constraints.size());
    all << s.objective, s.constraints;
    return all;
}

class Slopes {
public:
    Slopes(const NonlinearProgram& p, const VectorXd& x, const Sample& at,
           const std::function<Sample(const VectorXd&)>& evaluate)
        : p_(p), x_(x), here_(values_of(at)), evaluate_(evaluate) {}

    /// d values / d x_j. False: no point next to x has values.
    bool along(Eigen::Index j, VectorXd& slope) const {
        const double h = p_.differences->step;
        const double up = std::min(h, p_.upper[j] - x_[j]), down = std::min(h, x_[j] - p_.lower[j]);
        VectorXd above, below;
        // A step that the bounds have cut to next to nothing would measure noise.
        const bool forward = up >= 0.5 * h || up >= down;
        bool has_above = forward && at(j, up, above);
        bool has_below = false;
        if (p_.differences->central || !has_above) has_below = down >= 0.01 * h && at(j, -down, below);
        if (!has_above && !has_below && !forward && up >= 0.01 * h) has_above = at(j, up, above);
        if (has_above && has_below)
            slope = (above - below) / (up + down);
        else if (has_above)
            slope = (above - here_) / up;
        else if (has_below)
            slope = (here_ - below) / down;
        return has_above || has_below;
    }

private:
    bool at(Eigen::Index j, double step, VectorXd& values) const {
        VectorXd x = x_;
        x[j] = std::clamp(x[j] + step, p_.lower[j], p_.upper[j]);
        const Sample s = evaluate_(x);
        if (!s.failure.empty()) return false;
        values = values_of(s);
        return true;
    }

    const NonlinearProgram& p_;
    const VectorXd& x_;
    VectorXd here_;
    const std::function<Sample(const VectorXd&)>& evaluate_;
};

}  // namespace

NonlinearProgram with_differences(NonlinearProgram program, const Differences& how) {
    const auto rows = static_cast<std::size_t>(program.num_inequalities + program.num_equalities);
    if (!(how.step > 0) || !std::isfinite(how.step)) throw InvalidInput(text("step = ", how.step, " must be > 0"));
    if (!how.rows.empty() && how.rows.size() != rows)
        throw InvalidInput(text("differences for ", how.rows.size(), " rows, but there are ", rows, " constraints"));
    program.differences = how;
    return program;
}

bool differentiate_by_differences(const NonlinearProgram& program, const VectorXd& x, Sample& sample,
                                  const std::function<Sample(const VectorXd&)>& evaluate) {
    const Differences& how = *program.differences;
    const Eigen::Index n = x.size(), rows = sample.constraints.size();
    VectorXd gradient = sample.gradient.size() == n ? sample.gradient : VectorXd::Zero(n);
    Eigen::MatrixXd jacobian = sample.jacobian.rows() == rows && sample.jacobian.cols() == n
                                   ? sample.jacobian
                                   : Eigen::MatrixXd::Zero(rows, n);
    const auto is_wanted = [&](Eigen::Index i, Eigen::Index j) {  // i = -1: the objective
        const bool whole = i < 0 ? how.objective : how.rows.empty() || how.rows[static_cast<std::size_t>(i)];
        return whole || (how.missing && std::isnan(i < 0 ? gradient[j] : jacobian(i, j)));
    };
    const Slopes slopes(program, x, sample, evaluate);
    VectorXd slope = VectorXd::Zero(1 + rows);
    for (Eigen::Index j = 0; j < n; ++j) {
        bool any = false;
        for (Eigen::Index i = -1; i < rows; ++i) any |= is_wanted(i, j);
        if (!any) continue;
        if (program.lower[j] < program.upper[j]) {
            if (!slopes.along(j, slope)) return false;
        } else
            slope.setZero();
        if (is_wanted(-1, j)) gradient[j] = slope[0];
        for (Eigen::Index i = 0; i < rows; ++i)
            if (is_wanted(i, j)) jacobian(i, j) = slope[1 + i];
    }
    sample.gradient = gradient;
    sample.jacobian = jacobian;
    return true;
}

}  // namespace strake
