#include <chrono>
#include <cmath>

#include "core/error.hpp"
#include "core/primo/coarse_shell.hpp"
#include "core/primo/newton_systems.hpp"

/// The minimum of the shell's energy. Main method: Newton with the mixed-integration-point stress (full steps, no
/// descent demanded: after a rotation step the true jumps hold a spurious membrane part of order 1/h^2 that would
/// poison both the Hessian and a line search). Conjugate gradients with the factor of an earlier iteration or design
/// solve its systems as accurately as the next step can use. Fallbacks: Newton with line search, then load steps from
/// rest. A coarser shell first predicts large deformations from rest (nested iteration). The end is refined with the
/// exact Hessian and proven to be a minimum.
namespace strake {
namespace {

constexpr double largest_turn = 1.0;      // radians a prism may turn in one step
constexpr double largest_travel = 1.0;    // diagonals a prism may travel in one step
constexpr double nearly_there = 1e-5;     // diagonals: from here the exact Hessian takes over
constexpr double enough_gradient = 3e-8;  // relative: round-off leaves 1e-9 to 1e-7
constexpr double roundoff_step = 1e-15;   // diagonals: from here a gradient that still falls means nothing
constexpr int attempt_limit = 25;         // iterations of one mixed attempt
constexpr int growth_limit = 4;           // iterations in a row that lead away
constexpr double closing_step = 1e-3;     // diagonals: from here a few iterations more are allowed
constexpr int extra_iterations = 4;
constexpr int hasty_growth_limit = 2;  // the same where failing early is asked for
constexpr double far = 0.3;            // diagonals: longer ways are gone in stages
constexpr double farthest = 1e3;       // diagonals: the number of stages grows no further beyond this
constexpr double stage_end = 0.02;     // diagonals: step from which the next stage begins
constexpr int stage_iterations = 4;    // allowed to each
constexpr int min_for_coarse = 4000;   // free prisms from which a coarser shell predicts
constexpr double worth_coarse = 0.05;  // diagonals: first step from which it does
constexpr double worth_anew = 0.2;     // the same when the kept preconditioner is lost by it
// A longer first step from a guess changes the matrix so much that a new preconditioner pays; a factor costs more.
constexpr double rough_guess = 0.005, rough_guess_for_factor = 0.02;  // diagonals
constexpr int coarse_load_steps = 4;                                  // if the first attempt fails
constexpr double coarse_end = 0.01;  // diagonals: step at which the coarse solution is good enough

/// Shortens a step so that no prism turns or travels too far.
double cap(const RestState& rest, Eigen::VectorXd& twist) {
    double turn = 0, travel = 0;
    for (int f = 0; f < rest.num_free(); ++f) {
        turn = std::max(turn, twist.segment<3>(6 * f).norm());
        travel = std::max(travel, twist.segment<3>(6 * f + 3).norm());
    }
    const double factor = std::min(
        {1.0, largest_turn / std::max(turn, 1e-300), largest_travel * rest.diagonal / std::max(travel, 1e-300)});
    if (factor < 1) twist *= factor;
    return factor;
}

/// A long way is gone in stages: a share of the residual at the start stays as a dead load.
struct Stages {
    Eigen::VectorXd start;  ///< the residual there
    double left = 0, share = 0;
    int count = 1;

    void begin(const Eigen::VectorXd& residual, double step) {
        start = residual;
        count = static_cast<int>(std::ceil(std::min(step, farthest) / far));
        share = 1.0 / count;
        left = 1 - share;
    }
    bool advance(double step) {
        if (left == 0 || step > stage_end) return false;
        left = left < 1.5 * share ? 0 : left - share;
        return true;
    }
};

/// State of the mixed method.
struct Mixed {
    Iterate at;
    Jumps stress;
    StressTerm term = StressTerm::exact;
    bool is_near = false;  ///< began at the result of a coarser shell
    bool reuse = false;    ///< the preconditioner of an earlier iteration or design
    double smallest = std::numeric_limits<double>::infinity();  ///< step
    int growing = 0;                                            ///< steps in a row well above the smallest
    Stages stages;

