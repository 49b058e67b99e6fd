#include "cli/build_case.hpp"
#include "cli/detail.hpp"

#include "cli/commands.hpp"
#include "cli/say.hpp"
#include "cli/signals.hpp"

#include <fmt/core.h>

#include <cstring>
#include <utility>

namespace strake::cli {
namespace {

[[noreturn]] void end() {
    say("strake: interrupted by SIG{} while remeshing; nothing was written\n", ::sigabbrev_np(stop_signal()));
    throw ExitStatus{interrupted};
}

BuiltProblem logged(BuiltProblem built) {
    const Problem& problem = built.problem;
    std::string levels;
    for (std::size_t k = 1; k < problem.tree.levels.size(); ++k)
        levels += fmt::format("{}{}", k > 1 ? ", " : "", problem.tree.levels[k].patches.size());
    log_step(fmt::format("problem: {} vertices, {} triangles, {} of them fixed, patches per level: {}",
                         problem.surface.num_vertices(), problem.surface.num_triangles(), problem.fixed.size(),
                         levels.empty() ? "none" : levels));
    for (const Quantity& quantity : problem.quantities)
        log_step(fmt::format("quantity: {}{}", printable(joined(quantity.names), 400),
                             quantity.program.empty() ? "" : ", from program " + printable(quantity.program, 400)));
    return built;
}

}  // namespace

void add_set_option(CLI::App& command, std::vector<std::string>& settings) {
    // One argument each: the case file may follow.
    command
        .add_option(
            "--set", settings,
            "set a key of the case, for example optimize.budget.evaluations=20 or loads[0].traction='[0, 0, 1]'; "
            "may be repeated")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->take_all();
}

BuiltProblem build_case(Case the_case, Purpose purpose) {
    for (const std::string& note : the_case.notes) say("{}\n", note);
    log_step(fmt::format("building the problem of {}", printable(the_case.file.string(), 400)));
    if (!the_case.remesh) return logged(build_problem(the_case, purpose));  // too fast to interrupt
    watch_signals();
    the_case.stop_wanted = stop_wanted;
    try {
        BuiltProblem built = build_problem(the_case, purpose);
        leave_signals();
        if (stop_wanted()) end();
        return logged(std::move(built));
    } catch (const Interrupted&) {
        end();
    }
}

}  // namespace strake::cli
