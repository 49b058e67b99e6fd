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
constexpr int looks_along = 4;  ///< points between start and best: as many as a batch
/// Of the radius of a search by models, and evaluations of batches that ended so: what goes well is not looked at.
constexpr int shrinks_by_waves = 2, evaluations_by_waves = 8;
constexpr double visible_gain = 1e-6;  ///< of the objective: less is no line to look along
constexpr int levels_worth = 3;        ///< as many evaluations as the first level has cost must be left

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

double WaveWatch::as_stated(double objective) const { return state_.problem.maximize ? -objective : objective; }

bool WaveWatch::has_left(double times) const {
    return state_.evaluations_left() >= times * state_.result.evaluations &&
           state_.seconds_left() >= times * state_.elapsed();
}

std::function<bool(double)> WaveWatch::on_misfit() {
    if (!is_on_) return {};
    return [this](double misfit) {
        if (misfit <= wavy_misfit) return true;
        sees_waves_ = true;
        if (state_.result.levels.size() == 1) is_patient_ = is_back_ = true;  // where it would go back to
        return is_back_ || state_.space.has_patches || !has_left(1);
    };
}

void WaveWatch::go_back() {
    goes_back_ = is_back_ = true;
    state_.note(text("level ", state_.space.level,
                     " has waves, as of an objective with many minima: the first fields are searched from the start, "
                     "and to their end before finer ones join"));
}

std::optional<VectorXd> WaveWatch::another_start(const NonlinearProgram& program, unsigned seed, int number) const {
    NonlinearProgram around = program;
    VectorXd reach = VectorXd::Zero(program.start.size());
    for (int j = 0; j < state_.space.size(); ++j)
        if (state_.space.variables[j].kind == VariableKind::field)
            reach[j] = reach_of_another_start * program_.weight()[j];
    around.lower_of_starts = program.lower.cwiseMax(program.start - reach);
    around.upper_of_starts = program.upper.cwiseMin(program.start + reach);
    VectorXd change = program_.symmetric_part(random_start(around, seed, number) - program.start);
    for (int k = 0; k <= max_halvings; ++k, change *= 0.5) {
        const VectorXd wanted = program.start + change;
        const VectorXd there = program.within ? program.within(wanted) : wanted;
        if (there != program.start && (!program.refusal || program.refusal(there).empty())) return there;
    }
    return {};
}

bool WaveWatch::may_look_along(const MinimizeOptions& how, const MinimizeResult& first) const {
    const double gained = std::abs(as_stated(first.best.objective) - state_.result.levels.back().objective_start);
    return is_on_by_values_ && how.method == Method::model && !state_.space.has_patches &&
           first.shrinks >= shrinks_by_waves && how.batch * first.shrinks >= evaluations_by_waves &&
           may_continue(state_, first) && has_left(levels_worth) &&
           gained > visible_gain * std::abs(first.best.objective);
}

bool WaveWatch::is_wavy_towards(const NonlinearProgram& program, MinimizeResult& best) {
    constexpr int count = looks_along + 2;
    std::vector<VectorXd> points;
    for (int k = 1; k + 1 < count; ++k) {
        const VectorXd there = program.start + k / (count - 1.0) * (best.x - program.start);
        points.push_back(program.within ? program.within(there) : there);
        if (program.refusal && !program.refusal(points.back()).empty()) return false;
    }
    if (program.expect) program.expect(points);
    VectorXd values(count);
    values[0] = as_stated(state_.result.levels.back().objective_start);
    values[count - 1] = best.best.objective;
    for (int k = 1; k + 1 < count; ++k) {
        const VectorXd& x = points[static_cast<std::size_t>(k) - 1];
        const Evaluation there = program.evaluate(x);
        ++best.evaluations;
        if (!there.failure.empty()) {
            ++best.failures;
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

MinimizeResult WaveWatch::search(const NonlinearProgram& program, MinimizeOptions how) {
    how.max_evaluations = std::clamp(how.max_evaluations, 1, std::max(1, state_.evaluations_left()));
    if (how.max_seconds > 0) how.max_seconds = state_.seconds_left();
    MinimizeResult found = minimize(program, how);
    failure_ = found.reason;
    return found;
}

MinimizeResult WaveWatch::finished(const NonlinearProgram& program, MinimizeOptions how, MinimizeResult result) {
    if (how.method == Method::model || result.stop != MinimizeStop::evaluations || !may_continue(state_, result))
        return result;
    NonlinearProgram rest = program;
    rest.start = result.x;
    rest.hessian = result.hessian;
    how.max_evaluations = state_.evaluations_left();
    const MinimizeResult more = search(rest, how);
    result = better_of(more, result);
    result.stop = more.stop;
    result.reason = more.reason;
    return result;
}

MinimizeResult WaveWatch::from_another_start(const NonlinearProgram& program, const MinimizeOptions& how,
                                             const MinimizeResult& first) {
    MinimizeResult best = first;
    // A search that comes back at once leaves its evaluations to another one.
    int left = first.evaluations;
    for (int number = 1; 2 * left >= first.evaluations && state_.evaluations_left() >= left; ++number) {
        const std::optional<VectorXd> start = another_start(program, how.seed, number);
        if (!start || !may_continue(state_, best)) break;
        state_.note(
            text("level ", state_.space.level, ": many minima; its search begins once more, at random changes"));
        NonlinearProgram other = program;
        other.start = *start;
        other.hessian.resize(0, 0);
        MinimizeOptions again = how;
        again.max_evaluations = left;
        const MinimizeResult found = search(other, again);
        const auto words = [&](const MinimizeResult& end) {
            return std::isfinite(end.best.objective)
                       ? text("objective ", as_stated(end.best.objective), end.is_feasible ? "" : ", not feasible")
                       : std::string("no value");
        };
        state_.note(text("level ", state_.space.level, ": ", words(found), " after ", found.evaluations,
                         " evaluations from there; before, ", words(best)));
        left -= std::max(1, found.evaluations);
        best = better_of(best, found);
        if (program_.quantity_failed()) break;
    }
    return best;
}

MinimizeResult WaveWatch::look_elsewhere(const NonlinearProgram& program, const MinimizeOptions& how,
                                         const MinimizeResult& first) {
    MinimizeResult best = first;
    if (may_look_along(how, first)) sees_waves_ = is_patient_ = is_wavy_towards(program, best);
    if (is_patient_ && sees_waves_) {
        best = finished(program, how, best);
        if (!program_.quantity_failed()) best = from_another_start(program, how, best);
        if (!program_.quantity_failed()) best = finished(program, how, best);
    }
    if (best.stop == MinimizeStop::evaluations && best.evaluations > first.evaluations)
        best.reason = text("the limit of evaluations", how.scope, " is reached (", best.evaluations, ")");
    if (program_.quantity_failed() && first.stop != MinimizeStop::failed)
        best.stop = MinimizeStop::failed, best.reason = failure_;
    return best;
}

}  // namespace strake
