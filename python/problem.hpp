#pragma once
#include "cases/case.hpp"
#include "optimize/problem.hpp"
#include "python/bindings.hpp"

#include <exception>

namespace strake::python {

/// A problem as Python fills it in, or as a case file has it.
struct PythonProblem {
    Problem problem;
    SurfacePointer surface;  ///< what `problem.surface` is, for views
    std::vector<std::string> warnings;
    /// The case file's, as long as the problem is what it states: what a folder of a run can hold.
    std::optional<Case> the_case;
    /// What a function of Python's has thrown during a run: the run ends, and it goes on from there.
    std::shared_ptr<std::exception_ptr> thrown = std::make_shared<std::exception_ptr>();
};

}  // namespace strake::python
