#pragma once
#include "optimize/nlp/program/guard.hpp"

/// Search by models that learn from every evaluation, for few and expensive ones without gradients. Internal.
///
/// Objective and constraints have a Gaussian process each, in coordinates that the metric whitens, of the points next
/// to the best one: those of the search, and those that the program knows before it (`NonlinearProgram::known`). A step
/// is a batch of points, proposed one after another with the means at those before taken for values (kriging believer:
/// Ginsbourger, Le Riche, Carraro 2010), so that they differ: minima of the objective's mean under those of the
/// constraints in trust regions of several radii, then minima of its lower confidence bound. A batch is evaluated
/// whole, and its answers are used in the order of proposal: results depend on `MinimizeOptions::batch`, never on how
/// many evaluations run at the same time. Steps stay on the side of a learned border of failures (failure_border.hpp).
/// Proposals that the program refuses without evaluating them are failures that cost nothing. Where there are equations
/// that only values tell, one of eight evaluations, and the last ones, lead back to them.
namespace strake {

struct ModelEnd {
    MinimizeStop stop = MinimizeStop::failed;
    std::string reason;
    int shrinks = 0;
    double radius = 0;  ///< of the trust region at the end
    double noise = 0;   ///< of the objective, standard deviation, by its model
    /// Where the search stood, with gradients by the models, and the Hessian of their Lagrangian by all variables, its
    /// curvatures in the metric no less than a tenth of their mean. Empty: no model was made.
    Eigen::VectorXd x;
    Evaluation at;
    Eigen::MatrixXd hessian;
};

/// Starts at the guard's best point, which is evaluated; leaves the best in the guard.
/// @throws nlopt::forced_stop never: `guard.cause` of the end is turned into `stop`.
ModelEnd minimize_by_model(Guard& guard);

}  // namespace strake
