#pragma once
#include "optimize/nlp/program/minimize_options.hpp"

namespace strake {

/// @throws InvalidInput: sizes, start outside bounds, a global method or several starts without finite bounds.
void validate(const NonlinearProgram& program, const MinimizeOptions& options);

/// Like `minimize`, from the program's own start only. @throws InvalidInput as `minimize` does.
MinimizeResult minimize_once(const NonlinearProgram& program, const MinimizeOptions& options);

}  // namespace strake
