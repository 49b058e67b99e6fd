#include "optimize/run/wave_watch.hpp"

#include "core/error.hpp"
#include "optimize/nlp/multistart.hpp"
#include "optimize/run/method_choice.hpp"

#include <algorithm>

namespace strake {
namespace {

using Eigen::VectorXd;

/// `parabola_misfit` of a step across waves. On each of fifteen rippled wings a step was above within the first eight,
/// on seventeen smooth problems none, but for single ones of an objective with kinks (frontal area), or where
/// constraints change places.
constexpr double wavy_misfit = 0.2;
/// Of their units, by which fields are changed for another start: the valley is the same, and a body stays valid.
constexpr double reach_of_another_start = 0.3;
constexpr int max_halvings = 8;

bool is_better(const MinimizeResult& a, const MinimizeResult& b) {
    if (!std::isfinite(a.best.objective)) return false;
    if (!std::isfinite(b.best.objective)) return true;
    if (a.is_feasible != b.is_feasible) return a.is_feasible;
    return a.is_feasible ? a.best.objective < b.best.objective : a.violation < b.violation;
}

}  // namespace

WaveWatch::WaveWatch(RunState& state, LevelProgram& program)
    : state_(state), program_(program), is_on_(looks_for_waves(state.problem)) {}

void WaveWatch::enter_level() {
    is_patient_ = goes_back_;
    goes_back_ = sees_waves_ = false;
}

bool WaveWatch::may_go_back() const {
    return !has_gone_back_ && state_.result.levels.size() > 1 && !state_.space.has_patches &&
           state_.evaluations_left() >= state_.result.evaluations;
}

std::function<bool(double)> WaveWatch::on_misfit() {
    if (!is_on_) return {};
    return [this](double misfit) {
        if (misfit <= wavy_misfit) return true;
        sees_waves_ = true;
        is_patient_ |= state_.result.levels.size() == 1;
        return is_patient_ || !may_go_back();
    };
}

void WaveWatch::go_back() {
    goes_back_ = has_gone_back_ = true;
    state_.note(text("level ", state_.space.level,
                     ": values go up and down along its steps, as of an objective with many minima; the first fields "
                     "are searched from the start, before others join again"));
}

std::optional<VectorXd> WaveWatch::another_start(const NonlinearProgram& program, unsigned seed) const {
    NonlinearProgram around = program;
    VectorXd reach = VectorXd::Zero(program.start.size());
    for (int j = 0; j < state_.space.size(); ++j)
        if (state_.space.variables[j].kind == VariableKind::field)
            reach[j] = reach_of_another_start * program_.weight()[j];
    around.lower_of_starts = program.lower.cwiseMax(program.start - reach);
    around.upper_of_starts = program.upper.cwiseMin(program.start + reach);
    VectorXd change = random_start(around, seed, 1) - program.start;
    for (int k = 0; k <= max_halvings; ++k, change *= 0.5) {
        const VectorXd wanted = program.start + change;
        const VectorXd there = program.within ? program.within(wanted) : wanted;
        if (there != program.start && (!program.refusal || program.refusal(there).empty())) return there;
    }
    return {};
}

MinimizeResult WaveWatch::look_elsewhere(const NonlinearProgram& program, MinimizeOptions how,
                                         const MinimizeResult& first) {
    const bool may = first.stop != MinimizeStop::failed && !first.gradient_inconsistent &&
                     state_.evaluations_left() > 0 && state_.seconds_left() > 0;
    if (!is_patient_ || !sees_waves_ || !may) return first;
    const std::optional<VectorXd> start = another_start(program, how.seed);
    if (!start) return first;
    NonlinearProgram other = program;
    other.start = *start;
    other.hessian.resize(0, 0);
    how.max_evaluations = std::clamp(first.evaluations, 1, state_.evaluations_left());
    if (how.max_seconds > 0) how.max_seconds = state_.seconds_left();
    MinimizeResult second = minimize(other, how);
    state_.note(text("level ", state_.space.level, ": objective ", first.best.objective, " after ", first.evaluations,
                     " evaluations, ", second.best.objective, " from another start after ", second.evaluations));
    const bool is_second = is_better(second, first);
    MinimizeResult best = is_second ? second : first;
    best.evaluations = first.evaluations + second.evaluations;
    best.failures = first.failures + second.failures;
    best.shrinks = first.shrinks + second.shrinks;
    best.confirmations = first.confirmations + second.confirmations;
    if (program_.quantity_failed()) best.stop = MinimizeStop::failed, best.reason = second.reason;
    return best;
}

}  // namespace strake
