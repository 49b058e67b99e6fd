#include "cases/schema_parts.hpp"
#include "optimize/methods.hpp"

#include <utility>

namespace strake {
namespace {

std::vector<std::string> method_words() {
    std::vector<std::string> words;
    for (const MethodFacts& method : all_methods()) words.push_back(method.name);
    return words;
}

std::vector<std::string> nlopt_words() {
    std::vector<std::string> words;
    for (const MethodFacts& method : all_methods()) words.push_back(method.algorithm);
    return words;
}

std::string method_doc() {
    std::string doc = "With gradients: ", without = " Without: ", global = " Global, within the bounds: ";
    std::string* const lists[] = {&doc, &without, &global};
    std::string between[] = {"", "", ""};
    for (const MethodFacts& method : all_methods()) {
        const int k = method.is_global ? 2 : method.needs_gradients ? 0 : 1;
        *lists[k] += text(std::exchange(between[k], ", "), method.name, " (", method.summary, ")");
    }
    return doc + "." + without + "." + global + ". NLopt's own names are understood. Not for fit.";
}

}  // namespace

std::vector<Key> run_keys() {
    return {
        {.path = "optimize", .doc = "How the optimum is searched, and when the search ends.", .fallback = "{}"},
        {.path = "optimize.method",
         .type = Type::word,
         .doc = method_doc(),
         .fallback = "slsqp",
         .words = method_words(),
         .aliases = nlopt_words(),
         .loose_word = true},
        {.path = "optimize.finite_differences",
         .type = Type::flag,
         .doc = "Gradients of programs that give none by differences of one more evaluation a variable; of programs "
                "that give them per vertex only, those by variables. Not for fit.",
         .fallback = "false"},
        {.path = "optimize.difference_step",
         .type = Type::number,
         .doc =
             "Length of the steps of finite_differences, as a share of what one variable may do (max_displacement, or "
             "half of the range of one of `variables`): well above the noise of the program. Not for fit.",
         .fallback = "1e-4",
         .limits = {1e-9, 1, false, false}},
        {.path = "optimize.starts",
         .type = Type::integer,
         .doc = "Starts of the first level: the given shape, and random ones within the bounds. Not for fit.",
         .fallback = "1",
         .limits = at_least_one},
        {.path = "optimize.seed",
         .type = Type::integer,
         .doc = "Of all that is random. Not for fit.",
         .fallback = "1",
         .limits = not_negative},
        {.path = "optimize.start_from",
         .type = Type::path,
         .doc = "Folder of an earlier run or fit on the same surface, at whose best design this one begins: with its "
                "patches (the deeper ones of this case where the levels are the same), shape, and values of variables. "
                "Without it at rest."},
        {.path = "optimize.loss",
         .type = Type::word,
         .doc = "Robust loss, by which far-off points pull less: none, huber (linear from loss_scale on), soft_l1 (the "
                "same, smooth), cauchy (logarithmic). Only for fit.",
         .fallback = "none",
         .words = {"none", "huber", "cauchy", "soft_l1"}},
        {.path = "optimize.loss_scale",
         .type = Type::length,
         .doc = "Distance from which on a point pulls less; three times the scatter of good points is a start.",
         .fallback = "0.1%",
         .limits = positive,
         .when = "loss=huber|cauchy|soft_l1"},
        {.path = "optimize.associations",
         .type = Type::integer,
         .doc =
             "0: what is closest is found anew at every evaluation; n: it is kept within a solve, and a level has at "
             "most n solves. Only for fit.",
         .fallback = "0",
         .limits = not_negative},
        {.path = "optimize.budget", .doc = "Limits of the whole run.", .fallback = "{}"},
        {.path = "optimize.budget.evaluations",
         .type = Type::integer,
         .doc = "Number of evaluations.",
         .fallback = "60",
         .limits = at_least_one},
        {.path = "optimize.budget.time",
         .type = Type::duration,
         .doc = "Time; without it no limit.",
         .limits = positive},
        {.path = "optimize.refine_when", .doc = "When the next level starts.", .fallback = "{}"},
        {.path = "optimize.refine_when.progress_below",
         .type = Type::fraction,
         .doc = "When the gain of an evaluation falls below this share of the level's best, or finer details promise "
                "more than "
                "the level still does; 0: only when the level's own search ends.",
         .fallback = "1%",
         .limits = {0, 1, false, true}},
        {.path = "optimize.refine_when.promise_below",
         .type = Type::fraction,
         .doc =
             "With `split: sensitivity`: patches are split only where they are expected to give this share of what the "
             "run has gained for every ten new variables, and the run ends instead of refining when all that would "
             "be split gives less (fewer than ten variables count as ten). Smaller: finer trees.",
         .fallback = "0.2%",
         .limits = {0, 1, false, true}},
        {.path = "optimize.tolerances", .doc = "When a level has converged.", .fallback = "{}"},
        {.path = "optimize.tolerances.objective",
         .type = Type::number,
         .doc = "Relative change of the objective.",
         .fallback = "1e-6",
         .limits = positive},
        {.path = "optimize.tolerances.step",
         .type = Type::number,
         .doc = "Change of the scaled variables.",
         .fallback = "1e-6",
         .limits = positive},
        {.path = "optimize.tolerances.constraint",
         .type = Type::number,
         .doc = "Violation of a scaled constraint that still counts as met. Not for fit.",
         .fallback = "1e-6",
         .limits = positive},
        {.path = "output", .doc = "What is written, and where.", .fallback = "{}"},
        {.path = "output.dir",
         .type = Type::path,
         .doc = "Folder of the run; {case} stands for the name of the case in the default.",
         .fallback = "runs/{case}"},
        {.path = "output.paraview",
         .type = Type::word,
         .doc = "Shapes written for ParaView.",
         .fallback = "every_accepted",
         .words = {"every_accepted", "best", "none"}},
        {.path = "output.keep",
         .type = Type::word,
         .doc =
             "Which folders of evaluations (evaluations/000012) of programs stay: all; failed: of those that gave no "
             "value; best: these, and that of the best design; none. The others are removed once the journal holds "
             "what they gave: `strake resume` pays for nothing again. Where a gradient may still be asked for "
             "(gradient_command) the folders of the last and of the best evaluation stay.",
         .fallback = "all",
         .words = {"all", "failed", "best", "none"}},
        {.path = "output.report",
         .type = Type::flag,
         .doc = "Whether report.html is written at the end, however the run ends: a page for the browser (`strake "
                "report` makes it at any time).",
         .fallback = "false"},
    };
}

}  // namespace strake
