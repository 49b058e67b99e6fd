#include <chrono>
#include <cmath>

#include "core/error.hpp"
#include "core/primo/coarse_shell.hpp"
#include "core/primo/newton_systems.hpp"

/// The minimum of the shell's energy. Main method: Newton with the mixed-integration-point stress (full steps, no
/// descent demanded: after a rotation step the true jumps hold a spurious membrane part of order 1/h^2 that would
/// poison both the Hessian and a line search). Its systems are solved by conjugate gradients on the factor of an
/// earlier iteration or design, as exactly as the next step can make use of. Fallbacks: Newton with line search, then
/// load steps from rest. A long way from rest is gone by a coarser shell first (nested iteration). The end is polished
/// with the exact Hessian and shown to be a minimum.
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
constexpr int hasty_growth_limit = 2;   // the same where failing early is asked for
constexpr double far = 0.3;             // diagonals: what is further away is approached in stages
constexpr double farthest = 1e3;        // diagonals: no more stages for what is further
constexpr double stage_end = 0.02;      // diagonals: step from which the next stage begins
constexpr int stage_iterations = 4;     // allowed to each
constexpr int least_for_coarse = 4000;  // free prisms from which a coarser shell goes ahead
constexpr double worth_coarse = 0.05;   // diagonals: first step from which it does
constexpr double worth_anew = 0.2;      // the same where what is kept of the rest state serves no longer after that
// A step from a guess that is longer changes the matrix so much that one set up anew pays; a factor costs more.
constexpr double rough_guess = 0.005, rough_guess_for_factor = 0.02;  // diagonals
constexpr int coarse_load_steps = 4;                                  // where it does not get there at once
constexpr double coarse_end = 0.01;  // diagonals: step with which it has gone far enough

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

/// One solve: what all attempts share.
struct Attempt {
    PrimoShell::Impl& shell;
    const SolveOptions& options;
    const SolveProgress& progress;
    Equilibrium& end;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    bool cancelled = false;
    NewtonSystems systems{shell, options, end};
    const std::vector<RigidMotion>& motions;
    bool is_rough = false;    ///< on a coarser shell: ends with a step below `coarse_end`
    double worth = 0;         ///< and at once, without success, if the first is below this
    bool is_guided = true;    ///< goes ahead on a coarser shell where the way is long
    bool was_guided = false;  ///< has done so
    bool was_misled = false;  ///< and ended beside an indefinite matrix: about to snap

