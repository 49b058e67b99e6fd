#pragma once
#include "optimize/problem/problem.hpp"

/// Test deformations of a proposed case, before anybody relies on it.
namespace strake {

struct Trial {
    int tried = 0, failed = 0;
    std::string reason;           ///< of the first failure
    bool is_out_of_time = false;  ///< ended before all were tried
    double seconds = 0;
    /// At most a sixth of what was tried fails, and something was tried.
    bool is_sound() const { return tried > 0 && 6 * failed <= tried; }
};

/// Moves the surface by six shapes: three variables of the first level with shape variables, far from each other in
/// their list, each to x = 0.1 and -0.1, a tenth of the motion that one variable may make: a run begins with more. With
/// a wrap variables of patches. No quantity is asked. Ends with the failure that is one too many. A surface that cannot
/// be deformed at all is a failure in words, not an exception. `max_seconds` is looked at between iterations; then what
/// is not finished is not counted.
Trial try_deformations(Problem problem, double max_seconds);

}  // namespace strake
