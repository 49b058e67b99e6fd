#pragma once
#include <string>
#include <vector>

/// The methods of optimization and their facts.
namespace strake {

/// How to search; `method_facts` has the facts of each.
enum class Method {
    sqp,  // local, with gradients
    mma,
    ccsaq,
    lbfgs,
    tnewton,
    var2,
    nlopt_slsqp,
    model,  // local, without
    cobyla,
    bobyqa,
    neldermead,
    sbplx,
    praxis,
    crs2,  // global
    isres,
    mlsl,
    direct,
    esch
};

struct MethodFacts {
    Method method;
    const char* name;       ///< as in a case file
    const char* algorithm;  ///< of NLopt 2.7; sqp: of the quadratic models only, the rest is ours; model: none of it
    bool needs_gradients;
    bool takes_inequalities, takes_equalities;  ///< itself; others are met by an augmented Lagrangian around it
    bool is_global;                             ///< needs finite bounds; sqp polishes its end
    int min_variables;                          ///< with fewer, sbplx takes its place
    bool ranks_failures;  ///< a failed evaluation counts as the worst so far; other methods restart
    const char* summary;
};

/// All methods, in the order of the enumeration.
const std::vector<MethodFacts>& all_methods();
const MethodFacts& method_facts(Method method);
/// By name or alias, in any case, with or without NLopt's prefixes (LD_, NLOPT_LD_, ...). "slsqp" is an alias of sqp
/// until 1.0; NLopt's own SLSQP is nlopt_slsqp. Null: there is none of this name.
const MethodFacts* method_named(const std::string& name);

}  // namespace strake
