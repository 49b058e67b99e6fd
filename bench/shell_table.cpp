#include "bench/inner_iteration.hpp"
#include "core/patches/segmentation.hpp"
#include "core/primo/shell_impl.hpp"

#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>

/// The paper's table on this project's surfaces: `shell_table [--springs D] [--cold [--solver auto|direct|multigrid]...
/// [--share S]... [--steps]] [--warm N] [wing:22000 | body:131000 | FILE]...`. CPU seconds of the process (user and
/// system), and the same in numeric factorizations of the rest matrix without springs. --cold: cold solves alone, by
/// every solver named, at every share of the diagonal (10 % unless said), their Newton steps where asked for, and their
/// memory. Warm solves start from the equilibrium at 10 % with its factor. --springs: over all that is loaded, lambda =
/// |F| / (2 D), D in diagonals. --warm: memory over N warm solves and gradients instead.
namespace {

using namespace strake;

double timed(const std::function<void()>& work) {
    const double before = cpu();
    work();
    return cpu() - before;
}

struct Table {
    double factorization = 0;
    void row(const std::string& what, double seconds, const std::string& remark = "") const {
        std::printf("| %-44s | %8.3f | %6.2f | %s |\n", what.c_str(), seconds, seconds / factorization, remark.c_str());
        std::fflush(stdout);
    }
};

std::string remark(const Equilibrium& end) {
    const std::string change = end.solver != end.first_solver ? ", went over to " + to_string(end.solver) : "";
    return text(to_string(end.status), change, ", ", end.iterations, " it, ", end.factorizations, " fact, ",
                end.substitutions, " subst, step ", end.last_step, end.stable ? "" : ", NOT proven stable");
}

/// Of one functional by the size of the loads on groups of vertices.
Eigen::VectorXd gradient_by(PrimoShell& shell, const Loads& loads, int variables) {
    const Points dJ_dF = shell.adjoint({loads.force})[0].force;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(variables);
    for (Eigen::Index k = 0; k < dJ_dF.rows(); ++k)
        gradient[k * variables / dJ_dF.rows()] += dJ_dF.row(k).dot(loads.force.row(k));
    return gradient;
}

void warm_rows(const Table& table, PrimoShell& shell, const Loads& loads) {
    SolveOptions options;
    options.keep_factor = true;
    shell.reset();
    shell.solve(loads, {}, options);
    shell.refresh_tangent();
    Poses poses = shell.poses();
    for (const double change : {0.01, 0.05, 0.2}) {
        Equilibrium end;
        shell.set_poses(poses);
        const double seconds = timed([&] { end = shell.solve(changed(loads, change), {}, options); });
        table.row(text("warm, loads changed by ", 100 * change, " %"), seconds, remark(end));
        const double adjoint = timed([&] { shell.adjoint({loads.force}); });
        table.row("  gradient there", adjoint);
        shell.set_poses(poses);
        shell.solve(loads, {}, options);
        shell.refresh_tangent();
        poses = shell.poses();  // to the bit where the factor is of
    }
    for (const int variables : {10, 1000})
        table.row(text("gradient by ", variables, " variables, own factor"),
                  timed([&] { gradient_by(shell, loads, variables); }));
    for (const int count : {10}) {
        std::vector<Points> functionals;
        for (int c = 0; c < count; ++c) functionals.push_back(wavy(loads.force, c));
        table.row(text("gradients of ", count, " functionals, own factor"), timed([&] { shell.adjoint(functionals); }));
    }
}

/// From the equilibrium at 10 %, its factor and its gradients to changed loads.
void inner_rows(const Table& table, const TriMesh& mesh, PrimoShell& shell, const Loads& loads) {
    SolveOptions options;
    options.keep_factor = true;
    shell.reset();
    shell.solve(changed(loads, 0.1), {}, options);
    InnerLoop loop(mesh, shell.vertices());
    for (const double change : {0.01, 0.05}) {
        shell.solve(loads, {}, options);
        shell.refresh_tangent();
        loop.run(shell, loads, options);
        const InnerIteration one = loop.run(shell, changed(loads, change), options);
        table.row(text("one inner iteration, loads changed by ", 100 * change, " %"), one.total(),
                  text("deformation ", one.deformation, ", guard ", one.guard, ", three quantities ", one.quantities,
                       ", their gradients ", one.gradients, ", journal ", one.journal));
    }
}

void cold_row(const Table& table, const LoadedShell& body, double share) {
    ShellOptions options = body.options;
    options.expected_solves = 1;  // as `strake deform`
    PrimoShell shell(body.mesh, options);
    Equilibrium end;
    const double seconds = timed([&] { end = shell.solve(body.loads(share)); });
    table.row(text("cold, ", 100 * share, " %, ", to_string(shell.solver()), ", all included"), seconds, remark(end));
}

struct Cold {
    std::vector<std::string> solvers;
    std::vector<double> shares;
    bool shows_steps = false;
};

LinearSolver solver_named(const std::string& name) {
    for (const LinearSolver solver : {LinearSolver::automatic, LinearSolver::direct, LinearSolver::multigrid})
        if (name == to_string(solver)) return solver;
    throw InvalidInput("--solver " + name + ": auto, direct or multigrid");
}

/// A row for each solver and share: what fits also where no factor does. Ends are held against the first solver's.
void cold_only(const std::string& name, const Cold& cold) {
    const LoadedShell body(name);
    for (const double share : cold.shares) {
        Points first;
        for (const std::string& solver : cold.solvers) {
            ShellOptions options = body.options;
            options.expected_solves = 1;  // as `strake deform`
            options.solver = solver_named(solver);
            PrimoShell shell(body.mesh, options);
            Equilibrium end;
            const double seconds = timed([&] { end = shell.solve(body.loads(share)); });
            std::string apart;
            if (first.size() == 0)
                first = shell.vertices();
            else
                apart =
                    text(", apart ", (shell.vertices() - first).rowwise().norm().maxCoeff() / box_diagonal(body.mesh));
            std::printf("| %s | %d | %g %% | %s | %.2f | %s%s |\n", name.substr(name.rfind('/') + 1).c_str(),
                        body.mesh.num_triangles(), 100 * share, solver.c_str(), seconds, remark(end).c_str(),
                        apart.c_str());
            for (const SolveRecord& record : end.records)
                if (cold.shows_steps)
                    std::printf("    %d: step %.2e, energy %.6e, gradient %.2e\n", record.iteration, record.step,
                                record.energy, record.relative_gradient);
            std::fflush(stdout);
        }
    }
    std::printf("| peak memory | | | | %.2f GB | |\n", peak_gigabytes());
}

void rows(const std::string& name, double spring_distance) {
    const LoadedShell body(name, spring_distance);
    std::printf("\n%s: %d triangles%s\n\n", name.c_str(), body.mesh.num_triangles(),
                spring_distance > 0 ? text(", springs of ", spring_distance, " diagonals").c_str() : "");
    std::printf("| stage | CPU s | factorizations | |\n|---|---|---|---|\n");
    PrimoShell plain(body.mesh, body.options);
    Table table;
    PrimoShell::Impl& impl = plain.impl();
    const double ordering = timed([&] { impl.prepare(Eigen::VectorXd::Zero(body.mesh.num_vertices())); });
    const auto turn = rotation_differences(impl.poses);
    const Jumps jump = jumps(impl.rest, impl.poses, turn);
    const Loads none = complete({}, body.mesh.num_vertices());
    impl.assemble(turn, jump, none, StressTerm::exact);
    const double assembly = timed([&] { impl.assemble(turn, jump, none, StressTerm::exact); });
    timed([&] { (void)impl.factorize(); });
    table.factorization = timed([&] { (void)impl.factorize(); });
    table.row("patches, three levels", timed([&] { segment(body.mesh, adjacency(body.mesh), {10, 5, 2.5}); }));
    table.row("ordering and analysis", ordering);
    table.row("assembly", assembly);
    table.row("factorization", table.factorization, text(impl.kept.num_entries(), " entries"));
    Eigen::VectorXd b = Eigen::VectorXd::Random(6L * impl.rest.num_free());
    impl.precondition(b);
    table.row("substitution", timed([&] {
                                  for (int i = 0; i < 5; ++i) b = impl.precondition(b) * 1e-3;
                              }) / 5);
    for (const int columns : {2, 3, 4, 8}) {
        Eigen::MatrixXd B = Eigen::MatrixXd::Random(b.size(), columns);
        table.row(text("substitution, ", columns, " right-hand sides"), timed([&] {
                                                                            for (int i = 0; i < 5; ++i)
                                                                                B = impl.precondition(B) * 1e-3;
                                                                        }) / 5);
    }
    table.row("product with the matrix", timed([&] {
                                             for (int i = 0; i < 5; ++i) b = impl.H.multiply(b) * 1e-3;
                                         }) / 5);
    table.row("jumps, gradient",
              timed([&] { energy_gradient(impl.rest, turn, jumps(impl.rest, impl.poses, turn), none); }));
    for (const double share : {0.1, 0.5}) cold_row(table, body, share);
    PrimoShell shell(body.mesh, body.options);
    warm_rows(table, shell, body.loads(0.1));
    inner_rows(table, body.mesh, shell, body.loads(0.1));
    std::printf("| peak memory | %.2f GB | | |\n", peak_gigabytes());
}

long resident_megabytes() {
    long total = 0, pages = 0;
    std::ifstream("/proc/self/statm") >> total >> pages;
    return pages * 4 / 1024;
}

void memory(const std::string& name, int solves) {
    const LoadedShell body(name);
    const Loads loads = body.loads(0.1);
    PrimoShell shell(body.mesh, body.options);
    SolveOptions options;
    options.keep_factor = true;
    const double before = cpu();
    int factorizations = 0;
    for (int k = 1; k <= solves; ++k) {
        factorizations += shell.solve(changed(loads, 0.02 * std::sin(k)), {}, options).factorizations;
        shell.adjoint({loads.force});
        if (k == 10 || k == 50 || k % 250 == 0 || k == solves)
            std::printf("%d warm solves: %ld MB, %d factorizations, %.3f s of CPU each\n", k, resident_megabytes(),
                        factorizations, (cpu() - before) / k);
    }
}

}  // namespace

