#include "optimize/run/samples.hpp"

#include "core/error.hpp"
#include "optimize/nlp/surrogate/main_effects.hpp"
#include "optimize/nlp/surrogate/spread.hpp"
#include "optimize/run/design_table.hpp"
#include "optimize/run/level_program.hpp"
#include "optimize/run/run_verdict.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int at_a_time = 256;  ///< designs that are asked for together, whatever runs in parallel
constexpr double ball_dimensions = 3;
constexpr double beyond_limit = 2;  ///< in the metric: from there a design is moved inside the motion limit
constexpr int fewest_for_effects = 10;

/// x with Phi(x) = share, by Newton's method on the normal distribution.
double normal_quantile(double share) {
    double x = 0;
    for (int i = 0; i < 60; ++i) {
        const double off = 0.5 * std::erfc(-x / M_SQRT2) - share;
        const double step = off * std::sqrt(2 * M_PI) * std::exp(0.5 * x * x);
        x -= std::clamp(step, -0.5, 0.5);
        if (std::abs(step) < 1e-14) break;
    }
    return x;
}

/// The problem with the answers of the table in place of the quantities that it has all values of.
Problem answered(Problem problem) {
    problem.optimize.method = Method::model;  // no gradients
    problem.optimize.starts = 1;
    if (!problem.table) return problem;
    for (Quantity& quantity : problem.quantities) {
        std::vector<Eigen::Index> columns;
        for (const std::string& name : quantity.names) {
            const auto& known = problem.table->values;
            const auto at = std::find(known.begin(), known.end(), name);
            if (at != known.end()) columns.push_back(at - known.begin());
        }
        if (columns.size() != quantity.names.size()) continue;
        Quantity read;
        read.names = quantity.names;
        read.has_sensitivities = false;
        read.failing_shortens_step = true;
        read.evaluate = [table = problem.table, columns](const QuantityRequest& request) {
            QuantityResult result;
            const Eigen::Index row = request.evaluation - 1;
            for (const Eigen::Index c : columns) result.values.push_back(table->given(row, c));
            if (std::isfinite(result.values[0])) return result;
            result.values.clear();
            result.failure = Failure{"no_value", text("row ", row + 1, " of the table has no value")};
            return result;
        };
        quantity = std::move(read);
    }
    problem.optimize.max_evaluations = problem.table->rows();
    return problem;
}

class Sampling {
public:
    Sampling(const Problem& problem, const RunEvents& events, Journal* journal)
        : problem_(answered(problem)), state_(problem_, events, {}, journal), program_(state_) {
        if (!problem_.table) state_.evaluator.limit_motion();
    }

    RunResult run() {
        try {
            begin();
            while (!has_ended_ && goes_on()) evaluate_next();
            conclude();
        } catch (const Interrupted&) {
            state_.leave_level();
            conclude_interrupted(state_.result);
        } catch (const Awaited&) {
            state_.leave_level();
            conclude_waiting(state_.result);
        }
        state_.result.samples = SampleSummary{std::make_shared<const DesignTable>(table_), {}, {}, {}, {}};
        if (state_.result.status == "sampled") learn(*state_.result.samples);
        return state_.result;
    }

private:
    const DesignSpace& space() const { return state_.space; }

    void begin() {
        start_ = state_.next_level({});
        if (space().size() == 0)
            throw InvalidInput("nothing to sample: no variable of the first level moves anything; is all of it fixed?");
        table_.variables = variable_names(space());
        table_.values = state_.result.names;
        nlp_ = program_.enter(start_);
        most_ = state_.limits().evaluations;
        if (problem_.table) return check_table();
        const Eigen::Index shape = space().num_shape();
        if (shape > 0) U_ = nlp_.metric.topLeftCorner(shape, shape).llt().matrixU();
    }

    void check_table() {
        given_ = with_variables(*problem_.table, table_.variables);
        const bool is_relative =
            std::ranges::any_of(problem_.constraints, [](const Constraint& c) { return c.relative; });
        if (is_relative && (design(0) - start_).lpNorm<Eigen::Infinity>() > 1e-9)
            throw InvalidInput(
                "a constraint is relative to the start, which must be the first row of the table; add "
                "it there, or state the limit as a number");
    }

