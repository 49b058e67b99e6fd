#include "optimize/run/samples.hpp"

#include "core/error.hpp"
#include "optimize/run/design_table.hpp"
#include "optimize/run/level_program.hpp"
#include "optimize/run/run_verdict.hpp"
#include "optimize/run/sample_designs.hpp"
#include "optimize/run/sample_effects.hpp"

#include <cmath>
#include <map>

namespace strake {
namespace {

using Eigen::VectorXd;

/// One call of a program gives all its values: those of the table would be paid for again, and be ignored.
[[noreturn]] void refuse_some_values(const DesignTable& table, const Quantity& quantity) {
    std::string with, without;
    for (const std::string& name : quantity.names) {
        std::string& list = std::ranges::find(table.values, name) != table.values.end() ? with : without;
        list += (list.empty() ? "" : ", ") + name;
    }
    throw InvalidInput(text(table.name, ": there is a column for ", with, ", and none for ", without,
                            ", which the same program returns; add the columns that are missing, remove them from the "
                            "outputs of the case, or remove all columns of the program to have it called"));
}

/// The problem with the answers of the table in place of the quantities that it has all values of.
Problem answered(Problem problem) {
    problem.optimize.method = Method::cobyla;  // asks for no gradients
    problem.optimize.starts = 1;
    if (!problem.table) return problem;
    for (Quantity& quantity : problem.quantities) {
        std::vector<Eigen::Index> columns;
        for (const std::string& name : quantity.names) {
            const auto& known = problem.table->values;
            const auto at = std::find(known.begin(), known.end(), name);
            if (at != known.end()) columns.push_back(at - known.begin());
        }
        if (columns.empty()) continue;
        if (columns.size() != quantity.names.size()) refuse_some_values(*problem.table, quantity);
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
        state_.evaluator.solve_each_from_datum();
    }

    RunResult run() {
        state_.run([this] {
            begin();
            while (!has_ended_ && goes_on()) evaluate_next();
            conclude();
        });
        state_.result.samples.emplace();
        state_.result.samples->table = std::make_shared<const DesignTable>(table_);
        if (state_.result.status == "sampled") learn(problem_, space(), *state_.result.samples);
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
        if (problem_.table)
            check_table();
        else
            designs_ = std::make_unique<SampleDesigns>(problem_, space(), start_, state_.limits().evaluations,
                                                       state_.events.stop_wanted);
        expect_all();
    }

    void check_table() {
        given_ = with_variables(*problem_.table, table_.variables);
        const bool is_relative =
            std::ranges::any_of(problem_.constraints, [](const Constraint& c) { return c.relative; });
        if (is_relative && (design(0) - start_).lpNorm<Eigen::Infinity>() > 1e-9)
            throw InvalidInput(text(given_.name,
                                    ": a constraint is relative to the start, which must be the first row of the "
                                    "table; add it there, or state the limit as a number"));
        for (int row = 0; row < given_.rows(); ++row) design(row);  // before the first is paid for
    }

    int wanted() const {
        const int limit = state_.limits().evaluations;
        if (problem_.table) return problem_.table->rows();
        return std::min(limit, designs_->count());
    }

    bool goes_on() const { return state_.result.evaluations < wanted() && state_.seconds_left() > 0; }

    /// The design of evaluation number `index` + 1, in x.
    VectorXd design(int index) {
        if (!problem_.table) return spread_design(index);
        const VectorXd x = design_of(space(), given_.designs.row(index));
        const VectorXd inside = x.cwiseMax(space().lower).cwiseMin(space().upper);
        for (Eigen::Index j = 0; j < x.size(); ++j)
            if (std::abs(x[j] - inside[j]) > 1e-9)
                throw InvalidInput(text(
                    given_.name, ": row ", index + 1, ": ", table_.variables[j], " = ", given_.designs(index, j),
                    " is outside of its bounds, ", physical_design(space(), space().lower)[j], " to ",
                    physical_design(space(), space().upper)[j], "; widen the bounds in the case, or remove the row"));
        return inside;
    }

    /// Where programs run in parallel a design is asked for when they begin, and again when its answer is due.
    VectorXd spread_design(int index) {
        const auto known = made_.find(index);
        return known != made_.end() ? known->second : made_.emplace(index, designs_->design(index)).first->second;
    }

    /// As the program of the level asks for it, and as it is evaluated: the same bits.
    VectorXd scaled(int index) { return design(index).cwiseProduct(program_.weight()); }

    /// All that come: programs that may run in parallel take the next whenever one is free.
    void expect_all() {
        state_.evaluator.expect(
            [this](int number) -> std::optional<VectorXd> {
                if (number > wanted()) return std::nullopt;
                return program_.unscaled(scaled(number - 1));
            },
            1);
    }

    VectorXd next_design() {
        try {
            return scaled(state_.result.evaluations);
        } catch (const Interrupted&) {
            state_.interrupt();
        }
    }

    void evaluate_next() {
        const VectorXd y = next_design();
        made_.erase(state_.result.evaluations);
        const Evaluation at = nlp_.evaluate(y);
        if (at.is_fatal)
            return end("evaluation_failed", text("evaluation ", state_.result.evaluations, ": ", at.failure));
        if (state_.result.evaluations == 1 && !at.failure.empty() && !problem_.table)
            return end("failed", text("the start cannot be evaluated: ", at.failure));
        add_row(program_.unscaled(y));
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
        if (designs_ && designs_->levels() > 0) words += text("; ", designs_->levels(), " levels of each variable");
        if (designs_ && state_.limits().evaluations > wanted())
            words += text("; these are all there are of ",
                          problem_.sample == Spread::lhs ? "the Latin hypercube" : "these levels",
                          ": use sobol to be able to go on");
        end("sampled", words);
    }

    const Problem problem_;
    RunState state_;
    LevelProgram program_;
    NonlinearProgram nlp_;
    VectorXd start_;
    std::unique_ptr<SampleDesigns> designs_;  ///< null: those of the table
    std::map<int, VectorXd> made_;            ///< those that were begun and not yet evaluated, by index
    DesignTable table_, given_;               ///< of this run; `problem.table` in the order of the variables
    bool has_ended_ = false;
};

}  // namespace

RunResult sample(const Problem& problem, const RunEvents& events, Journal* journal) {
    return Sampling(problem, events, journal).run();
}

}  // namespace strake
