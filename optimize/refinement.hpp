#pragma once
#include "optimize/design_space.hpp"

/// Where to refine: the gradient that the children of every patch would have is known from one adjoint solve before
/// they exist (DESIGN sections 4 and 6).
namespace strake {

/// What splitting a patch (or patches that are tied) promises.
struct SplitPromise {
    std::vector<int> patches;  ///< ids in the front
    std::string names;
    int new_variables = 0;
    double promise = 0;  ///< by sensitivity: expected decrease of the objective (or its Lagrangian); by gradient:
                         ///< integral of |dJ/dv| over the patches
    bool chosen = false;
};

struct RefinementPlan {
    Front front;                         ///< of the next level
    std::vector<SplitPromise> promises;  ///< falling
    int variables_before = 0, variables_after = 0;
    double promised = 0, chosen = 0;  ///< sums over all and over the chosen
    int rounds = 1;                   ///< levels of the tree that were passed at once
    std::string words() const;        ///< the decision with its numbers, one line
};

/// What is known at a design of a level.
struct DesignFacts {
    const DesignSpace& space;
    const Eigen::VectorXd& x;
    const ShellSensitivities& lagrangian;  ///< of objective + multipliers * constraints at x, minimized
    double curvature = 1;  ///< of the Lagrangian over the metric: the mean eigenvalue of its Hessian model
    const Points& dJ_dv;   ///< of the objective, n x 3
};

/// The children of all patches of a space that have parts: their variables, metric and prolongation.
struct Prospect {
    InheritedSpace children;
    std::vector<int> parts;  ///< per patch of the space
};
/// None where no patch has parts. Cost: the responses at rest that are not known yet.
std::optional<Prospect> prospect(const DesignSpace& space, const Eigen::VectorXd& x);

/// What splitting each patch promises, falling; with g the gradient and M the metric of all children of a patch and P
/// the prolongation of its variables, the expected decrease is
/// (g.M^-1.g - P^T g.(P^T M P)^-1.P^T g) / (2 curvature): what the details add to what the patch itself could still do.
/// `SplitRule::gradient` takes the integral of |dJ/dv| over the patch instead (paper, IV).
std::vector<SplitPromise> split_promises(const DesignFacts& facts, const Prospect& children);

/// Chooses the patches that promise most: those that together hold `parameters.split_share` of all, as long as the
/// variables grow by no more than `parameters.growth`; always at least one. Where the parts of parts promise more than
/// half of all that the new variables could do, these are split at once: a level without a step of its own would be
/// wasted.
/// @return an empty list of promises where no patch of the front has parts.
RefinementPlan plan_refinement(const DesignFacts& facts);

/// Sum of weight * sensitivities, over those that count for design variables.
ShellSensitivities weighted_sum(const std::vector<ShellSensitivities>& all, const Eigen::VectorXd& weight);

/// H of a child level in its own variables from H of its parent: on what the parent could do, what the parent knew; on
/// the rest (orthogonal in the metric) curvature * metric. All matrices positive definite; `prolongation` child x
/// parent.
Eigen::MatrixXd carried_hessian(const Eigen::MatrixXd& parent_hessian, const Eigen::MatrixXd& prolongation,
                                const Eigen::MatrixXd& child_metric, double curvature);

/// tr((P^T M P)^-1 H) / n.
double mean_curvature(const Eigen::MatrixXd& hessian, const Eigen::MatrixXd& metric);

}  // namespace strake
