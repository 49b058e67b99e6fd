#include <cstdio>
#include <string>
#include <vector>

#include "bench/shell_cases.hpp"
#include "core/primo/energy.hpp"
#include "core/primo/linear/preconditioner.hpp"

/// Multigrid on shells held at one end: `multigrid_table [--edges H]... [--cold] [wing:131000 | body:420000 |
/// FILE]...`. One line per surface and prism height (in mean edge lengths; without, 2 % of the diagonal): levels,
/// set-up, one solve to 1e-8. With --cold instead the whole nonlinear solve at 10 % of the diagonal. CPU seconds of the
/// process.
namespace {

using namespace strake;

double mean_edge(const TriMesh& mesh) { return std::sqrt(triangle_areas(mesh).mean() * 4 / std::sqrt(3.0)); }

/// @param edges prism height in mean edge lengths; 0: 2 % of the diagonal
HeldShell held_shell(const std::string& name, double edges) {
    TriMesh mesh = bench_surface(name);
    const double height = edges > 0 ? edges * mean_edge(mesh) / box_diagonal(mesh) : 0.02;
    HeldShell held(std::move(mesh), height);
    held.options.couple_nonmanifold = true;
    held.options.solver = LinearSolver::multigrid;
    return held;
}

void one_solve(const std::string& name, double edges) {
    const HeldShell held = held_shell(name, edges);
    const RestState rest = rest_state(held.mesh, held.options);
    const Poses still{std::vector<Eigen::Quaterniond>(rest.num_prisms(), Eigen::Quaterniond::Identity()),
                      Points::Zero(rest.num_prisms(), 3)};
    const auto turn = rotation_differences(still);
    const Loads none = complete({}, held.mesh.num_vertices());
    BlockMatrix H = hessian_pattern(rest);
    assemble_hessian(rest, turn, jumps(rest, still, turn), none, StressTerm::none, H);
    const Points centre = rest.centroid(rest.free_prisms, Eigen::all);
    const double height_in_edges = held.options.prism_height[0] / mean_edge(held.mesh);
    Multigrid multigrid(Preconditioner::options_for(height_in_edges));
    const double start = cpu();
    if (!multigrid.setup(H, centre)) {
        std::printf("| %s | no levels\n", name.c_str());
        return;
    }
    const double ready = cpu();
    const KrylovResult end = multigrid.solve(H, vertex_wrenches(rest, turn, held.loads.force), 1e-8, 300);
    const double done = cpu();
    std::string sizes;
    for (const int size : multigrid.level_sizes()) sizes += text(sizes.empty() ? "" : " ", size);
    std::printf("| %-12s | %5.2f | %3d | %7.2f | %7.2f | %5.0f MB%s | %s |\n", name.c_str(), height_in_edges,
                end.relative_residual <= 1e-8 ? end.iterations : -1, ready - start, done - ready,
                static_cast<double>(multigrid.bytes()) / 1e6, multigrid.is_single_precision() ? "" : " (double)",
                sizes.c_str());
    std::fflush(stdout);
}

void cold_solve(const std::string& name, double edges) {
    HeldShell held = held_shell(name, edges);
    held.scale_loads(0.1);
    PrimoShell shell(held.mesh, held.options);
    const double start = cpu();
    const Equilibrium end = shell.solve(held.loads);
    std::printf("| %-12s | %s | %d it, %d set-ups, %d cycles | %7.2f s | peak %.2f GB |\n", name.c_str(),
                to_string(end.status).c_str(), end.iterations, end.factorizations, end.substitutions, cpu() - start,
                peak_gigabytes());
    std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
    keep_large_blocks();
    std::vector<double> edges;
    bool cold = false;
    for (int a = 1; a < count; ++a) {
        const std::string argument = arguments[a];
        if (argument == "--edges" && a + 1 < count)
            edges.push_back(std::stod(arguments[++a]));
        else if (argument == "--cold")
            cold = true;
        else
            for (const double height : edges.empty() ? std::vector<double>{0.0} : edges)
                cold ? cold_solve(argument, height) : one_solve(argument, height);
    }
}
