#include "optimize/nlp/program/finite_differences.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"

namespace strake {
namespace {

using Eigen::VectorXd;

/// A point on one side of x along a variable; no values: not evaluated, or it failed.
struct Side {
    Eigen::Index variable;
    double step;
    VectorXd values = {};
};

/// All points of a gradient: first one side of each wanted variable, then the other sides of those that failed.
class Slopes {
public:
    Slopes(const NonlinearProgram& p, const VectorXd& x, const Evaluation& at,
           const std::function<Evaluation(const VectorXd&)>& evaluate,
           const std::function<void(const std::vector<VectorXd>&)>& expect)
        : p_(p), x_(x), here_(values_of(at)), evaluate_(evaluate), expect_(expect) {}

    void want(Eigen::Index j) {
        const auto [up, down, forward] = steps(j);
        const bool fits_below = down >= min_step(), fits_above = up >= min_step();
        if (forward) sides_.push_back({j, up});
        if ((!forward || p_.differences->central) && fits_below) sides_.push_back({j, -down});
        if (!forward && !fits_below && fits_above) sides_.push_back({j, up});
    }

    void evaluate() {
        evaluate_from(0);
        const std::size_t first = sides_.size();
        for (std::size_t k = 0; k < first; ++k) {
            const Eigen::Index j = sides_[k].variable;
            const auto [up, down, forward] = steps(j);
            const bool has_other = std::any_of(sides_.begin(), sides_.end(), [&](const Side& s) {
                return s.variable == j && (s.values.size() > 0 || s.step != sides_[k].step);
            });
            if (has_other) continue;
            if (forward && down >= min_step()) sides_.push_back({j, -down});
            if (!forward && sides_[k].step < 0 && up >= min_step()) sides_.push_back({j, up});
        }
        evaluate_from(first);
    }

    /// d values / d x_j. False: no point next to x has values.
    bool along(Eigen::Index j, VectorXd& slope) const {
        const Side *above = nullptr, *below = nullptr;
        for (const Side& side : sides_)
            if (side.variable == j && side.values.size() > 0) (side.step > 0 ? above : below) = &side;
        if (above && below)
            slope = (above->values - below->values) / (above->step - below->step);
        else if (above)
            slope = (above->values - here_) / above->step;
        else if (below)
            slope = (here_ - below->values) / -below->step;
        return above || below;
    }

private:
    struct Steps {
        double up, down;
        bool forward;
    };
    /// A step that the bounds have cut to less would measure noise.
    double min_step() const { return 0.01 * p_.differences->step; }
    Steps steps(Eigen::Index j) const {
        const double h = p_.differences->step;
        const double up = std::min(h, p_.upper[j] - x_[j]), down = std::min(h, x_[j] - p_.lower[j]);
        return {up, down, up >= 0.5 * h || up >= down};
    }

    VectorXd point(const Side& side) const {
        VectorXd x = x_;
        double& entry = x[side.variable];
        entry = std::clamp(entry + side.step, p_.lower[side.variable], p_.upper[side.variable]);
        return x;
    }

    void evaluate_from(std::size_t first) {
        if (first == sides_.size()) return;
        std::vector<VectorXd> points;
        for (std::size_t k = first; k < sides_.size(); ++k) points.push_back(point(sides_[k]));
        if (expect_) expect_(points);
        for (std::size_t k = first; k < sides_.size(); ++k) {
            const Evaluation s = evaluate_(points[k - first]);
            if (s.failure.empty()) sides_[k].values = values_of(s);
        }
    }

    const NonlinearProgram& p_;
    const VectorXd& x_;
    VectorXd here_;
    const std::function<Evaluation(const VectorXd&)>& evaluate_;
    const std::function<void(const std::vector<VectorXd>&)>& expect_;
    std::vector<Side> sides_;
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

bool differentiate_by_differences(const NonlinearProgram& program, const VectorXd& x, Evaluation& evaluation,
                                  const std::function<Evaluation(const VectorXd&)>& evaluate,
                                  const std::function<void(const std::vector<VectorXd>&)>& expect) {
    const Differences& how = *program.differences;
    const Eigen::Index n = x.size(), rows = evaluation.constraints.size();
    VectorXd gradient = evaluation.gradient.size() == n ? evaluation.gradient : VectorXd::Zero(n);
    Eigen::MatrixXd jacobian = evaluation.jacobian.rows() == rows && evaluation.jacobian.cols() == n
                                   ? evaluation.jacobian
                                   : Eigen::MatrixXd::Zero(rows, n);
    const auto is_wanted = [&](Eigen::Index i, Eigen::Index j) {  // i = -1: the objective
        const bool whole = i < 0 ? how.objective : how.rows.empty() || how.rows[static_cast<std::size_t>(i)];
        return whole || (how.missing && std::isnan(i < 0 ? gradient[j] : jacobian(i, j)));
    };
    const auto any_wanted = [&](Eigen::Index j) {
        bool any = false;
        for (Eigen::Index i = -1; i < rows; ++i) any |= is_wanted(i, j);
        return any;
    };
    std::vector<Eigen::Index> wanted;
    Slopes slopes(program, x, evaluation, evaluate, expect);
    for (Eigen::Index j = 0; j < n; ++j) {
        if (!any_wanted(j)) continue;
        wanted.push_back(j);
        if (program.lower[j] < program.upper[j]) slopes.want(j);
    }
    slopes.evaluate();
    for (const Eigen::Index j : wanted) {
        VectorXd slope = VectorXd::Zero(1 + rows);
        if (program.lower[j] < program.upper[j] && !slopes.along(j, slope)) return false;
        if (is_wanted(-1, j)) gradient[j] = slope[0];
        for (Eigen::Index i = 0; i < rows; ++i)
            if (is_wanted(i, j)) jacobian(i, j) = slope[1 + i];
    }
    evaluation.gradient = gradient;
    evaluation.jacobian = jacobian;
    return true;
}

}  // namespace strake
