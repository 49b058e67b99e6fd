#include "core/error.hpp"
#include "optimize/run/run_state.hpp"

#include <bit>
#include <cstdint>

/// A run and its journal: limits, time, and what is compared while the run is replayed.
namespace strake {
namespace {

constexpr const char* why_replay_differs =
    "; the run cannot go on: was it made by another version of Strake or of its libraries, or on another machine?";

bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

}  // namespace

RunLimits RunState::limits() const {
    return journal_ ? journal_->limits_after(result.evaluations)
                    : RunLimits{0, problem.optimize.max_evaluations, problem.optimize.max_seconds};
}

bool RunState::limits_were_raised() const {
    const RunLimits now = limits();
    const auto longer = [](double a, double b) { return (a <= 0 && b > 0) || (b > 0 && a > b); };
    return (now.evaluations > level_limits_.evaluations || longer(now.seconds, level_limits_.seconds)) &&
           evaluations_left() > 0 && seconds_left() > 0;
}

double RunState::elapsed() const {
    if (result.evaluations < replayed_)
        return result.evaluations == 0 ? 0 : journal_->find(result.evaluations)->elapsed;
    return elapsed_before_ + std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

double RunState::seconds_left() const {
    const double limit = limits().seconds;
    return limit > 0 ? limit - elapsed() : std::numeric_limits<double>::infinity();
}

/// Before anything is paid: is this the design that was evaluated then?
void RunState::check_design(const Eigen::VectorXd& x) const {
    const JournalEvaluation* then = journal_ ? journal_->find(result.evaluations) : nullptr;
    if (!then) return;
    if (then->level != space.level || then->x.size() != x.size())
        throw ReplayMismatch(text("replay: evaluation ", then->number, " was on level ", then->level, " with ",
                                  then->x.size(), " variables, now it is on level ", space.level, " with ", x.size(),
                                  why_replay_differs));
    for (Eigen::Index j = 0; j < x.size(); ++j)
        if (!same_bits(x[j], then->x[j])) {
            std::ostringstream now, recorded;
            now.precision(17), recorded.precision(17);
            now << x[j], recorded << then->x[j];
            throw ReplayMismatch(text("replay: evaluation ", then->number, ", variable ",
                                      space.variables[static_cast<std::size_t>(j)].name, ": the design has ", now.str(),
                                      ", recorded is ", recorded.str(), why_replay_differs));
        }
}

/// The evaluation as recorded, compared with what the replay gives.
void RunState::check_values(const JournalEvaluation& then, const EvaluationRecord& record) {
    bool same = then.status == record.status && then.accepted == record.accepted &&
                same_bits(then.objective, record.objective) && then.values.size() == record.values.size();
    for (std::size_t i = 0; same && i < record.values.size(); ++i) same = same_bits(then.values[i], record.values[i]);
    if (!same)
        throw ReplayMismatch(text("replay: evaluation ", record.evaluation, " gives other values than recorded (",
                                  record.status, " ", record.objective, ", recorded ", then.status, " ", then.objective,
                                  ")", why_replay_differs));
}

/// Writes the evaluation to the journal, or compares it with what stands there.
void RunState::keep(const Eigen::VectorXd& x, const ShapeEvaluation& evaluation, EvaluationRecord& record) {
    if (!journal_) return;
    if (const JournalEvaluation* then = journal_->find(record.evaluation)) {
        check_values(*then, record);
        record.is_replayed = true;
        record.seconds = then->seconds;
        if (record.evaluation < replayed_) return;
        elapsed_before_ = then->elapsed;
        begin_ = std::chrono::steady_clock::now();
        return;
    }
    JournalEvaluation row;
    row.number = record.evaluation;
    row.level = record.level;
    row.status = record.status;
    row.reason = record.reason;
    row.x = x;
    row.values = record.values;
    row.parameters = record.parameters;
    row.objective = record.objective;
    row.max_violation = record.max_violation;
    row.max_displacement = record.max_displacement;
    row.accepted = record.accepted;
    row.is_taken_over = record.is_taken_over;
    row.is_final_failure = evaluation.status == EvaluationStatus::quantity_failed && !evaluation.may_go_on;
    row.surface = evaluation.surface;
    row.seconds = record.seconds;
    row.elapsed = elapsed();
    journal_->add(row);
}

}  // namespace strake
