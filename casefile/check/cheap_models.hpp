#pragma once
#include "casefile/model/case.hpp"
#include "casefile/yaml/diagnostics.hpp"

/// `quantities.*.low_fidelity`: which value stands for which.
namespace strake {

/// Adds an error, with its place, for each that is none: unknown names, values that depend on what they stand for, a
/// method that does not use them.
std::vector<CheapModel> cheap_models(const Case& the_case, Diagnostics& errors);

/// Quantities that are programs and that some cheap model is made of.
std::vector<const QuantityEntry*> cheap_programs(const Case& the_case, const std::vector<CheapModel>& models);

}  // namespace strake