    void forget_steps() {
        smallest = std::numeric_limits<double>::infinity();
        growing = 0;
    }
    int growing_after(double step) {
        growing = step > 1.5 * smallest ? growing + 1 : 0;
        smallest = std::min(smallest, step);
        return growing;
    }
};

/// One solve: shared by all attempts.
struct Attempt {
    PrimoShell::Impl& shell;
    const SolveOptions& options;
    const SolveProgress& progress;
    Equilibrium& end;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    bool cancelled = false;
    NewtonSystems systems{shell, options, end};
    const std::vector<RigidMotion>& motions;
    bool is_rough = false;    ///< on a coarser shell: ends at a step below `coarse_end`
    double worth = 0;         ///< and fails at once if the first is below this
    bool is_guided = true;    ///< predicts large deformations on a coarser shell
    bool was_guided = false;  ///< did so
    bool was_misled = false;  ///< and met an indefinite matrix there: close to snapping

    bool out_of_budget() const {
        // A nearly converged solve gets a few more iterations.
        const bool closing_in = end.last_step > 0 && end.last_step < closing_step;
        return cancelled || end.iterations >= options.max_iterations + (closing_in ? extra_iterations : 0);
    }

    void record(const Iterate& at, const Loads& loads, double step) {
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        end.records.push_back({++end.iterations, energy(shell.rest, at.jump, loads),
                               at.norm / std::max(at.scale, 1e-300), step, seconds});
        systems.took(step);
        if (progress && !progress(end.records.back())) cancelled = true;
    }

