#pragma once
#include "optimize/nlp/surrogate/local_models.hpp"

/// The next point to ask for, by models of a nonlinear program. Internal to the search by models.
namespace strake {

/// What limits the next point.
struct ProposalRegion {
    Eigen::VectorXd centre;         ///< z
    double radius = 0;              ///< about the centre, in z
    std::optional<FailureCut> cut;  ///< evaluations are expected to fail beyond it
    StepLimits limits;              ///< conditions on z - centre
    Eigen::VectorXd margin;         ///< that each inequality keeps, as constraints are scaled
    /// What is added to each constraint's mean at z: offset + tilt (z - centre).
    Eigen::VectorXd offset;
    Eigen::MatrixXd tilt;  ///< a row each; empty: none
    double correction(Eigen::Index row, const Eigen::VectorXd& z) const;
    bool is_beyond_border(const Eigen::VectorXd& x) const { return cut && cut->normal.dot(x) > cut->limit; }
    /// The meaning of earlier runs: minima are looked for in the variables.
    bool is_in_variables = false;
    static constexpr double reach = 1.2;  ///< radii: what exact limits move farther is another proposal
};

/// Where the lower confidence bound m(z) - `deviations` s(z) of the objective is least within the region and the
/// bounds, under the means of the constraints; m and s are the model's mean and standard deviation. Where the
/// constraints cannot be met, their violation is least. By sqp, from `from`.
Eigen::VectorXd model_minimum(const NonlinearProgram& program, const SampledPoints& points, const LocalModels& models,
                              const ProposalRegion& region, double deviations, const Eigen::VectorXd& from);

}  // namespace strake
