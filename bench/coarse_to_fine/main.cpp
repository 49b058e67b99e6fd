#include "bench/coarse_to_fine/disturbance.hpp"
#include "bench/coarse_to_fine/solve.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/formats/vtp.hpp"
#include "core/text/file.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

/// strake_evidence: solves design problems in every way that is compared; profile.py makes tables and plots of it.
namespace {

using namespace strake;
using namespace strake::evidence;

/// What earlier runs did.
struct EarlierWay {
    const char* flag;
    bool OptimizeOptions::*option;
    const char* words;
};
constexpr EarlierWay earlier_ways[] = {
    {"--limits-by-models", &OptimizeOptions::limits_by_models,
     "model meets limits that are known along the slopes of its models"},
    {"--limits-by-turns", &OptimizeOptions::limits_by_turns,
     "model meets limits that are known and the motion limit by turns"},
    {"--minima-in-variables", &OptimizeOptions::minima_in_variables,
     "model looks for minima of its models in all variables"},
    {"--one-curvature", &OptimizeOptions::one_curvature, "models of patches alone have the metric's curvature only"},
    {"--fields-have-one-curvature", &OptimizeOptions::fields_have_one_curvature,
     "models of fields have the metric's curvature only"},
    {"--fields-lead", &OptimizeOptions::fields_lead,
     "patches lead only where they gain nearly what fields do, and the finest are the last level"},
    {"--patches-last", &OptimizeOptions::patches_last, "long runs by models have patches beside finer fields"},
    {"--narrow-ranges", &OptimizeOptions::models_begin_with_narrow_ranges,
     "model searches in the ranges of what each variable may do alone"},
    {"--leaves-equations", &OptimizeOptions::leaves_equations, "nothing leads model back to equations"},
    {"--leaves-limits", &OptimizeOptions::leaves_limits, "nothing leads model back to limits that are known exactly"},
    {"--whole-batches", &OptimizeOptions::begins_with_whole_batches,
     "model asks whole batches on the first level of fields, too"},
    {"--parts-alone", &OptimizeOptions::sees_parts_alone, "refinement looks at parts of patches alone, never deeper"},
    {"--ignore-waves", &OptimizeOptions::ignores_waves, "steps are not watched for waves of many minima"},
    {"--levels-end", &OptimizeOptions::levels_end_at_limits, "levels of model end at their limits, though they gain"},
    {"--levels-gain-a-quarter", &OptimizeOptions::levels_gain_a_quarter,
     "levels of model go on where their last quarter has gained a quarter of all, not 15 %"},
    {"--stays-where-sure", &OptimizeOptions::stays_where_models_are_sure,
     "model looks along untried directions only where it is not sure of them"},
    {"--images-are-exact", &OptimizeOptions::images_are_exact,
     "images of patches are taken for exact, and refute a symmetry"},
    {"--follows-short-waves", &OptimizeOptions::follows_short_waves,
     "models follow waves that are shorter than what lies between their points"},
    {"--whole-fronts", &OptimizeOptions::refines_whole_fronts, "beside fields all patches of a front have variables"},
    {"--whole-energies", &OptimizeOptions::counts_whole_energy, "elastic energies count wholly beside fields"},
    {"--ignores-symmetry", &OptimizeOptions::ignores_symmetry, "model searches symmetric designs among all others"},
    {"--pays-without-shape", &OptimizeOptions::pays_without_shape, "model evaluates designs that have no valid shape"},
    {"--steps-pay-without-shape", &OptimizeOptions::steps_pay_without_shape, "the same of the steps of sqp"}};

struct Settings {
    std::vector<std::string> problems = problem_names();
    std::vector<std::string> solvers;
    std::vector<std::string> methods;
    int triangles = 5000, budget = 150;
    unsigned seed = 1;
    std::string out = "evidence";
    LevelStartHessian level_start = LevelStartHessian::carried;
    double min_expected_gain = OptimizeOptions().min_expected_gain;
    std::vector<int> fields;
    bool values_only = false, by_program = false;
    OptimizeOptions earlier;  ///< `earlier_ways`
    double motion_limit = 1;
    double noise = 0, failures = 0;
    int batch = OptimizeOptions().batch;
    /// Objectives, as minimized, at which a run has seen enough, by problem and method; none: it goes on.
    std::map<std::pair<std::string, std::string>, double> enough;
};

std::string number(double value) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.12g", value);
    return digits;
}

