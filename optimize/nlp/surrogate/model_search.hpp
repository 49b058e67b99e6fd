#pragma once
#include "optimize/nlp/nlopt/restarts.hpp"

/// Search on models that learn from every evaluation, for few and expensive ones without gradients. Internal.
///
/// Objective and constraints have a Gaussian process each, in coordinates that the metric whitens, of the points next
/// to the best one: those of the search, and those that the program knows before it (`NonlinearProgram::known`). A step
/// of the search is a batch of points, proposed one after another with the means of those before believed (kriging
/// believer: Ginsbourger, Le Riche, Carraro 2010), so that they differ: minima of the objective's model under the
/// models of the constraints within half, the whole and twice the radius of a trust region, then minima of its lower
/// confidence bound. A batch is evaluated whole, and its answers are used in the order of proposal: results depend on
/// `MinimizeOptions::batch`, never on how many evaluations run at the same time. Steps stay on the side of a learned
/// border of failures (failure_border.hpp).
namespace strake {

/// Starts at the guard's best point, which is evaluated; leaves the best in the guard.
/// @throws nlopt::forced_stop never: `guard.cause` of the end is turned into `stop`.
SearchEnd minimize_by_model(Guard& guard);

}  // namespace strake
