#pragma once
#include "bench/coarse_to_fine/comparators.hpp"

/// One problem solved in one way, and what was seen on the way.
namespace strake::evidence {

enum class Solver {
    fields,  ///< `parameters.fields: auto`: displacement fields first, and without constraints `split: sensitivity`
    as_it_comes,  ///< a case that states no variables, of a program that gives values only: fields, then normal loads
    adaptive,     ///< coarse to fine, patches split by sensitivity
    uniform,      ///< coarse to fine, level by level of the tree
    finest,       ///< the last level alone
    ffd,          ///< Bezier box with about as many variables as `finest`
    box_12,       ///< with about 12 and 24 variables, as users set them for few evaluations
    box_24,
    cma_es_12,      ///< the first of these boxes by CMA-ES, whatever the method
    lattice_4x4x4,  ///< B-spline lattices as users set them
    lattice_8x4x2,
    filtered  ///< every vertex through a Helmholtz filter; not with sqp, whose models are dense
};
const std::vector<Solver>& all_solvers();
std::string to_string(Solver solver);
std::string to_string(Method method);

struct TracePoint {
    int evaluation = 0;
    /// The same where a gradient is paid by differences: one more for each variable of the level, and one for each
    /// variable that the parts of all patches would have, where the run chooses among them.
    int paid = 0;
    double cpu = 0;  ///< seconds of the process since the solve began, set-up included
    /// Best feasible objective so far, as minimized (a maximized one with its sign changed); NaN before there is one.
    double best = std::numeric_limits<double>::quiet_NaN();
    double objective = std::numeric_limits<double>::quiet_NaN();  ///< of this evaluation, likewise; NaN: it failed
    double violation = std::numeric_limits<double>::quiet_NaN();  ///< of this evaluation: of a constraint, the largest
};

struct Solve {
    std::string problem, solver, method, status, reason;
    int variables = 0;   ///< of the largest level entered
    std::string levels;  ///< variables of each level, joined by +
    int evaluations = 0, failures = 0;
    double start = std::numeric_limits<double>::quiet_NaN(), final = start;
    double inherited_change = 0;  ///< largest relative change of the objective by a refinement
    std::vector<TracePoint> trace;
    Points vertices;     ///< of the best design; empty: none
    PatchLevel patches;  ///< Strake's: those of the best design
    std::vector<std::string> notes;
};

/// Variables of `finest`: of the patches of the last level that are not wholly held.
int variables_of_last_level(const Problem& problem);

/// @param budget evaluations. @param enough ends the solve once the best objective, as minimized, is no higher.
/// @throws InvalidInput when the solver cannot use the method.
Solve solve(const EvidenceProblem& problem, Solver solver, Method method, int budget,
            double enough = -std::numeric_limits<double>::infinity());
/// The same by a motion of the caller's.
Solve solve(const EvidenceProblem& problem, const ComparedMotion& motion, Method method, int budget);

}  // namespace strake::evidence
