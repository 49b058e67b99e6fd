#pragma once
#include "optimize/problem/problem.hpp"

/// Test deformations of a proposed case, before anybody relies on it.
namespace strake {

struct Trial {
    int tried = 0, failed = 0;
    std::string reason;         ///< of the first failure
    bool is_cut_short = false;  ///< ended by its maximum of work before all were tried
    double cpu_seconds = 0;     ///< of the process, for words; decides nothing
    /// Fewer than a tenth of what was tried fails, and something was tried.
    bool is_sound() const { return tried > 0 && 10 * failed < tried; }
};

/// Moves the surface by six shapes: three variables of patches of the first level that has any (with a wrap of the last
/// level; without a shell of fields), far from each other in their list, each to x = 0.1 and -0.1, a tenth of the
/// motion that one variable may make: a run begins with more. With a wrap also by all variables of patches at once, one
/// up and the next one down, by three tenths. No quantity is asked. Ends with the second failure. A surface that cannot
/// be deformed at all is a failure in words, not an exception.
/// @param max_work elastic triangles times iterations of the shell, looked at after each iteration; what is not
/// finished then is not counted. A count, so that neither the load of the machine nor its number of cores decides.
Trial try_deformations(Problem problem, double max_work);

}  // namespace strake