    bool out_of_budget() const {
        // What is as good as there is not given up for a few iterations.
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
    bool line_search(const Loads& loads);
    bool finish(const Loads& loads, Iterate at);
    bool load_steps(const Loads& loads, const std::vector<RigidMotion>& motions, int count);
};

/// What is far away is approached in stages: a share of the residual at the start is left standing as a dead load.
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

/// Moves the prisms from rest to about where the equilibrium of a coarser shell is. False where they stay at rest; it
/// is no more than a guide, so that what it cannot do is left to the finer one.
bool Attempt::go_ahead(const Loads& loads, bool pins_moved, double worth_from) {
    if (!is_guided || shell.rest.num_free() < least_for_coarse || !is_at_rest(shell)) return false;
    const SolveProgress ahead = [this](SolveRecord record) {
        record.iteration = 0;
        return !progress || progress(record);
    };
    CoarseShell coarse = coarsen(shell.rest, is_rough ? 1 : 2);
    PrimoShell::Impl rough(std::move(coarse.rest), LinearSolver::automatic, 1);
    rough.spring_pattern = shell.spring_pattern;  // that every part is held is known
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
            attempt.worth = 0;  // a load step may be short
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

/// From rest without a guide; what was there is taken back where that finds nothing of less energy.
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

bool Attempt::mixed(const Loads& loads, bool pins_moved, bool reuse) {
    reuse = (reuse || shell.is_kept_here) && shell.kept.is_built();
    const bool is_near = go_ahead(loads, pins_moved, std::max(worth, reuse ? worth_anew : worth_coarse));
    if (is_near) reuse = false;
    Iterate at = iterate(shell, loads);
    Jumps stress = std::move(at.jump);  // a twentieth of all memory each: one of them at a time
    // Pins that jumped leave gaping faces: their stress means nothing yet.
    StressTerm term = is_near || pins_moved ? StressTerm::none : StressTerm::exact;
    systems.begin();
    double smallest = std::numeric_limits<double>::infinity();
    int growing = 0;  // iterations in a row with a step well above the smallest
    Stages stages;
    for (int i = 0; i < attempt_limit + stage_iterations * (stages.count - 1) && !out_of_budget(); ++i) {
        at.jump = {};
        if (stages.left > 0) at.gradient -= stages.left * stages.start;
        Eigen::VectorXd twist = systems.step(at, stress, loads, term, reuse);
        if (twist.size() == 0) {
            end.reason = "the matrix stays indefinite near the equilibrium: the shell buckles";
            return false;
        }
        if (!twist.allFinite()) return false;
        const double first = i == 0 ? step_size(shell.rest, twist) : 0;
        if (i == 0 && !is_near && first < worth) return false;
        if (first > far && options.fallbacks) {
            stages.begin(at.gradient, first);
            twist *= stages.share;
        }
        cap(shell.rest, twist);
        stress = {};  // what is replaced is given up first
        stress = sum(jumps(shell.rest, shell.poses, at.turn), jump_rates(shell.rest, at.turn, twist));
        term = StressTerm::exact;
        shell.advance(twist);
        at = {};
        at = iterate(shell, loads);
        const double step = step_size(shell.rest, twist);
        record(at, loads, step);
        if (!std::isfinite(at.norm)) return false;
        if (is_near && i == 0 && step > (shell.kept.is_exact() ? rough_guess_for_factor : rough_guess)) reuse = false;
        if (stages.advance(step)) {
            smallest = std::numeric_limits<double>::infinity();
            growing = 0;
            systems.begin();
            continue;
        }
        if (is_rough && step < coarse_end) {
            was_misled = is_near && systems.was_clipped();
            return true;
        }
        if (step < nearly_there) {
            stress = {};
            twist.resize(0);
            return finish(loads, std::move(at));
        }
        growing = step > 1.5 * smallest ? growing + 1 : 0;
        smallest = std::min(smallest, step);
        if (growing >= (options.fallbacks ? growth_limit : hasty_growth_limit)) return false;
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
        double length = 1;
        for (int halvings = 0; halvings < 20; ++halvings, length /= 2) {
            shell.poses = poses;
            shell.advance(length * twist);
            at = iterate(shell, loads);
            // Below the round-off of E itself descent cannot be seen.
            if (energy(shell.rest, at.jump, loads) <= E + 1e-4 * length * slope + 1e-14 * std::abs(E)) break;
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
    const auto begin_again = [&] {
        shell.poses = before;
        shell.has_moved();
        shell.place_pinned(motions);
        end.reason.clear();
    };
    bool done = attempt.mixed(loads, pins_moved, options.keep_factor);
    attempt.is_guided = false;
    if (!done && attempt.was_guided && !attempt.out_of_budget()) {
        begin_again();
        done = attempt.mixed(loads, pins_moved, false);
    }
    if (!done && options.fallbacks && !attempt.out_of_budget()) {
        begin_again();
        done = !pins_moved && attempt.line_search(loads);
    }
    for (int steps = 4; !done && options.fallbacks && steps <= 16 && !attempt.out_of_budget(); steps *= 4) {
        end.reason.clear();
        done = attempt.load_steps(loads, motions, steps);
    }
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
    end.status = attempt.cancelled    ? SolveStatus::cancelled
                 : end.reason.empty() ? SolveStatus::not_converged
                                      : SolveStatus::unstable;
    if (attempt.cancelled)
        end.reason = "cancelled";
    else if (end.reason.empty())
        end.reason = text("no equilibrium after ", end.iterations, " Newton iterations (last step ", end.last_step,
                          " diagonals): the loads are too large or the shell buckles");
    shell.poses = before;
    shell.has_moved();
    return end;
}

}  // namespace strake
