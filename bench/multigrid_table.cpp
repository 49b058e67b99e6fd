#include <sys/resource.h>

#include <cstdio>
#include <string>
#include <vector>

#include "bench/shell_cases.hpp"
#include "core/primo/energy.hpp"
#include "core/primo/preconditioner.hpp"

/// Multigrid on shells held at one end: `multigrid_table [--edges H]... [--cold] [wing:131000 | body:420000 |
/// FILE]...`. One line per surface and prism height (in mean edge lengths; without, 2 % of the diagonal): levels,
/// set-up, one solve to 1e-8. With --cold instead the whole nonlinear solve at 10 % of the diagonal. CPU seconds of the
/// process.
namespace {

using namespace strake;

double cpu() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_gigabytes() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / (1 << 20);
}

/// Fixed and loaded as LoadedShell, which solves to scale its loads: that is not wanted here.
struct HeldShell {
    TriMesh mesh;
    ShellOptions options;
    Loads loads;
    double edge;

    HeldShell(const std::string& name, double edges) : mesh(bench_surface(name)) {
        const Box box = bounding_box(mesh);
        edge = std::sqrt(triangle_areas(mesh).mean() * 4 / std::sqrt(3.0));
        const double height = edges > 0 ? edges * edge : 0.02 * box_diagonal(mesh);
        options.prism_height = Eigen::VectorXd::Constant(mesh.num_vertices(), height);
        options.pin.assign(mesh.num_triangles(), free_prism);
        options.couple_nonmanifold = true;
        options.solver = LinearSolver::multigrid;
        const Points centroid = triangle_centroids(mesh);
        int axis = 0;
        const double length = (box.max - box.min).maxCoeff(&axis);
        Points traction = Points::Zero(mesh.num_triangles(), 3);
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const double at = (centroid(t, axis) - box.min[axis]) / length;
            if (at < 0.05) options.pin[t] = fixed_prism;
            if (at > 0.3) traction(t, axis == 2 ? 0 : 2) = 1;
        }
        loads.force = traction_forces(mesh, traction);
    }
};

void one_solve(const std::string& name, double edges) {
    const HeldShell held(name, edges);
    const RestState rest = rest_state(held.mesh, held.options);
    const Poses still{std::vector<Eigen::Quaterniond>(rest.num_prisms(), Eigen::Quaterniond::Identity()),
                      Points::Zero(rest.num_prisms(), 3)};
    const auto turn = rotation_differences(still);
    const Loads none = complete({}, held.mesh.num_vertices());
    BlockMatrix H = hessian_pattern(rest);
    assemble_hessian(rest, turn, jumps(rest, still, turn), none, StressTerm::none, H);
    const Points centre = rest.centroid(rest.free_prisms, Eigen::all);
    const double height_in_edges = held.options.prism_height[0] / held.edge;
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
    for (const int size : multigrid.level_sizes()) sizes += (sizes.empty() ? "" : " ") + std::to_string(size);
    std::printf("| %-12s | %5.2f | %3d | %7.2f | %7.2f | %5.0f MB%s | %s |\n", name.c_str(), height_in_edges,
                end.relative_residual <= 1e-8 ? end.iterations : -1, ready - start, done - ready,
                static_cast<double>(multigrid.bytes()) / 1e6, multigrid.is_single_precision() ? "" : " (double)",
                sizes.c_str());
    std::fflush(stdout);
}

void cold_solve(const std::string& name, double edges) {
    HeldShell held(name, edges);
    PrimoShell shell(held.mesh, held.options);
    const double diagonal = box_diagonal(held.mesh);
    const double moved = (shell.linear_response(held.loads) - held.mesh.vertices).rowwise().norm().maxCoeff();
    held.loads.force *= 0.1 * diagonal / moved;
    const double start = cpu();
    const Equilibrium end = shell.solve(held.loads);
    std::printf("| %-12s | %s | %d it, %d set-ups, %d cycles | %7.2f s | peak %.2f GB |\n", name.c_str(),
                to_string(end.status).c_str(), end.iterations, end.factorizations, end.substitutions, cpu() - start,
                peak_gigabytes());
    std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
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