/// Text as one field of a CSV file.
std::string quoted(const std::string& words) {
    std::string field = "\"";
    for (const char c : words) field += c == '"' ? "\"\"" : c == '\n' ? " " : std::string(1, c);
    return field + '"';
}

/// The final surface with its patches; `fineness` is the number of splits above a patch.
void write_patches(const std::filesystem::path& file, const EvidenceProblem& problem, const Solve& solve) {
    if (solve.vertices.rows() == 0 || solve.patches.patches.empty()) return;
    std::vector<int> fineness(problem.problem.surface.num_triangles(), 0);
    for (const Patch& patch : solve.patches.patches)
        for (const int t : patch.triangles)
            fineness[t] = patch.name == "all" ? 0 : 1 + static_cast<int>(std::ranges::count(patch.name, '.'));
    const Points moved = solve.vertices - problem.problem.surface.vertices;
    write_vtp(file, with_vertices(problem.problem.surface, solve.vertices), {{"displacement", moved}},
              {{"patch", solve.patches.label}, {"fineness", fineness}});
}

/// One line in PROBLEM-SOLVER-METHOD-runs.csv, one an evaluation in -trace.csv, what was said in -notes.txt.
void write(const std::filesystem::path& folder, const EvidenceProblem& problem, const Solve& s) {
    const std::string key = s.problem + "," + s.solver + "," + s.method + ",";
    const std::string runs =
        "problem,solver,method,triangles,variables,levels,evaluations,failures,start,final,cpu,inherited_change,"
        "status,reason\n" +
        key + std::to_string(problem.problem.surface.num_triangles()) + "," + std::to_string(s.variables) + "," +
        s.levels + "," + std::to_string(s.evaluations) + "," + std::to_string(s.failures) + "," + number(s.start) +
        "," + number(s.final) + "," + number(s.trace.empty() ? 0 : s.trace.back().cpu) + "," +
        number(s.inherited_change) + "," + s.status + "," + quoted(s.reason) + "\n";
    std::string trace = "problem,solver,method,evaluation,paid,cpu,best\n", notes;
    for (const TracePoint& p : s.trace)
        trace += key + std::to_string(p.evaluation) + "," + std::to_string(p.paid) + "," + number(p.cpu) + "," +
                 number(p.best) + "\n";
    for (const std::string& note : s.notes) notes += key + " " + note + "\n";
    const std::string name = s.problem + "-" + s.solver + "-" + s.method;
    write_atomically(folder / (name + "-trace.csv"), trace);
    write_atomically(folder / (name + "-notes.txt"), notes);
    write_atomically(folder / (name + "-runs.csv"), runs);  // last: it says that the others are there
}

bool wanted(const std::vector<std::string>& list, const std::string& name) {
    return list.empty() || std::find(list.begin(), list.end(), name) != list.end();
}

Solve solve_or_say_why(const EvidenceProblem& problem, Solver solver, Method method, const Settings& settings) {
    const auto enough = settings.enough.find({problem.name, to_string(method)});
    try {
        return enough == settings.enough.end() ? solve(problem, solver, method, settings.budget)
                                               : solve(problem, solver, method, settings.budget, enough->second);
    } catch (const std::exception& e) {
        Solve failed;
        failed.problem = problem.name;
        failed.solver = to_string(solver);
        failed.method = to_string(method);
        failed.status = "error";
        failed.reason = e.what();
        return failed;
    }
}

