#pragma once
#include "optimize/run/run_records.hpp"

/// Designs spread over the space of the first level, evaluated as a run evaluates them: what a search by models, a user
/// or another program can learn from.
namespace strake {

class Journal;

/// Evaluates the start and `max_evaluations` - 1 designs around it (`problem.sample`), or those of `problem.table`,
/// whose values are taken instead of calling the quantities that give them.
/// Parameters are spread evenly between their bounds. The shape goes from the start in directions spread evenly in the
/// coordinates that the response metric whitens, over a share of the way to the motion limit (without one: to size 1 in
/// the metric) spread as in a ball of at most three dimensions: in one of many, nearly all points are at the border.
/// Failing designs that do not end a run are rows without values. Results do not depend on `parallel`. A Sobol'
/// sequence goes on when the limit of evaluations is raised; a Latin hypercube ends with the limit that it began with.
/// Status `sampled` once all designs are evaluated; `RunResult::samples` has the table and the main effects.
/// @param journal as for `optimize`.
/// @throws ReplayMismatch; InvalidInput as `optimize` and where nothing can be varied or relative limits have no start.
RunResult sample(const Problem& problem, const RunEvents& events = {}, Journal* journal = nullptr);

}  // namespace strake