    int wanted() const {
        const int limit = state_.limits().evaluations;
        if (problem_.table) return problem_.table->rows();
        return problem_.sample == Spread::lhs ? std::min(limit, most_) : limit;
    }

    bool goes_on() const { return state_.result.evaluations < wanted() && state_.seconds_left() > 0; }

    /// The design of evaluation number `index` + 1, in x.
    VectorXd design(int index) {
        if (problem_.table) {
            const VectorXd x = design_of(space(), given_.designs.row(index));
            const VectorXd inside = x.cwiseMax(space().lower).cwiseMin(space().upper);
            for (Eigen::Index j = 0; j < x.size(); ++j)
                if (std::abs(x[j] - inside[j]) > 1e-9)
                    throw InvalidInput(text("row ", index + 1, " of the table: ", table_.variables[j], " = ",
                                            given_.designs(index, j),
                                            " is outside of its bounds; widen the "
                                            "bounds in the case, or remove the row"));
            return inside;
        }
        return index == 0 ? start_ : spread(index - 1);
    }

    VectorXd spread(int number) {
        const int shape = space().num_shape(), parameters = space().num_parameters();
        const int dimensions = shape + parameters + (shape > 0 ? 1 : 0);
        if (points_.rows() == 0 || number < first_point_ || number >= first_point_ + points_.rows()) {
            first_point_ = problem_.sample == Spread::lhs ? 0 : number;
            points_ = problem_.sample == Spread::lhs
                          ? latin_hypercube(std::max(1, most_ - 1), dimensions, problem_.optimize.seed)
                          : sobol_points(1 + number, at_a_time, dimensions);
        }
        const VectorXd share = points_.row(number - first_point_);
        VectorXd x = start_;
        for (int j = shape; j < shape + parameters; ++j)
            x[j] = space().lower[j] + share[j] * (space().upper[j] - space().lower[j]);
        if (shape > 0) x.head(shape) = spread_shape(x, share.head(shape), share[dimensions - 1]).head(shape);
        return x;
    }

    VectorXd spread_shape(const VectorXd& about, const VectorXd& share, double radius) {
        const Eigen::Index shape = share.size();
        const double dimensions = std::min(ball_dimensions, static_cast<double>(shape));
        const bool is_limited = nlp_.within && !state_.evaluator.motion_limit().is_none();
        VectorXd z = share.unaryExpr(&normal_quantile);
        if (!(z.norm() > 0)) z = VectorXd::Unit(shape, 0);
        VectorXd y = about.cwiseProduct(program_.weight());
        const VectorXd centre = y.head(shape);
        const VectorXd direction = U_.triangularView<Eigen::Upper>().solve(z / z.norm());
        y.head(shape) += (is_limited ? beyond_limit : 1) * direction;
        y = y.cwiseMax(nlp_.lower).cwiseMin(nlp_.upper);
        if (is_limited) y = nlp_.within(y);
        y.head(shape) = centre + std::pow(radius, 1 / dimensions) * (y.head(shape) - centre);
        return y.cwiseQuotient(program_.weight());
    }

    /// The next designs, asked for together.
    void evaluate_next() {
        std::vector<VectorXd> designs;
        const int first = state_.result.evaluations;
        for (int i = first; i < std::min(wanted(), first + at_a_time); ++i)
            designs.push_back(design(i).cwiseProduct(program_.weight()));
        nlp_.expect(designs);
        for (const VectorXd& y : designs) {
            if (!goes_on()) return;
            const Evaluation at = nlp_.evaluate(y);
            if (at.is_fatal)
                return end("evaluation_failed", text("evaluation ", state_.result.evaluations, ": ", at.failure));
            if (state_.result.evaluations == 1 && !at.failure.empty() && !problem_.table)
                return end("failed", text("the start cannot be evaluated: ", at.failure));
            add_row(program_.unscaled(y));
        }
    }

    void add_row(const VectorXd& x) {
        const Eigen::Index row = table_.rows();
        const ShapeEvaluation& last = program_.current();
        table_.status.push_back(to_string(last.status));
        table_.designs.conservativeResize(row + 1, space().size());
        table_.designs.row(row) = physical_design(space(), x);
        table_.given.conservativeResize(row + 1, static_cast<Eigen::Index>(table_.values.size()));
        table_.given.row(row).setConstant(std::numeric_limits<double>::quiet_NaN());
        for (std::size_t i = 0; i < last.values.size(); ++i)
            table_.given(row, static_cast<Eigen::Index>(i)) = last.values[i];
    }

