#include "casefile/build/problem_builder.hpp"
#include "core/wrap/wrap_map.hpp"
#include "optimize/problem/shell_setup.hpp"

#include <algorithm>
#include <cmath>

namespace strake {

/// Per triangle: load variables may act there.
std::vector<char> ProblemBuilder::loaded_by_variables() const {
    const int m = elastic().mesh.num_triangles();
    std::vector<char> loaded(m, 0);
    const Parameters& p = out_.problem.parameters;
    const bool by_variables = std::any_of(p.kinds.begin(), p.kinds.end(), [](VariableKind kind) {
        return kind == VariableKind::load || kind == VariableKind::normal_load;
    });
    const bool is_search = !case_.objective.name.empty() || !case_.fit.empty();
    if (purpose_ != Purpose::deform && is_search && by_variables)
        for (int t = 0; t < m; ++t) loaded[t] = p.variables_on.empty() || p.variables_on[t];
    for (const UserVariable& v : p.user_variables)
        if (v.traction.rows() > 0)
            for (const int t : v.triangles) loaded[t] = 1;
    for (const auto& [twist, place] : twists_)
        for (const int t : twist.triangles) loaded[t] = 1;
    return loaded;
}

/// Springs under the loaded region: prescribed loads, and triangles that may carry load variables.
void ProblemBuilder::set_springs() {
    if (!case_.has_shell) return;
    const int m = elastic().mesh.num_triangles();
    Eigen::VectorXd own = Eigen::VectorXd::Zero(m);
    std::vector<char> loaded = loaded_by_variables(), has_own(m, 0);
    for (const LoadEntry& load : case_.loads)
        for (const int t : elastic_triangles(load.region)) {
            loaded[t] = 1;
            if (!load.spring) continue;
            has_own[t] = 1;
            own[t] += *load.spring;
        }
    for (int t = 0; t < m; ++t)
        if (loaded[t] && !has_own[t]) own[t] = case_.spring;
    if (own.maxCoeff() > 0) out_.problem.spring_per_area = own;
}

void ProblemBuilder::set_tractions() {
    Points& traction = out_.problem.given_traction;
    traction = Points::Zero(elastic().mesh.num_triangles(), 3);
    std::optional<PrimoShell> shell;
    ShellSetup setup;
    for (const LoadEntry& load : case_.loads) {
        const std::vector<int> loaded = elastic_triangles(load.region);
        double area = 0;
        for (const int t : loaded) area += elastic().area[t];
        Eigen::Vector3d value = Eigen::Vector3d::Zero();
        if (load.traction) value = *load.traction;
        if (load.force) value = *load.force / area;
        if (load.displacement)
            at(load.place, "", [&] {
                if (!shell) make_shell(shell, setup);
                value = scaled_traction(load, *shell, setup);
            });
        for (const int t : loaded) traction.row(t) += value.transpose();
    }
    // All loads zero is the same as no loads.
    if (traction.isZero(0)) traction.resize(0, 3);
}

/// The shell with everything but the loads.
void ProblemBuilder::make_shell(std::optional<PrimoShell>& shell, ShellSetup& setup) {
    Problem bare = out_.problem;
    bare.surface = start_.mesh;
    bare.given_traction.resize(0, 3);
    setup = shell_setup(bare);
    setup.motions.assign(setup.motions.size(), RigidMotion{});
    setup.options.expected_solves = 1;  // a load is a matrix of its own, solved once
    shell.emplace(elastic().mesh, setup.options);
}

/// The traction whose linear response, of this load alone, moves the surface by load.displacement.
Eigen::Vector3d ProblemBuilder::scaled_traction(const LoadEntry& load, PrimoShell& shell, const ShellSetup& setup) {
    const TriMesh& mesh = elastic().mesh;
    Points unit = Points::Zero(mesh.num_triangles(), 3);
    for (const int t : elastic_triangles(load.region)) unit.row(t) = load.direction.transpose();
    Loads loads{traction_forces(mesh, unit), setup.loads.spring};
    double largest = 0;
    try {
        Points moved = shell.linear_response(loads, setup.motions) - mesh.vertices;
        if (out_.problem.wrap) moved = out_.problem.wrap->displacement(moved);
        largest = moved.rowwise().norm().maxCoeff();
    } catch (const UnheldPart& e) {
        const std::string where = load.place.line < 0 ? " (--set)" : text(":", load.place.line, ":", load.place.column);
        throw UnheldPart(text(printable(case_.file.string(), 400), where, ": loads: ", e.what()));
    }
    // Below this it is round-off: the load acts on held vertices only.
    if (!(largest > 1e-12 * start_.diagonal * unit.norm() * elastic().area.sum()) || !std::isfinite(largest))
        throw InvalidInput(text("loads: a load on region '", load.region.name, "' along this direction moves nothing"));
    return load.direction * (load.displacement->in(start_.diagonal) / largest);
}

}  // namespace strake
