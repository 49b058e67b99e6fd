#pragma once
#include "optimize/run/run_records.hpp"

/// Designs spread over the space of the first level, evaluated as a run evaluates them: what a search by models, a user
/// or another program can learn from.
namespace strake {

class Journal;

/// Evaluates the start and `max_evaluations` - 1 designs around it (`problem.sample`), or those of `problem.table`,
/// whose values are taken instead of calling the quantities that give them.
/// How they are spread: `SampleDesigns`. Every shape is within the motion limit, but those of a table are taken as they
/// are. Failing designs that do not end a run are rows without values. Results do not depend on `parallel`. A Sobol'
/// sequence goes on when the limit of evaluations is raised; a Latin hypercube and levels end with the limit that they
/// began with.
/// Status `sampled` once all designs are evaluated; `RunResult::samples` has the table and the main effects.
/// @param journal as for `optimize`.
/// @throws ReplayMismatch; InvalidInput as `optimize` and where nothing can be varied or relative limits have no start.
RunResult sample(const Problem& problem, const RunEvents& events = {}, Journal* journal = nullptr);

}  // namespace strake
