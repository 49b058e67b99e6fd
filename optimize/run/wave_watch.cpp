#include "optimize/run/wave_watch.hpp"

#include "core/error.hpp"
#include "optimize/nlp/multistart.hpp"
#include "optimize/run/method_choice.hpp"

#include <Eigen/QR>
#include <algorithm>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// `parabola_misfit` of a step across waves. On each of fifteen rippled wings a step was above within the first eight,
/// on seventeen smooth problems none, but for single ones of an objective with kinks (frontal area), or where
/// constraints change places.
constexpr double wavy_misfit = 0.2;
/// Of their units, by which fields are changed for another start: the valley is the same, and a body stays valid.
constexpr double reach_of_another_start = 0.3;
constexpr int max_halvings = 8;
/// Along a line, by which values are off the parabola through them, as a share of their range. Between the start and
/// the best design of a first level: 0.056 to 0.14 on eight rippled wings, below 0.042 on 135 of 136 smooth problems.
constexpr double wavy_share = 0.05;
constexpr int looks_along = 4;       ///< points between start and best: as many as a batch
constexpr int shrinks_by_waves = 2;  ///< of the radius of a search by models: those that go well are not looked at
constexpr int levels_worth = 3;      ///< as many evaluations as the first level has cost must be left

bool is_better(const MinimizeResult& a, const MinimizeResult& b) {
    if (!std::isfinite(a.best.objective)) return false;
    if (!std::isfinite(b.best.objective)) return true;
    if (a.is_feasible != b.is_feasible) return a.is_feasible;
    return a.is_feasible ? a.best.objective < b.best.objective : a.violation < b.violation;
}

MinimizeResult better_of(const MinimizeResult& a, const MinimizeResult& b) {
    MinimizeResult best = is_better(b, a) ? b : a;
    best.evaluations = a.evaluations + b.evaluations;
    best.failures = a.failures + b.failures;
    best.shrinks = a.shrinks + b.shrinks;
    best.confirmations = a.confirmations + b.confirmations;
    return best;
}

}  // namespace

WaveWatch::WaveWatch(RunState& state, LevelProgram& program)
    : state_(state),
      program_(program),
      is_on_(looks_for_waves(state.problem)),
      is_on_by_values_(looks_for_waves_by_values(state.problem)) {}

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

std::optional<VectorXd> WaveWatch::another_start(const NonlinearProgram& program, unsigned seed, int number) const {
    NonlinearProgram around = program;
    VectorXd reach = VectorXd::Zero(program.start.size());
    for (int j = 0; j < state_.space.size(); ++j)
        if (state_.space.variables[j].kind == VariableKind::field)
            reach[j] = reach_of_another_start * program_.weight()[j];
    around.lower_of_starts = program.lower.cwiseMax(program.start - reach);
    around.upper_of_starts = program.upper.cwiseMin(program.start + reach);
    VectorXd change = random_start(around, seed, number) - program.start;
    for (int k = 0; k <= max_halvings; ++k, change *= 0.5) {
        const VectorXd wanted = program.start + change;
        const VectorXd there = program.within ? program.within(wanted) : wanted;
        if (there != program.start && (!program.refusal || program.refusal(there).empty())) return there;
    }
    return {};
}

bool WaveWatch::may_look_along(const MinimizeOptions& how, const MinimizeResult& first) const {
    return is_on_by_values_ && how.method == Method::model && !state_.space.has_patches &&
           first.shrinks >= shrinks_by_waves && may_go_on(first) &&
           state_.evaluations_left() >= levels_worth * state_.result.evaluations;
}

bool WaveWatch::is_wavy_towards(const NonlinearProgram& program, const MinimizeResult& best) {
    constexpr int count = looks_along + 2;
    std::vector<VectorXd> points;
    for (int k = 1; k + 1 < count; ++k) {
        points.push_back(program.within(program.start + k / (count - 1.0) * (best.x - program.start)));
        if (!program.refusal(points.back()).empty()) return false;
    }
    program.expect(points);
    VectorXd values(count);
    values[0] = (state_.problem.maximize ? -1 : 1) * state_.result.levels.back().objective_start;
    values[count - 1] = best.best.objective;
    for (int k = 1; k + 1 < count; ++k) {
        const Evaluation there = program.evaluate(points[static_cast<std::size_t>(k) - 1]);
        if (!there.failure.empty()) {
            failure_ = there.failure;
            return false;
        }
        values[k] = there.objective;
    }
    const VectorXd at = VectorXd::LinSpaced(count, 0, 1);
    MatrixXd powers(count, 3);
    powers << VectorXd::Ones(count), at, at.cwiseAbs2();
    const VectorXd off = values - powers * powers.colPivHouseholderQr().solve(values);
    return off.lpNorm<Eigen::Infinity>() > wavy_share * (values.maxCoeff() - values.minCoeff());
}

MinimizeResult WaveWatch::ended(MinimizeResult result) const {
    result.stop = MinimizeStop::failed;
    result.reason = failure_;
    return result;
}

bool WaveWatch::may_go_on(const MinimizeResult& result) const {
    return result.stop != MinimizeStop::failed && !result.gradient_inconsistent && state_.evaluations_left() > 0 &&
           state_.seconds_left() > 0;
}

MinimizeResult WaveWatch::look_elsewhere(const NonlinearProgram& program, MinimizeOptions how,
                                         const MinimizeResult& first) {
    MinimizeResult best = first;
    if (may_look_along(how, first)) {
        sees_waves_ = is_patient_ = is_wavy_towards(program, first);
        if (sees_waves_)
            state_.note(text("level ", state_.space.level,
                             ": between the start and the best design values go up and down, as of an objective with "
                             "many minima"));
        if (program_.quantity_failed()) return ended(best);
    }
    if (!is_patient_ || !sees_waves_) return best;
    // A search that comes back at once leaves its evaluations to another one.
    for (int number = 1, left = first.evaluations; 2 * left >= first.evaluations && may_go_on(best); ++number) {
        const std::optional<VectorXd> start = another_start(program, how.seed, number);
        if (!start) break;
        NonlinearProgram other = program;
        other.start = *start;
        other.hessian.resize(0, 0);
        how.max_evaluations = std::clamp(left, 1, state_.evaluations_left());
        if (how.max_seconds > 0) how.max_seconds = state_.seconds_left();
        const MinimizeResult found = minimize(other, how);
        state_.note(text("level ", state_.space.level, ": objective ", best.best.objective, " before, ",
                         found.best.objective, " from another start after ", found.evaluations, " evaluations"));
        left -= std::max(1, found.evaluations);
        best = better_of(best, found);
        failure_ = found.reason;
        if (program_.quantity_failed()) return ended(best);
    }
    return best;
}

}  // namespace strake
