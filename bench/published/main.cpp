#include "bench/coarse_to_fine/solve.hpp"
#include "bench/published/lattice.hpp"
#include "casefile/build/build_problem.hpp"
#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>

/// strake_box: a case solved by a box of B-splines in the place of its own shape variables.
namespace {

using namespace strake;
using namespace strake::evidence;

struct Settings {
    std::string file, out, points, moves = "xyz";
    std::vector<std::string> set;
};

LatticeBox box_of(const Settings& settings) {
    LatticeBox box;
    box.moves = settings.moves;
    if (std::sscanf(settings.points.c_str(), "%dx%dx%d", &box.points[0], &box.points[1], &box.points[2]) != 3)
        throw InvalidInput(text("--points ", settings.points, ": expected points along x, y and z, for example 8x2x2"));
    return box;
}

bool has_all_gradients(const Problem& problem) {
    return std::all_of(problem.quantities.begin(), problem.quantities.end(),
                       [](const Quantity& q) { return q.has_sensitivities; });
}

void write(const Settings& settings, const EvidenceProblem& problem, const Solve& solve) {
    std::filesystem::create_directories(settings.out);
    if (solve.vertices.rows() > 0)
        write_surface(settings.out + "/best.obj", with_vertices(problem.problem.surface, solve.vertices),
                      SurfaceFormat::obj);
    const std::string path = settings.out + "/history.csv";
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (!file) throw InvalidInput("cannot write " + path);
    std::fprintf(file, "evaluation,status,objective,max_violation\n");
    for (const TracePoint& p : solve.trace)
        std::fprintf(file, "%d,%s,%.12g,%.3g\n", p.evaluation, std::isfinite(p.objective) ? "ok" : "failed",
                     p.objective, p.violation);
    std::fclose(file);
}

void run(const Settings& settings) {
    EvidenceProblem problem;
    problem.problem = build_problem(load_case(settings.file, Purpose::any, settings.set)).problem;
    problem.name = problem.problem.name;
    if (!has_all_gradients(problem.problem)) problem = without_gradients(problem);
    OptimizeOptions& options = problem.problem.optimize;
    const Solve done =
        solve(problem, lattice_box(problem.problem, box_of(settings)), options.method, options.max_evaluations);
    write(settings, problem, done);
    std::printf(
        "variables   %d\nevaluations %d\nfailed      %d\nobjective   %.10g > %.10g\nstatus      %s\nreason      %s\n",
        done.variables, done.evaluations, done.failures, done.start, done.final, done.status.c_str(),
        done.reason.c_str());
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Solves a case by a box of B-splines in the place of its own shape variables", "strake_box"};
    Settings settings;
    app.add_option("case", settings.file, "case file")->required()->check(CLI::ExistingFile);
    app.add_option("--points", settings.points, "of the box along x, y and z: 8x2x2")->required();
    app.add_option("--moves", settings.moves, "directions in which they move");
    app.add_option("--set", settings.set, "KEY=VALUE of the case");
    app.add_option("--out", settings.out, "folder for history.csv and best.obj")->required();
    CLI11_PARSE(app, argc, argv);
    try {
        run(settings);
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "strake_box: %s\n", e.what());
        return 1;
    }
}