    bool go_ahead(const Loads& loads, bool pins_moved, double worth_from);
    bool compare_from_rest(const Loads& loads, bool pins_moved);
    bool mixed(const Loads& loads, bool pins_moved, bool reuse);
    Mixed begin_mixed(const Loads& loads, bool pins_moved, bool reuse);
    bool is_rough_guess(double step) const;
    Eigen::VectorXd mixed_step(Mixed& m, const Loads& loads, bool is_first);
    double take_mixed_step(Mixed& m, const Loads& loads, const Eigen::VectorXd& twist);
    bool line_search(const Loads& loads);
    bool finish(const Loads& loads, Iterate at);
    bool load_steps(const Loads& loads, const std::vector<RigidMotion>& motions, int count);
    bool reach(const Loads& loads, bool pins_moved, const Poses& before);
    void report_failure();
};

void add(const SolveTimes& from, SolveTimes& to) {
    to.assembly += from.assembly;
    to.ordering += from.ordering;
    to.factorization += from.factorization;
    to.substitution += from.substitution;
}

bool is_at_rest(const PrimoShell::Impl& shell) {
    for (const int i : shell.rest.free_prisms)
        if ((shell.poses.displacement.row(i).array() != 0).any() || shell.poses.rotation[i].w() != 1) return false;
    return true;
}

/// Moves the prisms from rest to the equilibrium of a coarser shell. False: they stay at rest. This is only a guess;
/// the finer shell does the rest.
bool Attempt::go_ahead(const Loads& loads, bool pins_moved, double worth_from) {
    if (!is_guided || shell.rest.num_free() < min_for_coarse || !is_at_rest(shell)) return false;
    const SolveProgress ahead = [this](SolveRecord record) {
        record.iteration = 0;
        return !progress || progress(record);
    };
    CoarseShell coarse = coarsen(shell.rest, is_rough ? 1 : 2);
    PrimoShell::Impl rough(std::move(coarse.rest), LinearSolver::automatic, 1);
    rough.spring_pattern = shell.spring_pattern;  // support of every part is already checked
    rough.prepare(loads.spring);
    rough.place_pinned(motions);
    Equilibrium found;
    Attempt attempt{.shell = rough,
                    .options = options,
                    .progress = ahead,
                    .end = found,
                    .motions = motions,
                    .is_rough = true,
                    .worth = worth_from};
    bool is_found = false;
    try {
        is_found = attempt.mixed(loads, pins_moved, false);
        if (attempt.was_misled && !attempt.cancelled) is_found = attempt.compare_from_rest(loads, pins_moved);
        if (!is_found && found.iterations > 0 && options.fallbacks && !attempt.cancelled) {
            found.iterations = 0;
            attempt.worth = 0;  // load steps may be short
            is_found = attempt.load_steps(loads, motions, coarse_load_steps);
        }
    } catch (const SolverError&) {
    }
    add(rough.seconds, shell.seconds);
    cancelled = attempt.cancelled;
    if (!is_found) return false;
    shell.poses = prolonged(shell.rest, coarse, rough.rest, rough.poses);
    shell.place_pinned(motions);
    shell.has_moved();
    return was_guided = true;
}

/// Solves from rest without a guess; restores the guessed solution unless this finds less energy.
bool Attempt::compare_from_rest(const Loads& loads, bool pins_moved) {
    const Poses guided = shell.poses;
    const double guided_energy = end.records.back().energy;
    shell.reset_poses();
    shell.place_pinned(motions);
    is_guided = false;
    end.iterations = 0;
    try {
        if (mixed(loads, pins_moved, false) && end.records.back().energy < guided_energy) return true;
    } catch (const SolverError&) {
    }
    if (cancelled) return false;
    shell.poses = guided;
    shell.has_moved();
    return true;
}

/// The next step of the mixed method, not longer than one iteration may go; empty where there is none.
Eigen::VectorXd Attempt::mixed_step(Mixed& m, const Loads& loads, bool is_first) {
    m.at.jump = {};
    if (m.stages.left > 0) m.at.gradient -= m.stages.left * m.stages.start;
    Eigen::VectorXd twist = systems.step(m.at, m.stress, loads, m.term, m.reuse);
    if (twist.size() == 0) {
        end.reason = "the matrix stays indefinite near the equilibrium: the shell buckles";
        return {};
    }
    if (!twist.allFinite()) return {};
    const double first = is_first ? step_size(shell.rest, twist) : 0;
    if (is_first && !m.is_near && first < worth) return {};
    if (first > far && options.fallbacks) {
        m.stages.begin(m.at.gradient, first);
        twist *= m.stages.share;
    }
    cap(shell.rest, twist);
    return twist;
}

/// Takes the step and predicts the stress after it. @return its size
double Attempt::take_mixed_step(Mixed& m, const Loads& loads, const Eigen::VectorXd& twist) {
    m.stress = {};  // frees the memory of the old one first
    m.stress = sum(jumps(shell.rest, shell.poses, m.at.turn), jump_rates(shell.rest, m.at.turn, twist));
    m.term = StressTerm::exact;
    shell.advance(twist);
    m.at = {};
    m.at = iterate(shell, loads);
    const double step = step_size(shell.rest, twist);
    record(m.at, loads, step);
    return step;
}

Mixed Attempt::begin_mixed(const Loads& loads, bool pins_moved, bool reuse) {
    Mixed m;
    m.reuse = (reuse || shell.is_kept_here) && shell.kept.is_built();
    m.is_near = go_ahead(loads, pins_moved, std::max(worth, m.reuse ? worth_anew : worth_coarse));
    if (m.is_near) m.reuse = false;
    m.at = iterate(shell, loads);
    m.stress = std::move(m.at.jump);  // each takes a twentieth of all memory: only one exists at a time
    // Where pins have jumped, the jumps at their faces are no stress yet.
    m.term = m.is_near || pins_moved ? StressTerm::none : StressTerm::exact;
    return m;
}

/// Whether the first step from a guess is so long that the preconditioner should be rebuilt.
bool Attempt::is_rough_guess(double step) const {
    return step > (shell.kept.is_exact() ? rough_guess_for_factor : rough_guess);
}

bool Attempt::mixed(const Loads& loads, bool pins_moved, bool reuse) {
    Mixed m = begin_mixed(loads, pins_moved, reuse);
    const int limit = options.fallbacks ? growth_limit : hasty_growth_limit;
    systems.begin();
    for (int i = 0; i < attempt_limit + stage_iterations * (m.stages.count - 1) && !out_of_budget(); ++i) {
        Eigen::VectorXd twist = mixed_step(m, loads, i == 0);
        if (twist.size() == 0) return false;
        const double step = take_mixed_step(m, loads, twist);
        if (!std::isfinite(m.at.norm)) return false;
        if (m.is_near && i == 0 && is_rough_guess(step)) m.reuse = false;
        if (m.stages.advance(step)) {
            m.forget_steps();
            systems.begin();
            continue;
        }
        if (is_rough && step < coarse_end) {
            was_misled = m.is_near && systems.was_clipped();
            return true;
        }
        if (step < nearly_there) {
            m.stress = {};
            twist.resize(0);
            return finish(loads, std::move(m.at));
        }
        if (m.growing_after(step) >= limit) return false;
    }
    return false;
}

/// Exact Newton steps to the floor, and the proof that the end is a minimum.
bool Attempt::finish(const Loads& loads, Iterate at) {
    systems.begin_end(options.min_step);
    bool reuse = true;
    const int clipped_before = systems.clipped();
    const auto buckles = [this] {
        end.reason = "the equilibrium is not a stable minimum (the exact Hessian is indefinite): the shell buckles";
        return false;
    };
    for (int i = 0; i < 8 && !out_of_budget(); ++i) {
        const Eigen::VectorXd twist = systems.step(at, at.jump, loads, StressTerm::exact, reuse);
        if (twist.size() == 0 || systems.clipped() > clipped_before) return buckles();
        if (!twist.allFinite()) return false;
        const double before = at.norm;
        const Poses poses = shell.poses;
        shell.advance(twist);
        at = {};
        at = iterate(shell, loads);
        record(at, loads, step_size(shell.rest, twist));
        if (!systems.is_done()) continue;
        const bool still_falls = at.norm > enough_gradient * at.scale && at.norm < before / 2;
        if (still_falls && end.last_step > roundoff_step) continue;             // without loads the scale falls with it
        if (at.norm > before) shell.poses = poses, at = iterate(shell, loads);  // at the floor round-off decides
        end.gradient_norm = at.norm;
        end.relative_gradient = at.norm / std::max(at.scale, 1e-300);
        end.energy = energy(shell.rest, at.jump, loads);
        if (!systems.is_minimum(at, loads)) return buckles();
        shell.has_tangent = true;
        end.stable = true;
        return true;
    }
    return false;
}

bool Attempt::line_search(const Loads& loads) {
    Iterate at = iterate(shell, loads);
    systems.begin();
    while (!out_of_budget()) {
        bool reuse = false;
        Eigen::VectorXd twist = systems.step(at, at.jump, loads, StressTerm::exact, reuse);
        if (!twist.allFinite()) return false;
        cap(shell.rest, twist);
        const double E = energy(shell.rest, at.jump, loads), slope = at.gradient.dot(twist);
        const Poses poses = shell.poses;
        double length = 2;
        bool is_lower = false;
        for (int tried = 0; tried < 20 && !is_lower; ++tried) {
            length /= 2;
            shell.poses = poses;
            shell.advance(length * twist);
            at = iterate(shell, loads);
            // Below the round-off of E itself descent cannot be seen.
            is_lower = energy(shell.rest, at.jump, loads) <= E + 1e-4 * length * slope + 1e-14 * std::abs(E);
        }
        if (!is_lower) {  // no way down: a step that leads up is not taken
            shell.poses = poses;
            shell.has_moved();
            return false;
        }
        const double step = length * step_size(shell.rest, twist);
        record(at, loads, step);
        if (!std::isfinite(at.norm)) return false;
        if (step < nearly_there && length == 1) return finish(loads, std::move(at));
        if (step < 1e-3 * options.min_step) return false;
    }
    return false;
}

bool Attempt::load_steps(const Loads& loads, const std::vector<RigidMotion>& motions, int count) {
    shell.reset_poses();
    end.load_steps = count;
    for (int s = 1; s <= count; ++s) {
        const double share = static_cast<double>(s) / count;
        Loads part = loads;
        part.force *= share;
        std::vector<RigidMotion> moved = motions;
        for (RigidMotion& motion : moved) motion.rotation *= share, motion.translation *= share;
        shell.place_pinned(moved);
        if (!mixed(part, !motions.empty(), false)) return false;
    }
    return true;
}

/// The mixed method, then the fallbacks. @param before poses from which each attempt starts
bool Attempt::reach(const Loads& loads, bool pins_moved, const Poses& before) {
    const auto begin_again = [&] {
        shell.poses = before;
        shell.has_moved();
        shell.place_pinned(motions);
        end.reason.clear();
    };
    bool done = mixed(loads, pins_moved, options.keep_factor);
    is_guided = false;
    if (!done && was_guided && !out_of_budget()) {
        begin_again();
        done = mixed(loads, pins_moved, false);
    }
    if (!done && options.fallbacks && !out_of_budget()) {
        begin_again();
        done = !pins_moved && line_search(loads);
    }
    for (int steps = 4; !done && options.fallbacks && steps <= 16 && !out_of_budget(); steps *= 4) {
        end.reason.clear();
        done = load_steps(loads, motions, steps);
    }
    return done;
}

void Attempt::report_failure() {
    end.status = cancelled            ? SolveStatus::cancelled
                 : end.reason.empty() ? SolveStatus::not_converged
                                      : SolveStatus::unstable;
    if (cancelled)
        end.reason = "cancelled";
    else if (end.reason.empty())
        end.reason = text("no equilibrium after ", end.iterations, " Newton iterations (last step ", end.last_step,
                          " diagonals): the loads are too large or the shell buckles");
}

bool differ(const std::vector<RigidMotion>& a, const std::vector<RigidMotion>& b) {
    if (a.size() != b.size()) return true;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i].rotation != b[i].rotation || a[i].translation != b[i].translation || a[i].about != b[i].about)
            return true;
    return false;
}

}  // namespace

