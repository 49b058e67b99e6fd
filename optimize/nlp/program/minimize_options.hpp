#pragma once
#include "optimize/nlp/program/methods.hpp"
#include "optimize/nlp/program/nonlinear_program.hpp"

/// Options, progress reports and result of a search.
namespace strake {

/// Progress report of one evaluation.
struct MinimizeStep {
    const Eigen::VectorXd& x;
    const Evaluation& evaluation;
    double violation = 0;  ///< largest scaled constraint violation
    /// The best point so far: feasible and lowest, or while none is feasible the least violation.
    bool is_best = false;
    bool is_feasible = false;
    double merit = 0;    ///< lowest objective + penalty * violations so far, by the present penalty
    double penalty = 0;  ///< of a unit of violation; it may rise and fall during a search
};

struct MinimizeOptions {
    Method method = Method::sqp;
    int max_evaluations = 200;          ///< >= 1
    double max_seconds = 0;             ///< 0: no limit
    double objective_tolerance = 1e-6;  ///< a share of the decrease gained so far
    double gained_before = 0;           ///< >= 0: by searches that this one continues
    double largest_gradient = 0;        ///< >= 0: of these searches, in the dual of the metric, of the Lagrangian
    /// As before 0.2: changes are relative to the objective or to 1e-3 of the gain, and gradients that led to an end
    /// are not confirmed. For runs that began so.
    bool is_relative_to_objective = false;
    /// The meaning of earlier runs: what the values of long steps leave open of a gradient is not asked again.
    bool trusts_long_steps = false;
    /// The meaning of earlier runs, of `model`: no curvature that all directions share, no slopes at the end, and what
    /// models hold back from a limit that is known exactly is left.
    bool learns_as_before = false;
    /// The meaning of earlier runs, of `sqp`: a model that expects a rise counts as one that expects little.
    bool descends_as_before = false;
    /// The meaning of earlier runs, of `model`: limits that are known exactly are met along the models' slopes, and
    /// points around the start or the best one do not keep them.
    bool limits_by_models = false;
    /// The meaning of earlier runs, of `model`: what limits that are known exactly have moved the limit of motion moves
    /// again, and designs without a shape are proposed.
    bool limits_by_turns = false;
    /// The meaning of earlier runs, of `model`: minima of models are looked for in all variables, not in the directions
    /// that their points tell of.
    bool minima_in_variables = false;
    /// The meaning of earlier runs, of `model`: nothing leads back to equations that the search has left.
    bool leaves_equations = false;
    /// The same: nor to limits that are known exactly.
    bool leaves_limits = false;
    /// The same: designs whose surface is not valid are evaluated where no shorter step has one that is.
    bool pays_without_shape = false;
    /// The same: directions that nothing is known of are looked along by what models are not sure of alone, with
    /// `batch: 1` hardly ever.
    bool stays_where_models_are_sure = false;
    /// The same: a symmetry that levels have found is refuted by later ones, whose images are taken for exact.
    bool images_are_exact = false;
    /// The same: models may follow waves that are shorter than what lies between their points.
    bool follows_short_waves = false;
    /// The meaning of earlier runs, of `sqp`: no step is looked at before it is evaluated.
    bool steps_pay_without_shape = false;
    /// sqp: the damping of a step that is too long is found by secants, not by bisection: where evaluations cost less
    /// than solving for a step.
    bool damps_by_secants = false;
    double step_tolerance = 1e-6;        ///< change of every variable
    double constraint_tolerance = 1e-6;  ///< scaled
    int max_shrinks = 8;                 ///< cuts of the step after failures in a row
    int max_failures = 12;               ///< sqp: for each ten accepted steps; others: 4 max_shrinks
    double first_step = 0.5;             ///< in the metric
    double max_step = 2;                 ///< of sqp: a little more than reasonable, because the metric is an estimate
    int batch = 8;                       ///< model: points that are proposed together, >= 1
    /// model: first steps go along one variable after another (each without what those before it can do), in place of
    /// directions in which all take part: where the first ones are the coarsest and an objective most often wants
    /// those.
    bool tries_in_order = false;
    /// model: of a first batch that is no larger than the number of variables only half is asked, twice as far away: it
    /// knows the start alone, and the sooner models choose, the better, where the first directions are most of it all.
    bool begins_with_few = false;
    /// model: variables, each named once, that are changed alone at first (but for what the metric couples), as many as
    /// half a batch: those of which one knows that objective and constraints depend on them strongly and in ways of
    /// their own, as on an angle of attack. Not where it tries in order, nor where designs are known already.
    std::vector<int> first_alone;
    /// model: the limit of evaluations is for all variables, and shrinks with what mirror images leave of them.
    bool limit_follows_variables = false;
    /// model: what the limit of evaluations may grow to. Where the last quarter of the evaluations has gained
    /// `gaining_share` of all that the search has, and more than noise, it has a quarter more (at least a batch), again
    /// and again. 0: `max_evaluations` is all.
    int limit_while_gaining = 0;
    double gaining_share = 0.15;  ///< in (0, 1]
    bool confirm = true;          ///< converged only when a fresh start at the end gains nothing more
    /// The given one, then random ones within the bounds, which must be finite. They share the budget.
    int starts = 1;
    unsigned seed = 1;                     ///< of random starts and of NLopt's random methods
    bool exceptions_are_failures = false;  ///< of the callbacks; except InvalidInput and std::bad_alloc
    std::string scope;                     ///< of the counts of evaluations in reasons, for example " of level 2"
    int evaluations_before = 0, failures_before = 0;   ///< of the same scope: they count in reasons
    std::function<bool(const MinimizeStep&)> on_step;  ///< return false to stop here; not called for differences
    /// sqp: called with the decrease that the model still expects and its Hessian, at every differentiated point that
    /// nearly meets the constraints; return false to stop here.
    std::function<bool(double expected, const Eigen::MatrixXd& hessian)> on_model;
    /// sqp with gradients of its own: called after every step that changes the Lagrangian by more than a thousandth of
    /// all that has been gained, with `parabola_misfit`; return false to stop here.
    std::function<bool(double misfit)> on_misfit;
    /// sqp without gradients: called at every accepted point that meets the constraints before its differences are
    /// paid; return false to stop here.
    std::function<bool()> before_differences;
    std::function<void(const std::string&)> on_event;  ///< restarts, starts and changes of the box, in words
    std::function<double()> clock;                     ///< seconds, for max_seconds; empty: the wall clock
};

enum class MinimizeStop {
    converged,
    roundoff,       ///< no further progress in double precision: usable
    evaluations,    ///< limit
    time,           ///< limit
    stopped,        ///< by on_step
    outpaced,       ///< by on_model or before_differences
    wavy,           ///< by on_misfit
    no_valid_step,  ///< evaluations fail however small the step
    failed          ///< the start or a fatal evaluation failed, or the algorithm broke down at once
};

struct MinimizeResult {
    Eigen::VectorXd x;  ///< the best point we saw; the start if nothing could be evaluated
    Evaluation best;
    double violation = 0;
    bool is_feasible = false;
    MinimizeStop stop = MinimizeStop::failed;
    std::string reason;  ///< one sentence
    int evaluations = 0, shrinks = 0;
    int failures = 0;  ///< evaluations without a value, or whose gradient failed
    /// Rows of the constraints that cannot be met together within the bounds, to first order at the point of least
    /// violation: without any one of them the others could. Empty: none found.
    std::vector<int> conflict;
    /// The values do not follow the gradient: along a short step they change by `slope_ratio` of its slope. `slope_of`
    /// is -1 for the objective, otherwise a row of the constraints.
    bool gradient_inconsistent = false;
    bool gradient_confirmed = false;  ///< the values followed it along steps that span all directions, or the descent
    double slope_ratio = std::numeric_limits<double>::quiet_NaN();
    int slope_of = -1;
    double slope_expected = std::numeric_limits<double>::quiet_NaN();  ///< change of this value by its gradient
    double slope_found = std::numeric_limits<double>::quiet_NaN();     ///< and by its values
    std::string slope_where;                                           ///< along which step, in words
    int confirmations = 0;        ///< evaluations that only served to confirm the gradient
    double noise = 0;             ///< of the objective, standard deviation; 0: not known
    double largest_gradient = 0;  ///< of this search and those before
    int active_bounds = 0;        ///< variables that a bound keeps from a better value (without gradients: at a bound)
    bool is_flat = false;         ///< all evaluations gave the same objective, or its gradient is zero at a start
    double radius = 0;            ///< sqp, model: of the trust region at the end
    Eigen::MatrixXd hessian;      ///< sqp, model: model of the Lagrangian's Hessian at the end, n x n; empty: none
    Eigen::VectorXd last_x;       ///< sqp: the last point that was differentiated, model: the best; empty: none
    Evaluation last;              ///< there, with gradients; model: by its models
    /// sqp with a cheap program: by how much a change of its values is multiplied; empty: there is none.
    Eigen::VectorXd low_fidelity_scale;
    /// What its steps have gained, as a share of what they were expected to gain. NaN: there was none.
    double low_fidelity_kept = std::numeric_limits<double>::quiet_NaN();
    Eigen::MatrixXd gradient_error;  ///< sqp: columns, by which the gradient of `best` may be off; empty: none
};

}  // namespace strake
