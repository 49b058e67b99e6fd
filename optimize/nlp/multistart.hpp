#pragma once
#include "optimize/nlp/program/minimize_options.hpp"

/// Several starts. Internal.
namespace strake {

/// Like `minimize`, from each of `options.starts` points: the given one, then uniformly random ones within the bounds
/// by `options.seed`. Each may spend an equal part of the remaining evaluations (and seconds); what one saves goes to
/// the later ones. Returns the best feasible result (while none is feasible the least violation), with the counts of
/// all. on_step's `is_best` is over all starts. Ends early at a fatal failure or on request.
MinimizeResult minimize_from_starts(const NonlinearProgram& program, const MinimizeOptions& options);

/// a is better than b: it has a value and b none, is feasible and b is not, is lower where both are feasible, else of
/// less violation.
bool is_better(const MinimizeResult& a, const MinimizeResult& b);

/// Point `number` >= 1 of the random ones. Fixed variables stay.
Eigen::VectorXd random_start(const NonlinearProgram& program, unsigned seed, int number);

}  // namespace strake