    void end(const char* status, const std::string& reason) {
        state_.result.status = status;
        state_.result.reason = reason;
        has_ended_ = true;
        state_.end_level(reason);
    }

    void conclude() {
        if (has_ended_) return;
        const auto failed = std::ranges::count_if(table_.status, [](const std::string& s) { return s != "ok"; });
        if (failed == table_.rows()) return end("failed", "no design has a value");
        const int left = wanted() - state_.result.evaluations;
        std::string words = text(table_.rows(), " designs, ", failed, " of them without a value");
        if (state_.run_best.feasible)
            words += text("; the best feasible one is evaluation ", state_.result.best_evaluation);
        else if (!problem_.constraints.empty())
            words += "; none meets all constraints";
        if (left > 0) return end("budget", text(words, "; the time limit is reached, ", left, " designs are left"));
        if (state_.limits().evaluations > wanted() && !problem_.table)
            words += text("; a Latin hypercube is made for the number of designs that it began with (", wanted(),
                          "): use sobol to be able to go on");
        end("sampled", words);
    }

    void learn(SampleSummary& samples) const {
        const MatrixXd& designs = table_.designs;
        const Eigen::Index d = designs.cols();
        std::vector<Eigen::Index> ok;
        for (int i = 0; i < table_.rows(); ++i)
            if (table_.status[static_cast<std::size_t>(i)] == "ok") ok.push_back(i);
        const MatrixXd points = designs(ok, Eigen::all);
        VectorXd lower(d), upper(d);
        for (Eigen::Index j = 0; j < d; ++j) {
            const Variable& variable = space().variables[static_cast<std::size_t>(j)];
            const double centre = points.col(j).mean();
            const double reach = std::sqrt(3 * (points.col(j).array() - centre).square().mean());
            const bool is_parameter = j >= space().num_shape() && !problem_.table;
            lower[j] = is_parameter ? variable.offset + space().lower[j] * variable.unit : centre - reach;
            upper[j] = is_parameter ? variable.offset + space().upper[j] * variable.unit : centre + reach;
        }
        samples.lower.assign(lower.begin(), lower.end());
        samples.upper.assign(upper.begin(), upper.end());
        if (static_cast<int>(ok.size()) < fewest_for_effects) {
            samples.without_effects = text("main effects need at least ", fewest_for_effects, " designs with values, ",
                                           ok.size(), " have them; sample more");
            return;
        }
        if (!(lower.array() < upper.array()).all()) {
            Eigen::Index same = 0;
            (upper - lower).minCoeff(&same);
            samples.without_effects =
                text("main effects need designs that differ in every variable; all have the same ",
                     table_.variables[static_cast<std::size_t>(same)]);
            return;
        }
        const VectorXd range = upper - lower;
        const MatrixXd scaled = (points.rowwise() - lower.transpose()) * range.cwiseInverse().asDiagonal();
        for (std::size_t k = 0; k < table_.values.size(); ++k) {
            const VectorXd values = table_.given.col(static_cast<Eigen::Index>(k))(ok);
            const GaussianProcess model(scaled, values);
            const MainEffects effects = main_effects(model, VectorXd::Zero(d), VectorXd::Ones(d));
            samples.values.push_back({table_.values[k],
                                      effects.deviation,
                                      model.predicted_share(),
                                      {effects.share.begin(), effects.share.end()},
                                      {effects.error.begin(), effects.error.end()}});
        }
    }

    const Problem problem_;
    RunState state_;
    LevelProgram program_;
    NonlinearProgram nlp_;
    VectorXd start_;
    MatrixXd U_;       ///< of the metric of the shape variables, in y
    MatrixXd points_;  ///< in the unit cube, from `first_point_` on
    int first_point_ = 0;
    int most_ = 0;               ///< evaluations that the run began with
    DesignTable table_, given_;  ///< of this run; `problem.table` in the order of the variables
    bool has_ended_ = false;
};

}  // namespace

RunResult sample(const Problem& problem, const RunEvents& events, Journal* journal) {
    return Sampling(problem, events, journal).run();
}

}  // namespace strake
