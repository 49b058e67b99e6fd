#pragma once
#include "optimize/space/design_space.hpp"

/// Designs whose displacement fields do not fold space: of a surface that fields (and changes of wings beside them)
/// move without a shell, the guard refuses designs whose map has a determinant below `ValidityGuard::min_determinant`
/// at a triangle. This is known before anything is evaluated, and so are its derivatives: searches keep to it as to a
/// limit instead of paying for what fails. Internal to the evaluator.
namespace strake {

/// Conditions on the change of a design, to first order: values + slopes.(change of x) <= 0 where nothing folds.
struct FoldConditions {
    Eigen::VectorXd values;  ///< the determinant that designs keep, minus that of a triangle
    Eigen::MatrixXd slopes;  ///< triangles x variables
};

/// Determinants that designs keep (a little more than what the guard asks for), that those moved there have, and that
/// steps aim at.
inline constexpr double kept_determinant = 0.06, moved_determinant = 0.0601, wanted_determinant = 0.07;

/// Fields move the surface, and no shell that stands on it does: there is none, or it stands on a wrap.
bool may_fold(const DesignSpace& space);

/// The map of x has less than this determinant at some triangle. False where it cannot fold.
bool is_folded(const DesignSpace& space, const Eigen::VectorXd& x, double determinant = kept_determinant);

/// Of triangles with a determinant below `below` at x, spread over the surface: the least first, at most 24. x itself
/// fulfils them where it does not fold.
FoldConditions fold_conditions(const DesignSpace& space, const Eigen::VectorXd& x, double below);

/// On the change from `from`, which does not fold, of triangles that would at `to`. A determinant is no linear
/// function: the slopes are those at `to`, corrected along the way (by Broyden's update, the least change of them) so
/// that the conditions are met at `from` and say at `to` what is true there.
FoldConditions fold_conditions_between(const DesignSpace& space, const Eigen::VectorXd& from,
                                       const Eigen::VectorXd& to);

}  // namespace strake
