#include "optimize/methods.hpp"

#include "core/error.hpp"

namespace strake {

const std::vector<MethodFacts>& all_methods() {
    constexpr bool yes = true, no = false;
    static const std::vector<MethodFacts> table{
        // clang-format off
        //                                      gradients <=   =    global least ranks failures
        {Method::slsqp, "slsqp", "LD_SLSQP",          yes, yes, yes, no, 1, no, "sequential quadratic programming in a trust region"},
        {Method::mma, "mma", "LD_MMA",                yes, yes, no, no, 1, no, "method of moving asymptotes"},
        {Method::ccsaq, "ccsaq", "LD_CCSAQ",          yes, yes, no, no, 1, no, "conservative convex separable quadratic approximations"},
        {Method::lbfgs, "lbfgs", "LD_LBFGS",          yes, no, no, no, 1, no, "limited-memory BFGS"},
        {Method::tnewton, "tnewton", "LD_TNEWTON_PRECOND_RESTART", yes, no, no, no, 1, no, "truncated Newton with preconditioning"},
        {Method::var2, "var2", "LD_VAR2",             yes, no, no, no, 1, no, "limited-memory variable metric"},
        {Method::cobyla, "cobyla", "LN_COBYLA",       no, yes, yes, no, 1, no, "linear approximations in a simplex"},
        {Method::bobyqa, "bobyqa", "LN_BOBYQA",       no, no, no, no, 2, no, "quadratic interpolation"},
        {Method::neldermead, "neldermead", "LN_NELDERMEAD", no, no, no, no, 1, yes, "simplex"},
        {Method::sbplx, "sbplx", "LN_SBPLX",          no, no, no, no, 1, yes, "simplex on subspaces"},
        {Method::praxis, "praxis", "LN_PRAXIS",       no, no, no, no, 2, no, "principal axes"},
        {Method::crs2, "crs2", "GN_CRS2_LM",          no, no, no, yes, 1, yes, "controlled random search"},
        {Method::isres, "isres", "GN_ISRES",          no, yes, yes, yes, 1, yes, "evolution strategy with stochastic ranking"},
        {Method::mlsl, "mlsl", "G_MLSL_LDS",          yes, no, no, yes, 1, yes, "many local searches by lbfgs"},
        {Method::direct, "direct", "GN_DIRECT_L",     no, no, no, yes, 1, yes, "dividing rectangles, locally biased"},
        {Method::esch, "esch", "GN_ESCH",             no, no, no, yes, 1, yes, "evolutionary"},
        // clang-format on
    };
    return table;
}

const MethodFacts& method_facts(Method method) {
    for (const MethodFacts& facts : all_methods())
        if (facts.method == method) return facts;
    throw InvalidInput(text("unknown optimization method ", static_cast<int>(method)));
}

const MethodFacts* method_named(const std::string& name) {
    for (const MethodFacts& facts : all_methods())
        if (facts.name == name) return &facts;
    return nullptr;
}

}  // namespace strake