/// The noise is a share of what the same way gains without it; the trace has true values.
Solve solve_disturbed(const EvidenceProblem& problem, Solver solver, Method method, const Settings& settings) {
    Disturbance disturbance{.noise = 0, .failures = settings.failures, .seed = settings.seed};
    if (settings.noise > 0) {
        const Solve calm = solve_or_say_why(problem, solver, method, settings);
        disturbance.noise = settings.noise * std::abs(calm.start - calm.final);
    }
    const auto truth = std::make_shared<Truth>();
    Solve result = solve_or_say_why(disturbed(problem, disturbance, truth), solver, method, settings);
    const double sign = problem.problem.maximize ? -1 : 1;
    const auto exact = [&](double seen) {
        const auto known = truth->find(sign * seen);
        return known == truth->end() ? seen : sign * known->second;
    };
    for (TracePoint& point : result.trace) point.best = exact(point.best);
    result.start = exact(result.start);
    result.final = exact(result.final);
    return result;
}

Solve solve_as_asked(const EvidenceProblem& problem, Solver solver, Method method, const Settings& settings) {
    const bool is_disturbed = settings.noise > 0 || settings.failures > 0;
    return is_disturbed ? solve_disturbed(problem, solver, method, settings)
                        : solve_or_say_why(problem, solver, method, settings);
}

void run_problem(const std::string& name, const Settings& settings) {
    EvidenceProblem problem = make_problem(name, settings.triangles, settings.seed);
    problem.problem.optimize.level_start = settings.level_start;
    problem.problem.optimize.min_expected_gain = settings.min_expected_gain;
    problem.problem.optimize.batch = settings.batch;
    problem.problem.parameters.max_displacement *= settings.motion_limit;
    if (!settings.fields.empty()) problem = with_displacement_fields(problem, settings.fields);
    if (settings.values_only) problem = without_gradients(problem);
    if (settings.by_program) problem = with_objective_by_program(problem);
    for (const EarlierWay& way : earlier_ways) problem.problem.optimize.*way.option = settings.earlier.*way.option;
    const std::filesystem::path folder = settings.out;
    for (const Solver solver : all_solvers())
        for (const Method method : methods_of(problem)) {
            if (solver == Solver::filtered && method == Method::sqp) continue;
            if (!wanted(settings.solvers, to_string(solver)) || !wanted(settings.methods, to_string(method))) continue;
            const std::string file = name + "-" + to_string(solver) + "-" + to_string(method) + "-runs.csv";
            if (std::filesystem::exists(folder / file)) continue;  // by an earlier, interrupted call
            const Solve s = solve_as_asked(problem, solver, method, settings);
            write(folder, problem, s);
            std::fprintf(stderr,
                         "%-20s %-13s %-6s %5d variables %4d evaluations (%d failed) %8.1f s  %.6g -> %.6g  %s\n",
                         s.problem.c_str(), s.solver.c_str(), s.method.c_str(), s.variables, s.evaluations, s.failures,
                         s.trace.empty() ? 0 : s.trace.back().cpu, s.start, s.final, s.status.c_str());
            if (solver == Solver::adaptive || solver == Solver::fields)
                write_patches(folder / (name + "-" + s.solver + "-" + s.method + ".vtp"), problem, s);
        }
}

/// Rows PROBLEM,METHOD,OBJECTIVE below a line of names.
void read_enough(const std::string& file, Settings& settings) {
    std::ifstream in(file);
    if (!in) throw InvalidInput(text("cannot read ", file));
    std::string line;
    for (std::getline(in, line); std::getline(in, line);) {
        const std::size_t first = line.find(','), second = line.find(',', first + 1);
        if (second == std::string::npos) throw InvalidInput(text(file, ": expected PROBLEM,METHOD,OBJECTIVE: ", line));
        settings.enough[{line.substr(0, first), line.substr(first + 1, second - first - 1)}] =
            std::stod(line.substr(second + 1));
    }
}

