#include "casefile/build/problem_builder.hpp"
#include "optimize/run/known_designs.hpp"

namespace strake {

BuiltProblem ProblemBuilder::build() {
    read_start();
    make_wrap();
    at(case_.parameters_place, "parameters: ", [&] { build_tree(); });
    read_stored();
    errors_.throw_if_any();
    evaluate_regions();
    errors_.throw_if_any();
    set_wrap();
    errors_.throw_if_any();
    Problem& problem = out_.problem;
    problem.name = case_.name;
    problem.symmetry = case_.symmetry;
    problem.has_shell = case_.has_shell;
    problem.couple_nonmanifold = case_.couple_nonmanifold;
    problem.solver = case_.solver;
    if (problem.has_shell) set_heights();
    set_pins();
    set_attached();
    set_invariance();
    set_hold();
    set_parameters();
    errors_.throw_if_any();
    set_springs();
    set_twists();
    if (!case_.loads.empty()) set_tractions();
    if (purpose_ != Purpose::deform) {
        set_goals();
        read_designs();
    }
    errors_.throw_if_any();
    problem.surface = std::move(start_.mesh);
    if (stored_) at(case_.start_place, "optimize.start_from: ", [&] { start_from(problem, stored_); });
    errors_.throw_if_any();
    if (stored_ && case_.fit.empty() && !case_.sample) {
        KnownDesigns known = known_designs(problem, *case_.start_from);
        problem.table = std::move(known.table);
        if (!known.why.empty()) out_.notes.push_back(known.why);
    }
    return std::move(out_);
}

RegionGround ProblemBuilder::ground() {
    wants_patches_ = true;
    read_start();
    make_wrap();
    at(case_.parameters_place, "parameters: ", [&] { build_tree(); });
    errors_.throw_if_any();
    PatchHierarchy tree = tree_on_surface();
    return {std::move(start_), std::move(tree), std::move(out_.notes), std::move(out_.warnings)};
}

BuiltProblem build_problem(const Case& the_case, Purpose purpose) { return ProblemBuilder(the_case, purpose).build(); }

RegionGround region_ground(const Case& the_case) { return ProblemBuilder(the_case, Purpose::any).ground(); }

}  // namespace strake
