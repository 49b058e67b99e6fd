#pragma once
#include "optimize/nlp/surrogate/local_models.hpp"

/// Along what a search by models takes its first steps. Internal.
namespace strake {

/// Orthonormal columns in z, of which a search takes one after another: along the variables in their order
/// (`MinimizeOptions::tries_in_order`), those first that no known point has moved yet; else spread evenly
/// (`latin_hypercube`), `MinimizeOptions::first_alone` before the others.
/// @param points the start first @param has_exact_limits these move steps a little along all axes
Eigen::MatrixXd first_directions(const Guard& guard, const SampledPoints& points, bool has_exact_limits);

}  // namespace strake
