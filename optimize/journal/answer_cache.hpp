#pragma once
#include "objectives/quantity/quantity.hpp"

/// Answers of programs, shared by runs: a file each in the folder `Quantity::cache`, named by the hash of the surface,
/// the parameters, what is wanted, and `Quantity::cache_key`. Files are written whole or not at all, and runs
/// may share a folder at any time; each holds what it was asked and a check sum, and counts only if both are right.
namespace strake {

/// What the quantity answers: from the cache, with a remark that ends in "is taken from the cache", else by its
/// program. Failures are not kept. A damaged file is reported in a remark and replaced; so is a folder that cannot be
/// written. @pre the request has its surface's hash. @throws what `evaluate` throws.
QuantityResult cached_answer(const Quantity& quantity, const QuantityRequest& request);

}  // namespace strake
