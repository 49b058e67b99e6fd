#pragma once
#include "casefile/model/case.hpp"
#include "optimize/problem/problem.hpp"
#include "python/bindings.hpp"

#include <exception>

namespace strake::python {

/// A problem stated in Python or read from a case file.
struct PythonProblem {
    Problem problem;
    SurfacePointer surface;  ///< the same as `problem.surface`, for views
    std::vector<std::string> warnings;
    /// The case file, as long as the problem is unchanged: needed for a run folder.
    std::optional<Case> the_case;
    /// An exception of a Python function during a run: the run ends and raises it again.
    std::shared_ptr<std::exception_ptr> thrown = std::make_shared<std::exception_ptr>();
};

}  // namespace strake::python