int main(int count, char** words) {
    keep_large_blocks();
    double spring_distance = 0;
    int warm = 0;
    bool is_cold = false;
    Cold cold;
    std::vector<std::string> names;
    for (int i = 1; i < count; ++i)
        if (!std::strcmp(words[i], "--springs") && i + 1 < count)
            spring_distance = std::stod(words[++i]);
        else if (!std::strcmp(words[i], "--warm") && i + 1 < count)
            warm = std::stoi(words[++i]);
        else if (!std::strcmp(words[i], "--cold"))
            is_cold = true;
        else if (!std::strcmp(words[i], "--steps"))
            cold.shows_steps = true;
        else if (!std::strcmp(words[i], "--solver") && i + 1 < count)
            cold.solvers.emplace_back(words[++i]);
        else if (!std::strcmp(words[i], "--share") && i + 1 < count)
            cold.shares.push_back(std::stod(words[++i]));
        else
            names.emplace_back(words[i]);
    if (names.empty()) names = {"wing:22000", "wing:131000", "body:131000"};
    if (cold.solvers.empty()) cold.solvers = {"auto"};
    if (cold.shares.empty()) cold.shares = {0.1};
    for (const std::string& name : names)
        is_cold ? cold_only(name, cold) : warm > 0 ? memory(name, warm) : rows(name, spring_distance);
}
