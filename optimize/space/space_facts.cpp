#include "optimize/space/space_facts.hpp"

#include "optimize/space/rest_shell.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <ctime>

namespace strake {
namespace {

constexpr double still = 1e-6;  ///< of a variable's largest displacement: does not move

/// Stiffness has no response, and what the response is asked of must not have any.
DesignSpace without_stiffness(const DesignSpace& space) {
    DesignSpace copy = space;
    std::erase_if(copy.variables, [](const Variable& v) { return v.kind == VariableKind::stiffness; });
    return copy;
}

double condition_of(const DesignSpace& space) {
    const int n = space.num_shape();
    if (n == 0 || space.metric.rows() < n) return std::numeric_limits<double>::quiet_NaN();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(space.metric.topLeftCorner(n, n),
                                                               Eigen::EigenvaluesOnly);
    return eigen.eigenvalues()[n - 1] / eigen.eigenvalues()[0];
}

}  // namespace

SpaceFacts space_facts(const DesignSpace& space, const std::function<void(const Variable&, const Points&)>& mode) {
    SpaceFacts facts;
    facts.level = space.level;
    facts.patches = static_cast<int>(space.patches().patches.size());
    for (const Variable& variable : space.variables) facts.names.push_back(variable.name);
    for (const DependentVariable& out : space.dependent) facts.dependent.push_back(out.variable.name);
    facts.notes = space.notes;
    facts.changes_height = space.changes_height();
    facts.condition = condition_of(space);
    facts.moves.assign(static_cast<std::size_t>(space.rest->surface.num_vertices()), 0);
    const DesignSpace moving = without_stiffness(space);
    if (moving.num_shape() == 0) return facts;
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t cpu_begin = std::clock();
    const std::unique_ptr<PrimoShell> shell = shell_at_rest(moving);
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    // What others do on this machine now is no property of the case.
    facts.rest_seconds = std::min(wall, static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC);
    design_response(moving, shell.get(), [&](int j, const Points& dv) {
        const Variable& variable = moving.variables[static_cast<std::size_t>(j)];
        if (variable.kind == VariableKind::parameter) return;
        const Eigen::VectorXd size = dv.rowwise().norm();
        const double least = still * size.maxCoeff();
        for (Eigen::Index v = 0; v < size.size(); ++v) facts.moves[static_cast<std::size_t>(v)] |= size[v] > least;
        if (mode) mode(variable, dv);
    });
    return facts;
}

}  // namespace strake
