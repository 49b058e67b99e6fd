#pragma once
#include "bench/coarse_to_fine/problems.hpp"

#include <map>
#include <memory>

/// What a solver of one's own does to values: noise, and designs that fail.
namespace strake::evidence {

struct Disturbance {
    double noise = 0;     ///< standard deviation of the objective's values, in its unit, >= 0
    double failures = 0;  ///< share of the designs that fail, in [0, 1); not the first
    unsigned seed = 1;
};

/// Per value that was handed on the one that is true.
using Truth = std::map<double, double>;

/// The same with values as such a solver gives them: the same for the same shape. @param truth is filled as designs are
/// evaluated.
EvidenceProblem disturbed(EvidenceProblem evidence, const Disturbance& disturbance, std::shared_ptr<Truth> truth);

}  // namespace strake::evidence
