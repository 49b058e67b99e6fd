#include "optimize/check/gradient_check.hpp"

#include "core/error.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/run/stored_design.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cstdint>

namespace strake {
namespace {

/// Entries in [-1, 1) by xorshift, the same on every platform.
class Random {
public:
    explicit Random(unsigned seed) : state_(seed * 0x9E3779B97F4A7C15ull + 0x632BE59BD9B4E019ull) {}
    double operator()() {
        state_ ^= state_ << 13, state_ ^= state_ >> 7, state_ ^= state_ << 17;
        return static_cast<double>(state_ >> 11) * 0x1p-52 - 1;
    }

private:
    std::uint64_t state_;
};

/// Random, every variable with a share of its own size, and of size 1 in the metric.
Eigen::VectorXd unit_vector(const DesignSpace& space, Random& random) {
    Eigen::VectorXd d(space.size());
    for (int j = 0; j < space.size(); ++j) d[j] = random() / std::sqrt(space.metric(j, j));
    return d / std::sqrt(d.dot(space.metric * d));
}

void validate(const GradientCheckOptions& options) {
    if (!(options.away > 0)) throw InvalidInput(text("gradient check: away = ", options.away, " must be > 0"));
    if (options.h.size() < 3)
        throw InvalidInput(text("gradient check: ", options.h.size(), " steps, at least 3 needed"));
    for (const double h : options.h)
        if (!(h > 0)) throw InvalidInput(text("gradient check: step ", h, " must be > 0"));
}

/// Parameters have hard bounds: along d they are left on neither side. What is known only by differences cannot be
/// tested against them.
void fit_own(const DesignSpace& space, const Eigen::VectorXd& x, double h, Eigen::MatrixXd& gradients,
             Eigen::VectorXd& d, std::vector<std::string>& notes) {
    for (int j = space.num_shape(); j < space.size(); ++j) {
        const auto leaves = [&](double step) { return x[j] + step > space.upper[j] || x[j] + step < space.lower[j]; };
        if (leaves(h * d[j])) d[j] = -d[j];
        if (leaves(h * d[j])) d[j] = 0;
        if (!gradients.col(j).hasNaN()) continue;
        notes.push_back(text(space.variables[j].name, ": not tested, a program gives no derivative by it"));
        gradients.col(j).setZero();
        d[j] = 0;
    }
}

/// Where the check begins.
struct Beginning {
    DesignSpace space;
    Eigen::VectorXd x;
};

Beginning begin(ShapeEvaluator& evaluator, const Problem& problem, const std::shared_ptr<const RestFacts>& rest,
                int level) {
    const int finest = static_cast<int>(rest->tree->levels.size()) - 1;
    const int coarsest = coarsest_level(rest->parameters);
    if (level > finest || level < -1 || (level >= 0 && level < coarsest))
        throw InvalidInput(text("gradient check: level ", level, " must be in [", coarsest, ", ", finest, "]"));
    if (problem.start && level >= 0)
        throw InvalidInput(text("gradient check: level ", level,
                                " is not wanted with start_from, whose design has patches of its own"));
    Beginning b;
    if (problem.start) {
        InheritedSpace stored = enter_stored(evaluator, rest, *problem.start);
        b = {std::move(stored.space), std::move(stored.x)};
    } else {
        b.space = design_space(rest, level < 0 ? finest : level);
        b.x = Eigen::VectorXd::Zero(b.space.size());
        evaluator.enter(b.space);
    }
    if (b.space.size() == 0)
        throw InvalidInput("gradient check: no variable of this level moves anything; is all of it fixed?");
    return b;
}

}  // namespace

std::vector<std::string> checked_values(const Problem& problem) {
    std::vector<std::string> names;
    const auto add = [&](const std::string& name) {
        if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    };
    add(problem.objective);
    for (const Constraint& constraint : problem.constraints) add(constraint.quantity);
    for (const std::string& name : problem.fit) add(name);
    if (names.empty())
        throw InvalidInput("gradient check: the case has no objective, no constraints and nothing to fit");
    return names;
}

GradientCheck check_gradients(const Problem& problem, const GradientCheckOptions& options) {
    validate(options);
    const std::vector<std::string> names = checked_values(problem);
    const auto rest = rest_facts(problem);
    ShapeEvaluator evaluator(problem, rest, names);
    const auto [space, start] = begin(evaluator, problem, rest, options.level);
    Random random(options.seed);
    Eigen::VectorXd x = start + options.away * unit_vector(space, random);
    Eigen::VectorXd d = unit_vector(space, random);
    x = x.cwiseMax(space.lower).cwiseMin(space.upper);
    if (options.at_start) x = start;

    GradientCheck check;
    check.level = space.level;
    check.variables = space.size();
    ShapeEvaluation base;
    for (int attempt = 0;; ++attempt, x = 0.5 * (start + x)) {
        base = evaluator.evaluate(x, ++check.evaluations);
        if (base.status == EvaluationStatus::ok) break;
        check.notes.push_back(text("point of size ", std::sqrt(x.dot(space.metric * x)), ": ", base.reason));
        if (base.status == EvaluationStatus::quantity_failed || options.at_start || attempt == 5)
            throw SolverError(text("gradient check: there is no value to begin with: ", base.reason));
    }
    evaluator.differentiate(base);
    if (base.status != EvaluationStatus::ok)
        throw SolverError(text("gradient check: there is no gradient: ", base.reason));
    evaluator.accept();
    fit_own(space, x, options.h.front(), base.gradients, d, check.notes);
    check.size = std::sqrt(x.dot(space.metric * x));

    std::vector<std::vector<double>> values(names.size());
    for (const double h : options.h) {
        const ShapeEvaluation at = evaluator.evaluate(x + h * d, ++check.evaluations);
        if (at.status != EvaluationStatus::ok) check.notes.push_back(text("step ", h, ": ", at.reason));
        for (std::size_t i = 0; i < names.size(); ++i)
            values[i].push_back(at.status == EvaluationStatus::ok ? at.values[evaluator.index_of(names[i])]
                                                                  : std::numeric_limits<double>::quiet_NaN());
    }
    const Eigen::LLT<Eigen::MatrixXd> metric(space.metric);
    for (std::size_t i = 0; i < names.size(); ++i) {
        const Eigen::VectorXd g = base.gradients.row(static_cast<Eigen::Index>(i));
        const double size = std::sqrt(std::max(0.0, g.dot(metric.solve(g)))) / std::sqrt(space.size());
        check.tests.push_back(taylor_test(names[i], base.values[evaluator.index_of(names[i])], g.dot(d), size,
                                          options.h, values[i], options.accept));
    }
    return check;
}

}  // namespace strake
