#include "optimize/nlp/nlopt/restarts.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"

namespace strake {

using Eigen::VectorXd;

namespace {

constexpr int max_openings = 12;
/// Evaluations without gain, for each variable and one, in a box that failures have cut: cobyla may walk along a side
/// of such a box without end.
constexpr int patience = 10;

class Restarts {
public:
    Restarts(Guard& guard, const MethodFacts& method, const Lagrangian* lagrangian, const VectorXd& start,
             const RestartOptions& options)
        : guard_(guard), lagrangian_(lagrangian), run_(guard, method, lagrangian), centre_(start), options_(options) {}

    SearchEnd run() {
        while (!run_once()) {
        }
        end_.x = lagrangian_ ? centre_ : run_.end_x;
        end_.at = at_;
        return end_;
    }

private:
    /// The violation counts first: a search for feasible points gains, too.
    struct Level {
        bool feasible;
        double value;
    };
    Level level() const {
        if (lagrangian_) return {true, lowest_};
        return {guard_.best_feasible, guard_.best_feasible ? guard_.best.objective : guard_.best_violation};
    }

    /// Runs the algorithm once in the present box. True: finished.
    bool run_once() {
        const Level before = level();
        const SearchBox box = box_around(guard_.program, centre_, radius_);
        const bool is_cut = std::isfinite(radius_) && !lagrangian_;
        guard_.set_patience(is_cut ? patience * static_cast<int>(guard_.free.size() + 1) : 0);
        const nlopt::result code = run_.run(centre_, box, options_.objective_tolerance, options_.step_tolerance);
        guard_.set_patience(0);
        recentre();
        if (guard_.cause == StopCause::stalled)
            guard_.cause = StopCause::none;  // in this box: that is as good as converged
        if (guard_.cause == StopCause::failure) return shrink(before);
        if (guard_.cause == StopCause::nonfinite_point) return broke_down("it asked for a point that is not finite");
        if (guard_.cause == StopCause::repeated_points) return repeats_points();
        if (guard_.cause != StopCause::none) return end_ = with_shrinks(end_by_cause(guard_)), true;
        if (code == nlopt::FAILURE || code == nlopt::INVALID_ARGS) return broke_down(run_.message);
        if (lies_on_artificial_side(guard_.program, box, centre_)) return grow();
        if (std::isfinite(radius_) && ++openings_ <= max_openings) return open();
        if (wants_confirmation(before)) return false;
        if (std::isfinite(radius_))
            return end(MinimizeStop::no_valid_step,
                       text("evaluations keep failing outside of steps of ", radius_,
                            ", within which nothing is left to gain; the last failure: ", guard_.failure));
        if (code == nlopt::ROUNDOFF_LIMITED)
            return end(MinimizeStop::roundoff, "no further progress in double precision");
        if (code == nlopt::MAXEVAL_REACHED || code == nlopt::MAXTIME_REACHED) return repeats_points();
        return end(MinimizeStop::converged, code == nlopt::XTOL_REACHED
                                                ? "the variables change by less than the tolerance"
                                                : "the objective changes by less than the tolerance");
    }

    void recentre() {
        if (!lagrangian_)
            centre_ = guard_.best_x;
        else if (run_.has_lowest()) {
            centre_ = run_.lowest_x;
            at_ = run_.lowest;
            lowest_ = run_.lowest.objective / guard_.scale + lagrangian_->value(guard_.program, run_.lowest);
        }
    }

    bool wants_confirmation(const Level& before) {
        const Level now = level();
        const bool gained = before.value - now.value > 10 * tolerance(now) || before.feasible != now.feasible;
        if (!gained || ++confirmations_ > options_.confirmations) return false;
        report("converged; a fresh start from here confirms or continues");
        return true;
    }

    double tolerance(const Level& now) const {
        if (lagrangian_) return options_.objective_tolerance * std::max(1.0, std::abs(now.value));
        return now.feasible ? guard_.decrease_tolerance(now.value) : options_.objective_tolerance * std::abs(now.value);
    }

