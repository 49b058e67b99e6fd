#pragma once
#include "optimize/run/run_records.hpp"

/// What samples say of their values. Internal to `sample`.
namespace strake {

/// Fills ranges, main and total effects, and remarks, from the table.
/// Effects are those of a Gaussian process of each value over all designs, or of a part of them, spread over the table,
/// where all are too many (said in a remark): 500, fewer beyond 60 variables.
void learn(const Problem& problem, const DesignSpace& space, SampleSummary& samples);

}  // namespace strake