Equilibrium PrimoShell::solve(const Loads& given, const std::vector<RigidMotion>& motions, const SolveOptions& options,
                              const SolveProgress& progress) {
    Impl& shell = *impl_;
    if (!(options.min_step > 0) || options.max_iterations < 1)
        throw InvalidInput(text("shell: min_step ", options.min_step, " must be > 0 and max_iterations ",
                                options.max_iterations, " >= 1"));
    const Loads loads = complete(given, shell.rest.mesh.num_vertices());
    check_motions(shell.rest, motions);
    shell.seconds = {};
    const bool is_there = shell.has_tangent && shell.reached && options.min_step >= shell.reached_step &&
                          !differ(motions, shell.motions) && loads.force == shell.loads.force &&
                          loads.spring == shell.loads.spring;
    if (is_there) return *shell.reached;
    const int substitutions_before = shell.substitutions;
    shell.prepare(loads.spring);
    const Poses before = shell.poses;
    const bool pins_moved = differ(motions, shell.motions);

    Equilibrium end;
    end.first_solver = solver();
    Attempt attempt{.shell = shell, .options = options, .progress = progress, .end = end, .motions = motions};
    shell.place_pinned(motions);
    const bool done = attempt.reach(loads, pins_moved, before);
    end.seconds = shell.seconds;
    end.substitutions = shell.substitutions - substitutions_before;
    end.solver = solver();
    if (done) {
        end.status = SolveStatus::converged;
        end.reason = text("equilibrium after ", end.iterations, " Newton iterations");
        shell.loads = loads;
        shell.motions = motions;
        shell.reached = end;
        shell.reached_step = options.min_step;
        return end;
    }
    attempt.report_failure();
    shell.poses = before;
    shell.has_moved();
    return end;
}

}  // namespace strake
