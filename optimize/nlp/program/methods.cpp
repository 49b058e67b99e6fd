#include "optimize/nlp/program/methods.hpp"

#include "core/error.hpp"

#include <string_view>

namespace strake {
namespace {

/// In small letters, without '-'.
std::string plain(const std::string& name) {
    std::string word;
    for (const char c : name)
        if (c != '-') word += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return word;
}

/// "NLOPT_LD_SLSQP" -> "slsqp"
std::string without_prefixes(std::string word) {
    for (const std::string_view prefix : {"nlopt_", "ld_", "ln_", "gd_", "gn_", "g_"})
        if (word.starts_with(prefix)) word.erase(0, prefix.size());
    return word;
}

}  // namespace

const std::vector<MethodFacts>& all_methods() {
    constexpr bool yes = true, no = false;
    static const std::vector<MethodFacts> table{
        // clang-format off
        //                                      gradients <=   =    global min  ranks failures
        {Method::sqp, "sqp", "LD_SLSQP",              yes, yes, yes, no, 1, no, "sequential quadratic programming in a trust region"},
        {Method::mma, "mma", "LD_MMA",                yes, yes, no, no, 1, no, "method of moving asymptotes"},
        {Method::ccsaq, "ccsaq", "LD_CCSAQ",          yes, yes, no, no, 1, no, "conservative convex separable quadratic approximations"},
        {Method::lbfgs, "lbfgs", "LD_LBFGS",          yes, no, no, no, 1, no, "limited-memory BFGS"},
        {Method::tnewton, "tnewton", "LD_TNEWTON_PRECOND_RESTART", yes, no, no, no, 1, no, "truncated Newton with preconditioning"},
        {Method::var2, "var2", "LD_VAR2",             yes, no, no, no, 1, no, "limited-memory variable metric"},
        {Method::nlopt_slsqp, "nlopt_slsqp", "LD_SLSQP", yes, yes, yes, no, 1, no, "NLopt's sequential quadratic programming with line searches"},
        {Method::model, "model", "MODEL",             no, yes, yes, no, 1, no, "Gaussian processes of objective and constraints in a trust region, evaluations in batches"},
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
    const std::string word = plain(name);
    for (const MethodFacts& facts : all_methods())
        if (facts.name == word) return &facts;
    const std::string bare = without_prefixes(word);
    for (const MethodFacts& facts : all_methods())  // sqp comes first: until 1.0 "slsqp" is its alias
        if (bare == without_prefixes(plain(facts.name)) || bare == without_prefixes(plain(facts.algorithm)))
            return &facts;
    return nullptr;
}

}  // namespace strake
