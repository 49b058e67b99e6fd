#pragma once
#include "optimize/problem.hpp"

/// What the methods of optimization need and take.
namespace strake {

struct MethodFacts {
    Method method;
    const char* name;       ///< as in a case file
    const char* algorithm;  ///< of NLopt 2.7; slsqp: of the quadratic models only, the rest is ours
    bool needs_gradients;
    bool takes_inequalities, takes_equalities;  ///< itself; others are met by an augmented Lagrangian around it
    bool is_global;                             ///< needs finite bounds; its end is polished by slsqp
    int least_variables;                        ///< with fewer sbplx takes its place
    bool ranks_failures;  ///< goes on after a failed evaluation, which counts as the worst seen; others start anew
    const char* summary;
};

/// All methods, in the order of the enumeration.
const std::vector<MethodFacts>& all_methods();
const MethodFacts& method_facts(Method method);
/// Null: there is none of this name.
const MethodFacts* method_named(const std::string& name);

}  // namespace strake
