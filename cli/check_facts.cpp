#include "cli/check_facts.hpp"

#include "core/error.hpp"
#include "core/formats/vtp.hpp"
#include "core/patches/carried.hpp"
#include "core/wrap/wrap_map.hpp"
#include "optimize/problem/shell_setup.hpp"
#include "optimize/space/field_conditions.hpp"
#include "optimize/space/motion_limit.hpp"

#include <sys/resource.h>
#include <algorithm>
#include <chrono>
#include <cmath>

namespace strake::cli {
namespace {

/// Cost of an evaluation with gradients in rest solves: Newton steps reuse factors of previous designs. Between 1.5 and
/// 4 on the examples; the estimate is printed with "about".
constexpr double solves_each = 2.5;

/// Of the elastic surface. @param adjacent of the surface
std::vector<HeldPart> held_parts(const BuiltProblem& built, const Adjacency& adjacent) {
    const Problem& problem = built.problem;
    const std::vector<int> part =
        edge_components(elastic_surface(problem), problem.wrap ? problem.wrap->adjacent() : adjacent);
    std::vector<HeldPart> parts(
        part.empty() ? 0 : 1 + static_cast<std::size_t>(*std::max_element(part.begin(), part.end())));
    std::vector<char> is_fixed(part.size(), 0);
    const std::vector<int> pin = shell_setup(problem).options.pin;
    for (std::size_t t = 0; t < part.size(); ++t) {
        HeldPart& one = parts[static_cast<std::size_t>(part[t])];
        ++one.triangles;
        one.held += !pin.empty() && pin[t] != free_prism;
    }
    for (const RegionTriangles& region : built.regions)
        for (const int t : problem.wrap ? problem.wrap->carried(region.triangles) : region.triangles) {
            auto& by = parts[static_cast<std::size_t>(part[static_cast<std::size_t>(t)])].by;
            if (!pin.empty() && pin[static_cast<std::size_t>(t)] != free_prism &&
                std::find(by.begin(), by.end(), region.name) == by.end())
                by.push_back(region.name);
        }
    return parts;
}

double resident_bytes() {
    struct rusage used {};
    ::getrusage(RUSAGE_SELF, &used);
    return 1024.0 * static_cast<double>(used.ru_maxrss);
}

/// The displacement by each variable at x = 1, and which vertices no variable moves.
void write_modes(const std::string& file, const Problem& problem, const SpaceFacts& facts, std::vector<Field> fields) {
    std::vector<int> moves(facts.moves.begin(), facts.moves.end());
    fields.push_back({"moves", moves});
    const PatchLevel& level = problem.tree.levels[static_cast<std::size_t>(facts.level)];
    write_vtp(file, problem.surface, fields,
              {{"patch", problem.wrap ? carried(level.label, problem.wrap->wrap_triangle()) : level.label}});
}

/// The wrap, its patches and what of it is held.
void write_wrap(const std::string& file, const Problem& problem) {
    if (!problem.wrap) throw InvalidInput("--wrap: the case has no wrap (strake explain wrap)");
    std::vector<Field> cells;
    for (std::size_t k = 1; k < problem.tree.levels.size(); ++k)
        cells.push_back({text("patch_level_", k), problem.tree.levels[k].label});
    std::vector<int> held(static_cast<std::size_t>(problem.wrap->mesh().num_triangles()), 0);
    for (const int t : problem.supports) held[static_cast<std::size_t>(t)] = 1;
    cells.push_back({"held", held});
    write_vtp(file, problem.wrap->mesh(), {}, cells);
}

RunCost cost_of(const Problem& problem, double rest_seconds, double measured_seconds) {
    RunCost cost;
    cost.evaluations = problem.optimize.max_evaluations;
    cost.seconds_each = solves_each * rest_seconds + measured_seconds;
    for (const Quantity& quantity : problem.quantities)
        if (!quantity.program.empty()) cost.programs.push_back(quantity.names.front());
    cost.memory_bytes = 1.2 * resident_bytes();
    return cost;
}

/// Evaluates the start without programs. @return the seconds its quantities took.
double evaluate_start(const Problem& problem, const std::shared_ptr<const RestFacts>& rest, const DesignSpace& space,
                      CheckFacts& facts) {
    const Problem free = without_programs(problem);
    for (const Constraint& c : problem.constraints)
        if (std::none_of(free.constraints.begin(), free.constraints.end(),
                         [&](const Constraint& other) { return other.quantity == c.quantity; }))
            facts.unknown.push_back(c.quantity);
    if (free.quantities.empty()) return 0;
    facts.start = check_start(free, rest, space);
    double seconds = 0;
    for (const auto& quantity : facts.start->quantities) seconds += quantity.seconds;
    return seconds;
}

void add_border(const RestFacts& rest, const Adjacency& adjacent, const std::vector<char>& held,
                const Variable& variable, const Points& dv, BorderFacts& border) {
    const double turn = border_turn(rest, adjacent, held, dv, border.move * rest.diagonal).degrees;
    if (turn > std::max(border.by_fields, border.by_patches)) border.variable = variable.name;
    double& most = variable.kind == VariableKind::field ? border.by_fields : border.by_patches;
    most = std::max(most, turn);
}

}  // namespace

CheckFacts check_facts(const BuiltProblem& built, const CheckWishes& wishes) {
    const Problem& problem = built.problem;
    CheckFacts facts;
    if (!wishes.wrap.empty()) write_wrap(wishes.wrap, problem);
    facts.health = checkup(problem.surface);
    facts.parts = held_parts(built, facts.health.adjacent);
    const bool is_search = !problem.objective.empty() || !problem.fit.empty();
    const int levels = static_cast<int>(problem.tree.levels.size()) - 1;
    if (is_search && (wishes.level < 1 || wishes.level > levels))
        throw InvalidInput(text("--level ", wishes.level, ": the case has ",
                                levels > 1 ? text("levels 1 to ", levels) : "only level 1"));
    if (!is_search && !wishes.modes.empty())
        throw InvalidInput("--modes: the case has no design variables: it states neither objective nor fit");
    if (wishes.quick || !is_search) return facts;
    const auto rest = rest_facts(problem);
    const DesignSpace space = design_space(rest, wishes.level);
    std::vector<Field> modes;
    const bool wants_modes = !wishes.modes.empty();
    const std::vector<char> held = pinned_triangles(*rest);
    const Adjacency of_surface = rest->wrap ? adjacency(rest->surface) : rest->adjacent;
    if (!problem.fixed.empty()) {
        const Parameters& p = problem.parameters;
        facts.border.emplace().is_smooth = p.keeps_smooth_border;
        facts.border->is_kept = limits_border(p) && limits_motion(problem.fit.empty() ? p : with_stated_limit(p));
    }
    facts.space = space_facts(space, [&](const Variable& variable, const Points& dv) {
        if (facts.border) add_border(*rest, of_surface, held, variable, dv, *facts.border);
        if (wants_modes) modes.push_back({variable.name, dv});
    });
    if (wants_modes) write_modes(wishes.modes, problem, *facts.space, std::move(modes));
    if (space.size() == 0) return facts;
    facts.can_make = capability(rest, field_conditions(problem));
    const double seconds = evaluate_start(problem, rest, space, facts);
    facts.cost = cost_of(problem, facts.space->rest_seconds, seconds);
    return facts;
}

}  // namespace strake::cli
