#pragma once
#include "optimize/nlp/program/nonlinear_program.hpp"

/// Covariance matrix adaptation, as a comparator for few evaluations.
namespace strake::evidence {

/// Hansen, "The CMA evolution strategy: a tutorial" (2016), its defaults, in coordinates that the program's metric
/// whitens. Points are moved into the bounds; failures rank last, then what violates constraints, by how much.
/// @param step standard deviation at the start, in the metric.
void minimize_by_cma_es(const NonlinearProgram& program, int evaluations, unsigned seed, double step);

}  // namespace strake::evidence
