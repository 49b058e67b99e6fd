#pragma once
#include "optimize/evaluate/shape_solver.hpp"

/// Designs whose shapes keep to the motion limit (optimize/space/motion_limit.hpp). Internal to the evaluator.
///
/// Shapes are what is limited, and designs are what a search knows: the derivative of each condition by the design
/// comes from one adjoint solve at the shape, whatever the variables are.
namespace strake {

/// Conditions on the change of a design, to first order: values + slopes.(change of x) <= 0 within the limit, and where
/// no edge folds.
struct MotionConditions {
    std::vector<MotionLimit::Row> rows;
    std::vector<EdgeFolds::Row> folds;
    std::vector<ShellSensitivities> sensitivities;  ///< of `values`
    /// Of the rows, over `MotionLimit::reference`; then of the folds, how much more than `EdgeFolds::Angles::aimed`,
    /// radians.
    Eigen::VectorXd values;
    Eigen::MatrixXd slopes;  ///< values x variables
    Eigen::Index num_rows() const { return static_cast<Eigen::Index>(rows.size()); }
};

/// The limit of a problem, about its datum. None where it has none. @param poses of the datum, where it had to be
/// solved for. @throws SolverError with the reason where the given loads and strains have no equilibrium; Interrupted.
MotionLimit motion_limit(const Problem& problem, const std::shared_ptr<const RestFacts>& rest,
                         const std::function<bool()>& stop_wanted, std::optional<Poses>& poses);

/// Conditions of vertices that use at least `min_used` of their limit at x, and of edges that nearly fold; none where
/// x has no equilibrium. Cost: one back-substitution for each, at most 24 and 12, and 24 of a border that is kept.
MotionConditions motion_conditions(ShapeSolver& solver, const Eigen::VectorXd& x, double min_used,
                                   const EdgeFolds::Angles& angles);

/// The same on steps from where no edge is folded. @param way from there to where the conditions were taken; empty: it
/// is there
MotionConditions on_steps(MotionConditions at, const Eigen::VectorXd& way = {});

/// The shape of x, which has these vertices, keeps `slack` of the limit, and no edge of it is above `angle` (degrees).
bool is_inside(const ShapeSolver& solver, const Points& vertices, double slack, double angle);

/// x, or where its shape does not keep `slack` of the limit, or it or its fields fold (fold_conditions.hpp), a design
/// near it whose shape does: by shortest steps in the response metric onto the conditions of the worst vertices and
/// triangles, or where these do not lead inside the last such design on the way from `inside` to x. x itself, too,
/// where it has no equilibrium.
/// @param inside a design within the limit; empty: none is known. @param angle degrees that no edge of x may be above
Eigen::VectorXd moved_inside(ShapeSolver& solver, const Eigen::VectorXd& x, const Eigen::VectorXd& inside, double slack,
                             double angle = EdgeFolds::kept);

}  // namespace strake
