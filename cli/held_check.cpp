#include "cli/held_check.hpp"
#include "core/error.hpp"

#include "core/primo/held.hpp"
#include "optimize/problem/shell_setup.hpp"

#include <algorithm>

namespace strake::cli {
namespace {

bool has_strains(const Problem& problem) {
    const auto& kinds = problem.parameters.kinds;
    return std::find(kinds.begin(), kinds.end(), VariableKind::strain) != kinds.end();
}

}  // namespace

std::vector<std::string> check_shell(const Case& the_case, const Problem& problem) {
    const ShellSetup setup = shell_setup(problem);
    if (!problem.has_shell) return setup.warnings;  // fields hold what is fixed, and need nothing that is
    const bool is_search = !problem.objective.empty() || !problem.fit.empty();
    if (is_search && has_strains(problem)) return setup.warnings;  // pinned strain patches hold, too
    const Eigen::VectorXd spring = setup.loads.spring.size() > 0
                                       ? setup.loads.spring
                                       : Eigen::VectorXd::Zero(elastic_surface(problem).num_vertices());
    try {
        check_held(rest_state(elastic_surface(problem), setup.options), spring);
    } catch (const UnheldPart& e) {
        throw UnheldPart(text(printable(the_case.file.string(), 400), ": ", e.what()));
    }
    return setup.warnings;
}

}  // namespace strake::cli