    bool shrink(const Level& before) {
        const Level now = level();
        in_a_row_ = now.value < before.value || now.feasible != before.feasible ? 1 : in_a_row_ + 1;
        end_.is_at_border =
            !guard_.failed_on_the_way && guard_.border.classifier(guard_.best_x, metric_of(guard_.program)).has_value();
        if (end_.is_at_border)
            return end(MinimizeStop::no_valid_step,
                       text("evaluations fail beyond a border; the last failure: ", guard_.failure));
        if (in_a_row_ > options_.max_shrinks || end_.shrinks >= 4 * options_.max_shrinks)
            return end(MinimizeStop::no_valid_step,
                       text("evaluations fail next to the best point even after ", end_.shrinks,
                            " halvings of the step; the last failure: ", guard_.failure));
        ++end_.shrinks;
        const double widest = (guard_.program.upper - guard_.program.lower).maxCoeff();
        double step = (guard_.failed_x - centre_).lpNorm<Eigen::Infinity>();
        if (!(step > 0)) step = widest;  // a gradient failed at the centre itself
        // Half of the box, and less if the failing step was shorter than that.
        radius_ = std::min(0.5 * std::min(radius_, widest), 0.5 * step);
        if (!std::isfinite(radius_)) radius_ = guard_.options.first_step;
        report(text("evaluation ", guard_.evaluations, " failed (", guard_.failure,
                    "); starting again at the best point with steps up to ", radius_, " (halving ", end_.shrinks,
                    " of ", options_.max_shrinks, ")"));
        guard_.cause = StopCause::none;
        return false;
    }

    /// Converged in a box that failures have cut: better points may lie outside.
    bool open() {
        radius_ *= 4;
        if (radius_ >= (guard_.program.upper - guard_.program.lower).maxCoeff())
            radius_ = std::numeric_limits<double>::infinity();
        report(text("converged in the halved box; steps up to ", radius_, " again"));
        return false;
    }

    bool grow() {
        radius_ *= 2;
        report(text("the best point lies on a side of the halved box; steps up to ", radius_, " again"));
        return false;
    }

    /// Some algorithms give up without a reason: the best point stands, a fresh start may go on.
    bool broke_down(const std::string& message) {
        guard_.cause = StopCause::none;
        if (++breakdowns_ <= 2) return report("the algorithm broke down; starting again at the best point"), false;
        return end(MinimizeStop::roundoff, text("the algorithm broke down", message.empty() ? "" : " (" + message + ")",
                                                "; the best point seen stands"));
    }

    bool repeats_points() {
        guard_.cause = StopCause::none;
        return end(MinimizeStop::roundoff, "the algorithm repeats points that it knows");
    }

    bool end(MinimizeStop stop, const std::string& reason) {
        end_.stop = stop;
        end_.reason = reason;
        return true;
    }
    SearchEnd with_shrinks(SearchEnd by_cause) const {
        by_cause.shrinks = end_.shrinks;
        return by_cause;
    }
    void report(const std::string& event) const { guard_.report_event(event); }

    Guard& guard_;
    const Lagrangian* lagrangian_;
    NloptRun run_;
    VectorXd centre_;
    RestartOptions options_;
    SearchEnd end_;
    double lowest_ = std::numeric_limits<double>::infinity();
    double radius_ = std::numeric_limits<double>::infinity();
    Evaluation at_;  ///< with a Lagrangian: at the centre
    int confirmations_ = 0, breakdowns_ = 0, openings_ = 0, in_a_row_ = 0;
};

}  // namespace

SearchEnd run_with_restarts(Guard& guard, const MethodFacts& method, const Lagrangian* lagrangian,
                            const VectorXd& start, const RestartOptions& options) {
    return Restarts(guard, method, lagrangian, start, options).run();
}

SearchEnd end_by_cause(const Guard& guard) {
    SearchEnd end;
    end.x = guard.best_x;
    const GuardEnd found = guard.end_by_cause();
    end.stop = found.stop;
    end.reason = found.reason.empty() ? "the algorithm failed" : found.reason;
    if (guard.cause == StopCause::evaluations) end.is_final = guard.limit >= guard.options.max_evaluations;
    return end;
}

double objective_scale(const Guard& guard) {
    if (!guard.wants_gradient) return std::abs(guard.best.objective) > 0 ? std::abs(guard.best.objective) : 1;
    constexpr double floor = 1e-3;  // of the unconstrained gradient's step
    const NonlinearProgram& p = guard.program;
    const VectorXd direction = descent_direction(p, guard.best_x, guard.best);
    const double step = std::max(metric_norm(p, direction), floor * metric_norm(p, guard.best.gradient));
    return step > 0 && std::isfinite(step) ? step / guard.options.first_step : 1;
}

}  // namespace strake
