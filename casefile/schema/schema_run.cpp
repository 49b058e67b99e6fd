#include "casefile/schema/schema_parts.hpp"
#include "optimize/nlp/program/methods.hpp"

#include <utility>

namespace strake {
namespace {

std::vector<std::string> method_words() {
    std::vector<std::string> words{"auto"};
    for (const MethodFacts& method : all_methods()) words.push_back(method.name);
    return words;
}

std::vector<std::string> nlopt_words() {
    std::vector<std::string> words{"auto"};  // each stands for the word of the same place
    for (const MethodFacts& method : all_methods()) words.push_back(method.algorithm);
    return words;
}

std::string method_doc() {
    std::string
        doc =
            "auto: sqp; where a value has no gradients, sqp by differences, or model where the budget is short of "
            "what these need, or is at most 1000 and fields come first (the run says which). With gradients: ",
        without = " Derivative-free: ", global = " Global, within the bounds: ";
    std::string* const lists[] = {&doc, &without, &global};
    std::string between[] = {"", "", ""};
    for (const MethodFacts& method : all_methods()) {
        const int k = method.is_global ? 2 : method.needs_gradients ? 0 : 1;
        *lists[k] += text(std::exchange(between[k], ", "), method.name, " (", method.summary, ")");
    }
    return doc + "." + without + "." + global + ". The names of NLopt are accepted, too. Not for fit.";
}

std::vector<Key> method_keys() {
    return {
        {.path = "optimize", .doc = "Optimization method and stopping criteria.", .fallback = "{}"},
        {.path = "optimize.method",
         .type = Type::word,
         .doc = method_doc(),
         .fallback = "auto",
         .words = method_words(),
         .aliases = nlopt_words(),
         .loose_word = true},
        {.path = "optimize.batch",
         .type = Type::integer,
         .doc = "Number of designs that method model proposes together, so that as many can be evaluated at the same "
                "time (`parallel` of a program). Coarse levels of a search by differences that begin with method model "
                "ask half as many, and so does the first level of a long run that begins with displacement fields, but "
                "at least 4. Results depend on it, never on `parallel`. Not for fit.",
         .fallback = "8",
         .limits = at_least_one},
        {.path = "optimize.symmetry",
         .type = Type::flag,
         .doc = "Long runs by method model that begin with fields compare the values of a design and of its mirror "
                "images in the planes of symmetry of the body, and search symmetric designs alone where all are the "
                "same. They then never leave the symmetry, also where an optimum does. false: they search all.",
         .fallback = "true"},
        {.path = "optimize.finite_differences",
         .type = Type::flag,
         .doc = "Finite-difference gradients for programs that return none, at one more evaluation per variable; for "
                "programs that return gradients per vertex only, the derivatives with respect to `variables`. Not for "
                "fit.",
         .fallback = "false"},
        {.path = "optimize.difference_step",
         .type = Type::number,
         .doc = "Step of the finite differences, as a share of the scale of a variable (max_displacement, or half of "
                "the range of one of `variables`). Where the first values that it gives do not follow their slopes, "
                "the noise is "
                "measured and the step becomes longer. Not for fit.",
         .fallback = "1e-4",
         .limits = {1e-9, 1, false, false}},
        {.path = "optimize.starts",
         .type = Type::integer,
         .doc = "Number of starting points on the first level: the start shape, then random ones within the bounds. "
                "auto: the start shape; with fields, where values go up and down (many minima), the first fields are "
                "searched to their end before finer ones join, and once more from random changes of them: by gradients "
                "with split: sensitivity, and in long runs by method: model. A stated number, 1 too, switches this "
                "off. Not for fit.",
         .fallback = "auto",
         .limits = at_least_one,
         .words = {"auto"}},
        {.path = "optimize.seed",
         .type = Type::integer,
         .doc = "Seed of the random numbers. Not for fit.",
         .fallback = "1",
         .limits = not_negative},
        {.path = "optimize.start_from",
         .type = Type::path,
         .doc = "Folder of an earlier run or fit, or of samples, on the same surface. This one starts at its best "
                "design: with its patches (and the deeper ones of this case if the levels agree), shape and values of "
                "`variables`. Default: the start shape."},
    };
}

std::vector<Key> sample_keys() {
    return {
        {.path = "sample",
         .doc = "Evaluate designs spread over the space of the first level instead of searching; `strake sample` sets "
                "it. `optimize.budget.evaluations` is the number of designs, the start included."},
        {.path = "sample.method",
         .type = Type::word,
         .doc = "How designs are spread: sobol, a sequence that goes on when the budget is raised; lhs, a Latin "
                "hypercube (random, `optimize.seed`); levels, all combinations of equidistant levels of each variable, "
                "as many as the budget holds.",
         .fallback = "sobol",
         .words = {"sobol", "lhs", "levels"}},
        {.path = "sample.table",
         .type = Type::file,
         .doc = "Table (CSV) of designs that have been evaluated elsewhere: a column for each variable, in the units "
                "that programs receive, and one for each value. Quantities in it are not called. Default: none; the "
                "designs are spread."},
    };
}

std::vector<Key> fit_keys() {
    return {
        {.path = "optimize.loss",
         .type = Type::word,
         .doc = "Robust loss that reduces the weight of outliers: none, huber (linear beyond loss_scale), soft_l1 (the "
                "same, smooth), cauchy (logarithmic). Only for fit.",
         .fallback = "none",
         .words = {"none", "huber", "cauchy", "soft_l1"}},
        {.path = "optimize.loss_scale",
         .type = Type::length,
         .doc = "Distance beyond which a point counts as an outlier; three standard deviations of good points is a "
                "reasonable choice.",
         .fallback = "0.1%",
         .limits = positive,
         .when = "loss=huber|cauchy|soft_l1"},
        {.path = "optimize.icp_iterations",
         .type = Type::integer,
         .doc = "Updates of the closest points. 0: at every evaluation; n: a level has at most n solves, each with "
                "fixed closest points. Only for fit.",
         .fallback = "0",
         .limits = not_negative},
    };
}

std::vector<Key> stopping_keys() {
    return {
        {.path = "optimize.budget", .doc = "Limits of the whole run.", .fallback = "{}"},
        {.path = "optimize.budget.evaluations",
         .type = Type::integer,
         .doc = "Maximum number of evaluations.",
         .fallback = "60",
         .limits = at_least_one},
        {.path = "optimize.budget.time",
         .type = Type::duration,
         .doc = "Maximum time. Default: no limit.",
         .limits = positive},
        {.path = "optimize.refine_when", .doc = "When the next level starts.", .fallback = "{}"},
        {.path = "optimize.refine_when.progress_below",
         .type = Type::fraction,
         .doc = "Refine when the decrease per evaluation falls below this share of the level's best, or when finer "
                "patches are expected to bring a larger decrease than the level itself; 0: only when the search on the "
                "level ends.",
         .fallback = "1%",
         .limits = {0, 1, false, true}},
        {.path = "optimize.refine_when.min_expected_gain",
         .type = Type::fraction,
         .doc = "With `split: sensitivity`: minimum expected decrease per ten new variables, as a share of the total "
                "decrease of the run. Patches below it are not split, and the run ends when no patch reaches it (fewer "
                "than ten variables count as ten). Smaller values give finer trees.",
         .fallback = "0.2%",
         .limits = {0, 1, false, true}},
        {.path = "optimize.tolerances", .doc = "Convergence criteria of a level.", .fallback = "{}"},
        {.path = "optimize.tolerances.objective",
         .type = Type::number,
         .doc = "Share of the decrease that the run has gained so far; of a fit: relative change of the mean square "
                "distance.",
         .fallback = "1e-6",
         .limits = positive},
        {.path = "optimize.tolerances.step",
         .type = Type::number,
         .doc = "Change of the scaled variables.",
         .fallback = "1e-6",
         .limits = positive},
        {.path = "optimize.tolerances.constraint",
         .type = Type::number,
         .doc = "Violation of a scaled constraint that still counts as feasible. Not for fit.",
         .fallback = "1e-6",
         .limits = positive},
    };
}

std::vector<Key> output_keys() {
    return {
        {.path = "output", .doc = "What is written, and where.", .fallback = "{}"},
        {.path = "output.dir",
         .type = Type::path,
         .doc = "Run folder; in the default, {case} is the name of the case.",
         .fallback = "runs/{case}"},
        {.path = "output.paraview",
         .type = Type::word,
         .doc = "Shapes written for ParaView.",
         .fallback = "every_accepted",
         .words = {"every_accepted", "best", "none"}},
        {.path = "output.keep",
         .type = Type::word,
         .doc = "Evaluation folders of programs (evaluations/000012) to keep: all; failed: those without a value; "
                "best: these and the best design; none. The others are removed once their results are in the journal, "
                "so `strake resume` repeats nothing. With gradient_command, the folders of the last and the best "
                "evaluation stay while a gradient may still be requested.",
         .fallback = "all",
         .words = {"all", "failed", "best", "none"}},
        {.path = "output.report",
         .type = Type::flag,
         .doc = "Write report.html, a page for the browser, when the run ends for any reason (`strake report` writes "
                "it at any time).",
         .fallback = "true"},
    };
}

}  // namespace

std::vector<Key> run_keys() {
    return in_order({sample_keys(), method_keys(), fit_keys(), stopping_keys(), output_keys()});
}

}  // namespace strake
