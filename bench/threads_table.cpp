#include "bench/shell_cases.hpp"
#include "core/parallel.hpp"
#include "core/primo/shell_impl.hpp"

#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>

/// What a second thread does: `threads_table [--repeat N] [wing:22000 | body:131000 | FILE]...`. Every stage is done N
/// times by one and by two threads in turns; the least CPU seconds of the process and the least wall seconds of each.
/// The serial share, 2 own/all - 1, is that of the CPU seconds by which the calling thread has more than the other one:
/// it can be told on a busy machine, too.
namespace {

using namespace strake;

double of_thread() {
    rusage usage;
    getrusage(RUSAGE_THREAD, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Cost {
    double cpu = 1e300, wall = 1e300, own = 0, all = 0;
    void add(const std::function<void()>& work) {
        const auto start = std::chrono::steady_clock::now();
        const double before = strake::cpu(), own_before = of_thread();
        work();
        const double used = strake::cpu() - before;
        own += of_thread() - own_before;
        all += used;
        cpu = std::min(cpu, used);
        wall = std::min(wall, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
};

struct Table {
    int repeat;
    /// @param before what has to be done before `work` each time, untimed
    void row(const std::string& what, const std::function<void()>& before, const std::function<void()>& work) const {
        Cost one, two;
        for (int k = 0; k < repeat; ++k) {
            set_num_threads(1);
            before();
            one.add(work);
            set_num_threads(2);
            before();
            two.add(work);
        }
        std::printf("| %-36s | %7.4f | %7.4f | %5.2f | %7.4f | %7.4f | %5.2f | %5.2f |\n", what.c_str(), one.cpu,
                    two.cpu, two.cpu / one.cpu, one.wall, two.wall, one.wall / two.wall, 2 * two.own / two.all - 1);
        std::fflush(stdout);
    }
};

void kernels(const Table& table, const LoadedShell& body, LinearSolver solver, const std::string& name) {
    ShellOptions options = body.options;
    options.solver = solver;
    PrimoShell shell(body.mesh, options);
    PrimoShell::Impl& impl = shell.impl();
    const Loads loads = complete(body.loads(0.1), body.mesh.num_vertices());
    impl.prepare(loads.spring);
    const auto turn = rotation_differences(impl.poses);
    const Jumps jump = jumps(impl.rest, impl.poses, turn);
    impl.assemble(turn, jump, loads, StressTerm::exact);
    (void)impl.factorize();
    Eigen::VectorXd b = Eigen::VectorXd::Random(6L * impl.rest.num_free());
    const auto nothing = [] {};
    if (solver == LinearSolver::multigrid) {
        table.row("jumps, gradient", nothing, [&] {
            const auto turned = rotation_differences(impl.poses);
            energy_gradient(impl.rest, turned, jumps(impl.rest, impl.poses, turned), loads);
        });
        table.row("assembly", nothing, [&] { impl.assemble(turn, jump, loads, StressTerm::exact); });
        table.row("product with the matrix", nothing, [&] { b = 1e-3 * impl.product(b); });
    }
    table.row(name + " set-up", nothing, [&] { (void)impl.factorize(); });
    table.row(name + " applied to one column", nothing, [&] { b = 1e-3 * impl.precondition(b); });
    if (solver == LinearSolver::multigrid) return;
    const Eigen::MatrixXd B = Eigen::MatrixXd::Random(b.size(), 10);
    table.row(name + " applied to ten", nothing, [&] { impl.precondition(B); });
}

void solves(const Table& table, const LoadedShell& body) {
    ShellOptions options = body.options;
    options.expected_solves = 1;  // as `strake deform`
    for (const double share : {0.1, 0.5}) {
        std::unique_ptr<PrimoShell> shell;
        const auto make = [&] { shell = std::make_unique<PrimoShell>(body.mesh, options); };
        table.row(text("cold, ", 100 * share, " %"), make, [&] { shell->solve(body.loads(share)); });
    }
    SolveOptions keep;
    keep.keep_factor = true;
    PrimoShell shell(body.mesh, body.options);
    const Loads loads = body.loads(0.1);
    shell.solve(loads, {}, keep);
    shell.refresh_tangent();
    const Poses poses = shell.poses();
    const auto back = [&] { shell.set_poses(poses); };
    for (const double change : {0.01, 0.05})
        table.row(text("warm, loads changed by ", 100 * change, " %"), back,
                  [&] { shell.solve(changed(loads, change), {}, keep); });
    table.row(
        "gradient there", [] {}, [&] { shell.adjoint({loads.force}); });
}

}  // namespace

int main(int count, char** words) {
    keep_large_blocks();
    Table table{5};
    std::vector<std::string> names;
    for (int i = 1; i < count; ++i)
        if (!std::strcmp(words[i], "--repeat") && i + 1 < count)
            table.repeat = std::stoi(words[++i]);
        else
            names.emplace_back(words[i]);
    if (names.empty()) names = {"body:131000"};
    for (const std::string& name : names) {
        const LoadedShell body(name);
        std::printf("\n%s: %d triangles, %d processors\n\n", name.c_str(), body.mesh.num_triangles(), num_processors());
        std::printf(
            "| stage | CPU s, 1 thread | 2 threads | ratio | wall s, 1 thread | 2 threads | faster | serial |\n");
        std::printf("|---|---|---|---|---|---|---|---|\n");
        kernels(table, body, LinearSolver::multigrid, "multigrid");
        solves(table, body);
        kernels(table, body, LinearSolver::direct, "factor");
    }
}
