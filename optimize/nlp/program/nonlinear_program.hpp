#pragma once
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// A nonlinear program: an objective to minimize under constraints.
namespace strake {

/// Conditions on a step d that are not constraints: values + slopes.d <= 0 keeps the point within a limit, to first
/// order.
struct StepLimits {
    Eigen::VectorXd values;
    Eigen::MatrixXd slopes;  ///< rows x variables
};

/// Values at one x. Constraints are scaled: inequalities g <= 0 first, then equalities h = 0.
struct Evaluation {
    double objective = std::numeric_limits<double>::quiet_NaN();
    Eigen::VectorXd constraints;
    Eigen::VectorXd gradient;  ///< empty until differentiated
    Eigen::MatrixXd jacobian;  ///< constraints x variables
    std::string failure;       ///< not empty: there is no value, and why
    bool is_fatal = false;     ///< with a failure: the search ends instead of shrinking the step
    /// With a failure: the way to this x failed rather than x itself (a solve that did not converge from its start),
    /// and other points next to x may have values.
    bool is_of_step = false;
    bool is_partly_guessed = false;  ///< the gradient: not all of its differences were evaluated
    StepLimits limits;               ///< near x, once differentiated: of a program that is `within` a limit
};

/// The known part of the gradient at the start of a program with differences.
struct StartGradient {
    Eigen::VectorXd gradient;
    Eigen::MatrixXd jacobian;
    Eigen::MatrixXd unknown_directions;  ///< n x k: the slopes along these are not known yet
    Eigen::MatrixXd gradient_error;      ///< columns: gradients by which the known part may be off; empty: none
};

/// How gradients are computed from values.
struct Differences {
    double step = 1e-4;      ///< in the variables of the program, > 0: well above the noise of the values
    bool central = false;    ///< twice the evaluations, error h^2 instead of h
    bool objective = true;   ///< false: `differentiate` gives its gradient
    std::vector<char> rows;  ///< per constraint: 0, `differentiate` gives its gradient; empty: differences for all
    bool missing = false;    ///< also for single entries that `differentiate` leaves NaN
    /// > step: after a whole gradient the noise of the values is looked for, and where they carry more than the step
    /// bears it becomes longer, up to this; 0: the step stays as it is.
    double max_step = 0;
    /// Told the new step. May be empty.
    std::function<void(double step)> on_step;
};

struct NonlinearProgram;

/// What stands for a value of an expensive program in its cheap one.
enum class LowFidelityValue {
    same,         ///< the value itself
    approximate,  ///< another model of it: its scale, too, may be another one
    none          ///< nothing: zero
};

/// A cheap program beside an expensive one.
struct LowFidelity {
    /// The same variables, bounds, constraints and limits, its values cheap, with `differentiate` or differences of its
    /// own. Evaluated beside the expensive one, as often as it takes.
    std::shared_ptr<const NonlinearProgram> program;
    std::vector<LowFidelityValue> values;  ///< objective first, then constraints
    /// Per value, once the start of the expensive program is evaluated: by how much a change of the cheap one is
    /// multiplied at first. May be empty: 1.
    std::function<Eigen::VectorXd()> first_scale;
};

/// A point whose values are known before the search.
struct KnownPoint {
    Eigen::VectorXd x;
    Evaluation evaluation;
};

/// What a mirror image makes of changes of the variables, n x n both, symmetric: mean products of what one variable
/// moves with what another one does (`motion`), and with its mirror image (`image`). Values need not know of it.
struct MirrorImage {
    Eigen::MatrixXd motion, image;
    bool holds = false;  ///< a search before has found all values to be the same, and the limit of evaluations knows it
    std::function<void(bool)> found;  ///< told whether they are the same here
};

/// With a second curvature minima of models are sought in all variables, not in directions to points: some 0.4 s each
/// with 200 of both.
inline constexpr int max_variables_with_curvature = 100;

struct NonlinearProgram {
    Eigen::VectorXd start, lower, upper;
    Eigen::VectorXd lower_of_starts, upper_of_starts;  ///< where random ones are drawn; empty: within the bounds
    int num_inequalities = 0, num_equalities = 0;
    std::function<Evaluation(const Eigen::VectorXd& x)> evaluate;
    /// Adds the gradients to the last evaluation, which was at this x. Local gradient-free methods never call it,
    /// global ones for the polish at their end. Empty: differences.
    std::function<void(const Eigen::VectorXd& x, Evaluation& evaluation)> differentiate;
    /// Called with the points that will be evaluated next, in this order, where they are known in advance: all of a
    /// gradient by differences. May be empty.
    std::function<void(const std::vector<Eigen::VectorXd>& points)> expect;
    /// The point that is evaluated in place of x: x, or where that is beyond a limit that is no constraint a point near
    /// it that is within. Not asked for points of differences. May be empty.
    std::function<Eigen::VectorXd(const Eigen::VectorXd& x)> within;
    /// False: `evaluate` fails at x, which is told without what is expensive. May be empty. Used by model.
    std::function<bool(const Eigen::VectorXd& x)> is_defined;
    /// Why `evaluate` fails at x on whatever way it is reached, told likewise; no words: it may not. May be empty. Used
    /// by sqp and model, which do not evaluate there.
    std::function<std::string(const Eigen::VectorXd& x)> refusal;
    /// Of a step to a point beyond such a limit: conditions on steps from where it begins, which is within. No rows:
    /// the step ends within. May be empty. Used by sqp and model.
    std::function<StepLimits(const Eigen::VectorXd& from, const Eigen::VectorXd& to)> beyond;
    /// Gradients that differences give, in place of those of `differentiate` (if there is one).
    std::optional<Differences> differences;
    /// n x n, positive definite: the size of a step d is sqrt(d.metric.d), about 1 for the largest reasonable one.
    /// Empty: the identity.
    Eigen::MatrixXd metric;
    /// n x n, positive semidefinite: curvatures of values are likely the metric times one factor plus this times
    /// another, which models fit. Empty: the metric alone. Used by model, up to `max_variables_with_curvature`.
    Eigen::MatrixXd second_curvature;
    /// Where values are the same for a design and its mirror image, models search what is symmetric about the start
    /// alone. Used by model.
    std::vector<MirrorImage> mirror_images;
    /// The metric at x times d: near buckling some directions become long. May be empty, and may return an empty
    /// vector. Cheap compared with an evaluation. Used by sqp.
    std::function<Eigen::VectorXd(const Eigen::VectorXd& x, const Eigen::VectorXd& d)> present_metric;
    /// n x n, positive definite: an estimate of the Lagrangian's Hessian at the start. Empty: none. Used by sqp.
    Eigen::MatrixXd hessian;
    /// The part of `hessian`, positive semidefinite, whose shape is known and whose size is a guess. Empty: none.
    Eigen::MatrixXd guessed;
    /// Where differences give the gradient. Used by sqp.
    std::optional<StartGradient> start_gradient;
    /// Its optimum, corrected by what the values of this program show, is where the search looks next. Used by sqp.
    std::optional<LowFidelity> low_fidelity;
    /// Points beside the start that are known already; asked for once the start has been evaluated. May be empty. Used
    /// by model.
    std::function<std::vector<KnownPoint>()> known;
};

}  // namespace strake
