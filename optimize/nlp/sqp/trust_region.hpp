#pragma once

/// Every threshold of the steps of sqp, with its reason; `SqpSearch::resize` changes the radius by them, and
/// `MinimizeOptions::first_step` is the first one, `max_step` the largest. Internal.
namespace strake {

/// Lengths are in the program's metric, in which 1 is the largest reasonable step.
struct TrustRegionOptions {
    // The radius.
    double radius_slack = 1.01;           ///< a free step this much longer than the radius is still accepted
    double min_length = 0.9;              ///< of the radius, of a limited step: an exact length is not worth its solves
    double min_model_step = 1e-3;         ///< of a step of 1: shorter ones do not measure what a violation costs
    int max_damping_solves = 30;          ///< bisections of the logarithm of the damping
    double min_damping = 1e-6;            ///< of the mean curvature: less does not change a step
    double max_damping = 1e10;            ///< of the mean curvature: more leaves no step
    double growth = 2;                    ///< of the radius after a good step
    double exact_growth = 4;              ///< where the model predicted the decrease within `exact_share`
    double exact_share = 0.1;             ///< of the predicted decrease
    double growth_after_failure = 1.4;    ///< once an evaluation has failed: the next failure costs an evaluation
    double min_cut = 0.1, max_cut = 0.5;  ///< of the radius, towards the minimum of the parabola through the values
    double failure_cut = 0.5;             ///< of the radius after the first failure in a row
    double repeated_failure_cut = 0.25;   ///< after further ones: a failing region is rarely a step wide

    // Whether a step is accepted, by its actual over its predicted decrease.
    double acceptable = 1e-4;  ///< less counts as no decrease
    double poor = 0.25;        ///< less shrinks the radius
    double good = 0.7;         ///< more may enlarge it

    // The merit function.
    double tightening = 0.5;          ///< of the constraint tolerance: round-off must not leave the last point outside
    double penalty_share = 0.7;       ///< of the violation's decrease that may pay for a rising objective
    double penalty_factor = 1.5;      ///< times the largest multiplier: exact penalties need more than 1
    double first_penalty_factor = 2;  ///< the first multipliers are estimates

    // Second-order corrections.
    double max_correction = 0.5;  ///< of the step: more is no matter of second order
    int max_corrections = 2;      ///< of a step that misses the constraints, before an expensive gradient is paid

    // Extrapolation along a step, before an expensive gradient is paid.
    double min_extrapolation = 1.5;  ///< times the step: less is not worth an evaluation
    double max_extrapolation = 8;    ///< times the step: the parabola through two values says no more
    int max_extrapolations = 3;

    // The metric where the search is.
    int max_metric_updates = 4;      ///< before a step is taken: each costs a linear solve of the shell
    double min_metric_change = 1.5;  ///< a step this much longer than the metric said is computed again
    double min_length_share = 0.1;   ///< of the squared radius: shorter steps have no say

    // Limits that are no constraints.
    int max_limit_rounds = 3;  ///< of a step beyond one, each with what is known there: the last may be moved inside

    // Curvature.
    double min_curvature_share = 0.2;   ///< Powell's damping of the BFGS update
    int max_damped_cuts = 30;           ///< halvings of a damped update that adds more than it replaces
    double min_slope_share = 1e-3;      ///< of the objective's gradient: a first slope that cancels sets no scale
    double rounding_share = 1e-3;       ///< of the objective tolerance: less curvature may be rounding
    double constraint_rounding = 0.01;  ///< of the constraint tolerance: the same

    double telling_change = 1e-3;  ///< of all that has been gained: the shape of a smaller step says little

    // The end.
    int max_small_decreases = 2;      ///< decreases below the tolerance in a row that mean convergence
    int max_stalled_steps = 4;        ///< the same while constraints are violated, where steps are less regular
    double stalled_violation = 10;    ///< constraint tolerances: below, the merit is no longer mostly violation
    double stalled_decrease = 10;     ///< objective tolerances, of the merit
    double small_decrease = 0.1;      ///< of a tolerance that is relative to the objective (runs before 0.2)
    double unexpected_decrease = 10;  ///< tolerances: where small steps end a search that expects more, it has stalled
    int max_rejections = 12;          ///< in a row: the gradient does not predict the values
    int max_guessed_rejections = 2;   ///< in a row: the guessed part of the gradient may be the reason
    double min_step = 1e-12;          ///< rejected steps below it end the search
    int max_model_failures = 2;       ///< in a row, of the model's solver; the Hessian starts again in between
    int max_restorations = 3;         ///< evaluations kept for the way back onto the constraints
    double max_restoration_step = 0.5;  ///< a longer way back would leave what the search has found
    double handover_violation = 1e-3;   ///< below, a finer level may take over

    // Failures next to the best point.
    int refusals_by_border = 4;   ///< in a row: where no plane parts the shapes, a step short enough has one
    int max_refusals = 12;        ///< of shapes, in a row, on all levels: these cost no evaluation
    int steps_per_failures = 10;  ///< accepted steps that allow `max_failures` more: what fails by chance is no border
    int max_border_failures = 100;  ///< more in all than elsewhere where a border is known: it takes them to find it
    int max_border_failures_in_row = 32;   ///< more in a row
    int border_failures_per_variable = 4;  ///< more in a row, at most the above: a plane has as many unknowns
    double border_share = 1e-5;  ///< of the total decrease: a smaller expected decrease along a border ends the search
    double border_probes[2] = {0.6, 0.2};  ///< of the step without the border: what failed there may have been chance
    /// Least probability of a value, in standard deviations: below 0 a step is more likely to fail than not.
    double z_scores[3] = {0, 0.5, 1};
    double only_z_score = 0.3;       ///< above `max_z_score_variables`
    int max_z_score_variables = 20;  ///< above, solving the model costs more than what the choice gains
    int max_cut_rounds = 3;          ///< of a step under a cut that is linear about the step before
    double cut_accuracy = 0.05;      ///< of the z-score

    // Gradients by differences.
    int expensive_gradient = 6;        ///< variables: from here on a gradient costs more than what avoids it
    double max_gradient_change = 4;    ///< over a step, times what the model expects
    double paid_share = 0.9;           ///< of the gradient's squared error
    double max_paid_directions = 0.3;  ///< of all; an error spread over more is not worth a partial gradient
};

inline constexpr TrustRegionOptions trust_region;

}  // namespace strake
