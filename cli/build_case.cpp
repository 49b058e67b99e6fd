#include "cli/build_case.hpp"

#include "cli/commands.hpp"
#include "cli/signals.hpp"

#include <fmt/core.h>

#include <cstring>

namespace strake::cli {
namespace {

[[noreturn]] void end() {
    fmt::print(stderr, "strake: interrupted by SIG{} while remeshing; nothing is written\n",
               ::sigabbrev_np(stop_signal()));
    throw ExitStatus{interrupted};
}

}  // namespace

BuiltProblem build_case(Case the_case, Purpose purpose) {
    if (!the_case.remesh) return build_problem(the_case, purpose);  // takes no time
    watch_signals();
    the_case.stop_wanted = stop_wanted;
    try {
        BuiltProblem built = build_problem(the_case, purpose);
        leave_signals();
        if (stop_wanted()) end();
        return built;
    } catch (const Interrupted&) {
        end();
    }
}

}  // namespace strake::cli
