#pragma once
#include <pybind11/pybind11.h>

#include <stdexcept>

namespace strake::python {

/// Becomes strake.EvaluationFailed.
struct EvaluationFailed : std::runtime_error {
    using runtime_error::runtime_error;
};
bool is_evaluation_failed(const pybind11::error_already_set& error);

}  // namespace strake::python
