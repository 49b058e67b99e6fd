#include "optimize/nlp/minimizer.hpp"

#include "optimize/nlp/minimize_once.hpp"
#include "optimize/nlp/multistart.hpp"

namespace strake {

MinimizeResult minimize(const NonlinearProgram& program, const MinimizeOptions& options) {
    validate(program, options);
    return options.starts > 1 ? minimize_from_starts(program, options) : minimize_once(program, options);
}

}  // namespace strake
