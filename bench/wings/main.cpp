#include "bench/coarse_to_fine/solve.hpp"
#include "bench/wings/wing_box.hpp"
#include "casefile/build/build_problem.hpp"
#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

/// strake_wings: cases with a wing solved by Strake's variables and by a box of B-splines that twists.
namespace {

using namespace strake;
using namespace strake::evidence;

struct Settings {
    std::string file, out;
    std::vector<std::string> set, boxes;
    int budget = 60;
    bool downstream = false, root_held = false, values_only = false, only_boxes = false, no_twist = false;
    double reach = 0.1;
};

WingBox box_of(const std::string& word, const Settings& settings) {
    WingBox box;
    if (std::sscanf(word.c_str(), "%dx%dx%d", &box.points[0], &box.points[1], &box.points[2]) != 3 ||
        *std::min_element(box.points.begin(), box.points.end()) < 2)
        throw InvalidInput(text("--boxes ", word,
                                ": expected points along chord, span and height, each at least 2, for example 6x5x2"));
    box.moves_downstream = settings.downstream;
    box.root_held = settings.root_held;
    if (settings.no_twist) box.twist = 0;
    box.reach = settings.reach;
    return box;
}

/// The best value after so many evaluations, over the start.
void print(const EvidenceProblem& problem, const Solve& solve) {
    const double sign = problem.problem.maximize ? -1 : 1;
    std::printf("%-16s %4d variables %3d evaluations %2d failed  %.8g -> %.8g  %-14s", solve.solver.c_str(),
                solve.variables, solve.evaluations, solve.failures, sign * solve.start, sign * solve.final,
                solve.status.c_str());
    for (const int at : {10, 20, 30, 40, 60, 80, 100})
        if (at <= static_cast<int>(solve.trace.size()))
            std::printf("  %d: %.5f", at, solve.trace[static_cast<std::size_t>(at) - 1].best / solve.start);
    std::printf("  end %.5f, %.1f s\n", solve.final / solve.start, solve.trace.empty() ? 0 : solve.trace.back().cpu);
    std::fflush(stdout);
}

void write(const Settings& settings, const EvidenceProblem& problem, const Solve& solve) {
    if (settings.out.empty()) return;
    std::filesystem::create_directories(settings.out);
    const std::string base = settings.out + "/" + problem.name + "-" + solve.solver;
    if (solve.vertices.rows() > 0)
        write_surface(base + ".obj", with_vertices(problem.problem.surface, solve.vertices), SurfaceFormat::obj);
    std::FILE* file = std::fopen((base + ".csv").c_str(), "w");
    if (!file) throw InvalidInput(text("cannot write ", base, ".csv"));
    std::fprintf(file, "evaluation,cpu,best\n");
    for (const TracePoint& p : solve.trace) std::fprintf(file, "%d,%.3f,%.12g\n", p.evaluation, p.cpu, p.best);
    std::fclose(file);
    for (const std::string& note : solve.notes) std::fprintf(stderr, "  %s\n", note.c_str());
    std::fprintf(stderr, "  %s\n", solve.reason.c_str());
}

void compare(const Settings& settings) {
    const BuiltProblem built = build_problem(load_case(settings.file, Purpose::any, settings.set));
    if (built.wings.size() != 1)
        throw InvalidInput(text(settings.file, ": declares ", built.wings.size(), " wings; one is compared"));
    EvidenceProblem problem;
    problem.name = built.problem.name;
    problem.problem = built.problem;
    if (settings.values_only) problem = with_programs_by_values(problem);
    std::printf("%s: %d triangles\n", problem.name.c_str(), problem.problem.surface.num_triangles());
    const auto show = [&](const Solve& solve) {
        print(problem, solve);
        write(settings, problem, solve);
    };
    if (!settings.only_boxes) {
        Solve own = solve(problem, Solver::uniform, problem.problem.optimize.method, settings.budget);
        own.solver = "strake";
        show(own);
    }
    for (const std::string& word : settings.boxes)
        show(solve(problem, wing_box(problem.problem.surface, *built.wings.front(), box_of(word, settings)),
                   problem.problem.optimize.method, settings.budget));
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Solves a case with a wing by its own variables and by boxes of B-splines that twist", "strake_wings"};
    Settings settings;
    app.add_option("case", settings.file, "case file that declares one wing")->required()->check(CLI::ExistingFile);
    app.add_option("--set", settings.set, "KEY=VALUE of the case");
    app.add_option("--boxes", settings.boxes, "points along chord, span and height: 6x5x2,8x8x2")->delimiter(',');
    app.add_option("--budget", settings.budget, "evaluations of each")->check(CLI::Range(1, 10000));
    app.add_option("--reach", settings.reach, "how far a point of a box moves, of the mean chord")
        ->check(CLI::Range(1e-3, 1.0));
    app.add_flag("--downstream", settings.downstream, "points of boxes move along the stream, too");
    app.add_flag("--root-held", settings.root_held, "the first plane of points along the span does not move");
    app.add_flag("--no-twist", settings.no_twist, "boxes do not twist");
    app.add_flag("--values-only", settings.values_only, "no gradients of what programs tell");
    app.add_flag("--only-boxes", settings.only_boxes, "not by the case's own variables");
    app.add_option("--out", settings.out, "folder for histories and shapes");
    CLI11_PARSE(app, argc, argv);
    try {
        compare(settings);
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "strake_wings: %s\n", e.what());
        return 1;
    }
}