std::vector<std::string> all_names() {
    std::vector<std::string> names = problem_names();
    names.insert(names.end(), physical_names().begin(), physical_names().end());
    return names;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Solves the problems of the evidence suite in every way that is compared", "strake_evidence"};
    Settings settings;
    bool list = false, physical = false;
    std::string enough;
    app.add_option("--problems", settings.problems, "names; default: the twelve with targets")
        ->delimiter(',')
        ->check(CLI::IsMember(all_names()));
    app.add_flag("--physical", physical, "the six physical problems");
    std::vector<std::string> solvers;
    for (const Solver solver : all_solvers()) solvers.push_back(to_string(solver));
    app.add_option("--solvers", settings.solvers, "default: all of them")
        ->delimiter(',')
        ->check(CLI::IsMember(solvers));
    app.add_option("--enough", enough, "CSV file PROBLEM,METHOD,OBJECTIVE: a run ends at that objective")
        ->check(CLI::ExistingFile);
    app.add_option("--methods", settings.methods, "sqp, model, lbfgs, mma, cobyla, bobyqa; default: all")
        ->delimiter(',');
    app.add_option("--triangles", settings.triangles, "of a surface, about")
        ->check(CLI::Range(500, 1'000'000))
        ->take_last();
    app.add_option("--budget", settings.budget, "evaluations of one solve")->check(CLI::Range(1, 100'000))->take_last();
    app.add_option("--seed", settings.seed, "another seed makes another set of problems");
    app.add_option("--out", settings.out, "folder");
    const std::map<std::string, LevelStartHessian> starts{{"carried", LevelStartHessian::carried},
                                                          {"metric", LevelStartHessian::metric},
                                                          {"diagonal", LevelStartHessian::diagonal}};
    app.add_option("--level-start", settings.level_start,
                   "what a level knows at its start (sqp): carried, metric, diagonal")
        ->transform(CLI::CheckedTransformer(starts));
    app.add_option("--min-expected-gain", settings.min_expected_gain,
                   "adaptive: share of the gain below which an expected decrease is not worth a refinement")
        ->check(CLI::Range(0.0, 1.0));
    app.add_option("--fields", settings.fields, "displacement fields of successive levels, for example 27,60,192")
        ->delimiter(',')
        ->check(CLI::Range(1, 600));
    app.add_flag(
        "--values-only", settings.values_only,
        "no gradients: sqp by differences, which count as evaluations, model, cobyla, and bobyqa without constraints");
    app.add_flag("--by-program", settings.by_program,
                 "the same for the objective alone, as if a flow solver told it; limits are known, with gradients");
    for (const EarlierWay& way : earlier_ways)
        app.add_flag(way.flag, settings.earlier.*way.option, text(way.words, ", as in earlier runs"));
    app.add_option("--motion-limit", settings.motion_limit, "share of the problems' own")
        ->check(CLI::Range(0.01, 100.0));
    app.add_option("--batch", settings.batch, "designs that model proposes together")->check(CLI::Range(1, 1000));
    app.add_option("--noise", settings.noise,
                   "of the objective's values, a share of what the same way gains without; traces have true values")
        ->check(CLI::Range(0.0, 1.0));
    app.add_option("--failures", settings.failures, "share of the designs that fail")->check(CLI::Range(0.0, 0.9));
    app.add_flag("--list", list, "print the problems and end");
    CLI11_PARSE(app, argc, argv);
    if (physical) settings.problems = physical_names();
    try {
        if (!enough.empty()) read_enough(enough, settings);
        if (list) {
            for (const std::string& name : settings.problems) {
                const EvidenceProblem p = make_problem(name, settings.triangles, settings.seed);
                std::printf("%s,%d,%d,%s,%s\n", name.c_str(), p.problem.surface.num_triangles(),
                            variables_of_last_level(p.problem), p.outside ? "outside" : "-", quoted(p.what).c_str());
            }
            return 0;
        }
        std::filesystem::create_directories(settings.out);
        for (const std::string& name : settings.problems) run_problem(name, settings);
        return 0;
    } catch (const InvalidInput& e) {
        std::fprintf(stderr, "strake_evidence: %s\n", e.what());
        return 2;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "strake_evidence: %s\n", e.what());
        return 1;
    }
}
