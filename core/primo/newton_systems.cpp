#include "core/primo/newton_systems.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/primo/linear/spd_solver.hpp"

namespace strake {
namespace {

constexpr int cg_limit = 20;  // substitutions for one step, above which a new factor is cheaper
constexpr int multigrid_limit = 150, multigrid_kept_limit = 25;  // cycles: of this design, and of an earlier one
constexpr double hardly_moved = 0.002;                           // diagonals: below this new cycles would be no better
constexpr double exact_rate = 1e-3;        // of conjugate gradients on the matrix's own factor, in single precision
constexpr double loosest = 0.1;            // maximum relative residual of any step
constexpr double first_share = 0.05;       // in the first one
constexpr double tightest = 0.01;          // in later ones
constexpr double tightest_at_end = 1e-5;   // for the exact Hessian, unless a looser one is known to suffice
constexpr double hardly_changed = 0.02;    // after a step reduced by this, the Hessian serves once more
constexpr double usual_substitutions = 6;  // substitutions up to which a factor need not be renewed
constexpr int clipped_limit = 2;           // indefinite matrices near the end that count as buckling
constexpr double without_gradient_error = 0.2;     // least stiffness relative to the factor's design
constexpr double beside_springs = 1e-3;            // the same if lumped springs stiffen the factor
constexpr double left_at_end = 1e-4;               // of the largest allowed last step: finite differences resolve it
constexpr double roughly = 2;                      // times as much suffices if the prediction was different
constexpr double foreseen = 0.5;                   // of that step: a smaller predicted one is the last
constexpr double surely = 0.8;                     // of that step: a smaller actual one is the last
constexpr double last_but_one = 0.1;               // of that step: residual that longer ones may leave
constexpr int few_probes = 40, many_probes = 200;  // multigrid cycles that prove definiteness
constexpr int factor_limit = 300000;               // prisms whose factor takes 2 GB
constexpr double near_step = 0.02;                 // diagonals: near the end

double scaled_norm(const RestState& rest, const Wrenches& g6, bool pinned_ones) {
    return std::sqrt(ordered_sum(rest.num_prisms(), 4096, [&](int begin, int end) {
        double sum = 0;
        for (int i = begin; i < end; ++i)
            if ((rest.pin[i] != free_prism) == pinned_ones)
                sum += wrench_square(g6.row(i).head<3>(), g6.row(i).tail<3>(), rest.prism_height[i]);
        return sum;
    }));
}

}  // namespace

Iterate iterate(const PrimoShell::Impl& shell, const Loads& loads) {
    const RestState& rest = shell.rest;
    Iterate at;
    at.turn = rotation_differences(shell.poses);
    at.jump = jumps(rest, shell.poses, at.turn);
    const Wrenches g6 = energy_gradient(rest, at.turn, at.jump, loads);
    at.gradient.resize(6 * rest.num_free());
    for (int f = 0; f < rest.num_free(); ++f) at.gradient.segment<6>(6 * f) = g6.row(rest.free_prisms[f]).transpose();
    at.norm = scaled_norm(rest, g6, false);
    at.scale = scaled_norm(rest, applied_forces(rest, at.turn, loads), false);
    if (at.scale == 0) {  // strains only: the reactions; for a rigid motion, those of a comparable strain
        double moved = 0;
        for (int i = 0; i < rest.num_prisms(); ++i)
            if (rest.pin[i] > 0) moved = std::max(moved, shell.poses.displacement.row(i).norm());
        at.scale = std::max(scaled_norm(rest, g6, true), 1e-3 * moved);
    }
    return at;
}

void NewtonSystems::took(double step) {
    contraction_ = end_.last_step > 0 ? step / end_.last_step : 1;
    end_.last_step = step;
    moved_ += step;
}

bool NewtonSystems::is_done() const {
    return end_.last_step < ends_below_ && left_ * end_.last_step < roughly * left_at_end * ends_below_;
}

void NewtonSystems::assemble(const Iterate& at, const Jumps& stress, const Loads& loads, StressTerm term) {
    probe_.reset();
    was_clipped_ = false;
    shell_.assemble(at.turn, stress, loads, term);
    is_assembled_ = true;
}

/// Whether the previous design's Hessian is still assembled: only the loads have changed, and the next step corrects
/// their small effect on it.
bool NewtonSystems::is_at_hand(const Loads& loads, StressTerm term) const {
    return shell_.has_tangent && term == StressTerm::exact && loads.spring == shell_.loads.spring;
}

/// Factorizes the assembled matrix, with a clipped stress term if indefinite.
void NewtonSystems::factorize(const Iterate& at, const Jumps& stress, const Loads& loads) {
    ++end_.factorizations;
    moved_ = 0;
    if (!shell_.factorize()) clip(at, stress, loads);
}

/// Replaces an indefinite matrix by one with a clipped stress term. False if the shell is considered to buckle.
bool NewtonSystems::clip(const Iterate& at, const Jumps& stress, const Loads& loads) {
    if (end_.last_step > 0 && end_.last_step < near_step) ++clipped_;
    if (is_buckling()) return false;
    was_clipped_ = true;
    shell_.assemble(at.turn, stress, loads, StressTerm::clipped);
    ++end_.factorizations;
    if (!shell_.factorize())
        throw SolverError("deform: the stiffness without stress is not positive definite; a part is barely held");
    return true;
}

/// Without fallbacks, matrices that stay indefinite near the end count as buckling.
bool NewtonSystems::is_buckling() const { return !options_.fallbacks && clipped_ >= clipped_limit; }

/// The allowed residual matches the nonlinearity, the square of the last step's residual, but stays above the result of
/// a few iterations and above the final tolerance.
void NewtonSystems::adapt(double size, CgOptions& cg) {
    const double left = size_before_ > 0 ? size / size_before_ : 0;  // by the last step
    const double squared = size_before_ > 0 ? left * left : first_share;
    cg.tolerance = std::clamp(squared, ends_below_ > 0 ? tightest_at_end : tightest, loosest);
    if (ends_below_ > 0 && shell_.kept.is_exact()) {
        before_last_ = std::exchange(cg.tolerance, tightest_at_end);
    } else if (const double step = end_.last_step * left; ends_below_ > 0 && step > 0) {  // what is to be expected
        const double enough = std::min(loosest, left_at_end * ends_below_ / step);
        cg.tolerance = step < foreseen * ends_below_ ? enough : std::max(cg.tolerance, enough);
    }
    if (shell_.is_kept_here && shell_.kept.is_exact())
        cg.expected_rate = exact_rate;
    else if (is_rate_measured_)
        cg.expected_rate = rate_;
    else if (size_before_ > 0)
        cg.expected_rate = std::min(left, 1.0);  // its linear part cannot be larger
    else if (shell_.rate > 0)
        cg.expected_rate = shell_.rate;
    size_before_ = size;
}

CgResult NewtonSystems::solve_inexactly(const Iterate& at) {
    CgOptions cg;
    cg.max_iterations = shell_.kept.is_exact()  ? cg_limit
                        : moved_ < hardly_moved ? multigrid_limit
                                                : multigrid_kept_limit;
    if (probe_) cg.beside = &*probe_;
    // With multigrid the soft modes of another system would have to converge again: predict the step instead.
    if (ends_below_ > 0 && shell_.kept.is_exact())
        cg.is_enough = [this](const Eigen::VectorXd& x, double reduction) {
            const double step = step_size(shell_.rest, x);
            if (step < surely * ends_below_) return reduction * step < left_at_end * ends_below_;
            return reduction < before_last_ || reduction * step < last_but_one * ends_below_;
        };
    cg.adapt = [this](double size, CgOptions& now) { adapt(size, now); };
    CgResult result = conjugate_gradients(shell_, -at.gradient, cg);
    is_rate_measured_ = !(shell_.is_kept_here && shell_.kept.is_exact()) && result.iterations > 1;
    rate_ = result.rate;
    if (is_rate_measured_) shell_.rate = rate_;
    left_ = result.reduction;
    return result;
}

Eigen::VectorXd NewtonSystems::step(const Iterate& at, const Jumps& stress, const Loads& loads, StressTerm term,
                                    bool& reuse) {
    const bool is_old = reuse && ((contraction_ < hardly_changed && is_assembled_) || is_at_hand(loads, term));
    if (!is_old) assemble(at, stress, loads, term);
    if (reuse) {
        if (ends_below_ > 0 && shell_.kept.is_exact() && !probe_) probe_.emplace(shell_, without_gradient_error);
        const CgResult cg = solve_inexactly(at);
        if (cg.is_positive && cg.is_reached) return cg.x;
    }
    if (is_old) assemble(at, stress, loads, term);
    probe_.reset();
    size_before_ = 0;
    factorize(at, stress, loads);
    if (is_buckling()) return {};
    reuse = true;
    CgResult cg = solve_inexactly(at);
    if (!cg.is_positive && !shell_.kept.is_exact()) {  // the result of a factorization
        if (!clip(at, stress, loads)) return {};
        cg = solve_inexactly(at);
    }
    return cg.x;
}

/// The rest of the probe, for a Hessian that has barely changed.
Definiteness NewtonSystems::probed() {
    while (probe_->is_open()) probe_->advance(shell_, shell_.precondition(probe_->residual()));
    return probe_->found();
}

bool NewtonSystems::is_minimum(const Iterate& at, const Loads& loads) {
    shell_.spent += std::max(0.0, shell_.substitutions - spent_from_ - usual_substitutions);
    spent_from_ = shell_.substitutions;
    const bool pays = options_.keep_factor && shell_.spent > shell_.kept.build_cost();
    const bool is_probed = probe_ && !pays && contraction_ < hardly_changed;
    Definiteness found = is_probed ? probed() : Definiteness::uncertain;
    assemble(at, at.jump, loads, StressTerm::exact);
    if (!shell_.kept.is_exact()) return is_minimum_beside_multigrid(pays);
    if (!pays && !is_probed) found = probe_definiteness(shell_, without_gradient_error);
    if (found == Definiteness::yes) return true;
    ++end_.factorizations;
    if (!shell_.factorize()) return false;
    return shell_.spring.size() == 0 || probe_definiteness(shell_, beside_springs) == Definiteness::yes;
}

/// The softest mode of a shell close to buckling is hard to distinguish from an indefinite one: a factorization decides
/// if affordable, which also proves it for the matrix without springs; else many more cycles decide.
bool NewtonSystems::is_minimum_beside_multigrid(bool renew) {
    const bool is_affordable = shell_.rest.num_free() <= factor_limit;
    if (renew || !is_affordable) {
        ++end_.factorizations;
        if (!shell_.factorize()) return false;
    }
    const Definiteness found = probe_definiteness(shell_, beside_springs, is_affordable ? few_probes : many_probes);
    if (found != Definiteness::uncertain || !is_affordable) return found != Definiteness::no;
    SpdSolver factor;
    factor.analyze(shell_.H);
    ++end_.factorizations;
    return factor.factorize(shell_.H);
}

}  // namespace strake
