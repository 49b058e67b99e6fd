#pragma once
#include "optimize/space/design_space.hpp"

#include <Eigen/Cholesky>

/// Which patches to split (whether to at all: optimize/run/refinement_choice.hpp): the gradient that the
/// children of every patch would have is known from one adjoint solve before they exist (docs/theory-optimize.md).
namespace strake {

/// A patch of some front of the tree.
struct PatchPart {
    int triangle = 0;   ///< its first
    int triangles = 0;  ///< how many
};

/// The expected decrease by splitting a patch (or patches that are tied), or by a field more.
struct SplitDecrease {
    std::vector<int> patches;  ///< ids in the front, the last that is passed
    int field = -1;            ///< number in `Parameters::fields`; -1: patches are split
    std::string names;
    std::vector<int> variables;  ///< of the children
    /// Where patches are taken one by one: those that have variables then, and the patches of the children of which
    /// they are made.
    std::vector<PatchPart> parts{};
    std::vector<int> covered{};
    Eigen::MatrixXd directions{};  ///< of the variables, by those of the children; empty: they are `variables` of these
    int new_variables = 0;
    double decrease = 0;  ///< by sensitivity: expected decrease of the objective (or its Lagrangian) beyond what the
                          ///< splits before it give; by gradient: integral of |dJ/dv| over the patches
    bool chosen = false;
};

struct RefinementPlan {
    LevelSet next;                      ///< of the next level
    std::vector<SplitDecrease> splits;  ///< the chosen first, in their order
    int variables_before = 0, variables_after = 0;
    double expected = 0, chosen = 0;  ///< by all splits together, and by the chosen ones
    int depth = 1;                    ///< of the prospect: patches between are split on the way to the chosen ones
    int rounds = 1;                   ///< levels of the tree that were passed at once
    int fields_at_once = 0;           ///< by gradient, where no patch has finer parts: the next step of fields
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

/// The space can be refined: some patch has parts, patches are still to join the fields, or there are more fields.
bool has_finer(const DesignSpace& space);
/// All patches that have parts, split.
Front split_everywhere(const PatchHierarchy& tree, const Front& front);
/// The level below with everything refined.
LevelSet refined_everywhere(const DesignSpace& space);

/// The children of all patches of a space that have parts, and the fields that are offered (`offered_fields`):
/// variables, metric and prolongation.
struct Prospect {
    InheritedSpace children;
    bool takes_single_patches = false;  ///< `RestFacts::takes_single_patches`
    /// The space's own front, and those that are passed over: the patches of the last one are split.
    std::vector<Front> passed;
    std::vector<int> parts;             ///< per patch of the space
    std::vector<SplitDecrease> splits;  ///< those that are possible, without expected decreases
    Eigen::LLT<Eigen::MatrixXd> metric;
    Eigen::MatrixXd inherited;  ///< the prolongation, whitened by the metric
    Eigen::MatrixXd known;      ///< orthonormal columns: what the space itself can do, whitened by the metric
};
/// None where no patch has parts, and all fields are there. Cost: the responses at rest that are not known yet.
/// @param depth levels of the tree, >= 1: from 2 on parts of parts (of parts), as if there were none between; none
/// where they have no parts. Where patches are taken one by one, parts are of all depths: 1, with fields; 2, without
std::optional<Prospect> prospect(const DesignSpace& space, const Eigen::VectorXd& x, int depth = 1);

/// The expected decrease by all details together: with g the gradient and M the metric of all children and P the
/// prolongation, (g.M^-1.g - P^T g.(P^T M P)^-1.P^T g) / (2 curvature), what they add to what the space itself could
/// still do. Variables that a bound stops are excluded from P: their parts have bounds of their own.
double expected_decrease_of(const DesignFacts& facts, const Prospect& below);

/// What the details of all patches together are expected to do at a design.
struct Forecast {
    Prospect below;
    Eigen::VectorXd step;  ///< of the variables of all children
    double decrease = 0;   ///< that the metric expects of it
};
/// None where no patch has parts. @param depth see `prospect`
std::optional<Forecast> make_forecast(const DesignFacts& facts, int depth = 1);

/// Chooses the patches and fields with the largest expected decrease, one after the other: the split that adds most to
/// what the space and the splits before it can do (different patches often can do the same), until they hold
/// `parameters.marking_fraction` of what all would give, and then fields alone until 99 %, as long as the variables
/// grow by no more than `parameters.max_variable_ratio` and each split is expected to gain at least `min_per_variable`
/// for each of its new variables; always at least one. `SplitRule::gradient` takes the largest integral of |dJ/dv| over
/// the patch instead (paper, IV). Where the parts of parts are expected to gain more than half of all that the new
/// variables could do, these are split at once: a level without a step of its own would be wasted.
RefinementPlan plan_refinement(const DesignFacts& facts, const Forecast& forecast, double min_per_variable = 0);

/// H of a child level in its own variables from H of its parent: on what the parent could do, what the parent knew; on
/// the rest (orthogonal in the metric) curvature * metric. All matrices positive definite; `prolongation` child x
/// parent.
Eigen::MatrixXd carried_hessian(const Eigen::MatrixXd& parent_hessian, const Eigen::MatrixXd& prolongation,
                                const Eigen::MatrixXd& child_metric, double curvature);

/// Geometric mean of the eigenvalues of M^-1 H: few directions that are much stiffer than all others, as searches find
/// them, say little of the rest. Both positive definite.
double mean_curvature(const Eigen::MatrixXd& hessian, const Eigen::MatrixXd& metric);

}  // namespace strake
