#include "optimize/design_space.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

namespace strake {
namespace {

constexpr int block_size = 16;  ///< right-hand sides at a time: enough for BLAS 3, little memory

void add_traction(const DesignSpace& space, const Variable& variable, double value, Points& traction) {
    for (const int t : space.patches().patches[variable.patch].triangles) {
        if (variable.kind == VariableKind::load)
            traction(t, variable.component) += value;
        else
            traction.row(t) += value * space.rest->normal.row(t);
    }
}

bool is_load(VariableKind kind) { return kind == VariableKind::load || kind == VariableKind::load_normal; }

Points total_traction(const DesignSpace& space, const Eigen::VectorXd& x) {
    Points traction = Points::Zero(space.rest->surface.num_triangles(), 3);
    if (space.rest->given_traction.rows() > 0) traction = space.rest->given_traction;
    if (space.carried_traction.rows() > 0) traction += space.carried_traction;
    for (int j = 0; j < space.size(); ++j)
        if (is_load(space.variables[j].kind))
            add_traction(space, space.variables[j], x[j] * space.variables[j].unit, traction);
    return traction;
}

/// h_v = h0_v exp(sum A_T s_T / sum A_T) over the triangles at v, s_T the logarithm of the triangle's factor.
Eigen::VectorXd heights(const DesignSpace& space, const Eigen::VectorXd& x) {
    const RestFacts& rest = *space.rest;
    if (!space.changes_height()) return rest.setup.options.prism_height;
    Eigen::VectorXd log_factor = space.carried_log_height.size() > 0
                                     ? space.carried_log_height
                                     : Eigen::VectorXd::Zero(rest.surface.num_triangles());
    for (int j = 0; j < space.size(); ++j)
        if (space.variables[j].kind == VariableKind::stiffness)
            for (const int t : space.patches().patches[space.variables[j].patch].triangles)
                log_factor[t] += x[j] * space.variables[j].unit;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(rest.surface.num_vertices());
    for (int t = 0; t < rest.surface.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) mean[rest.surface.triangles(t, k)] += rest.area[t] / 3 * log_factor[t];
    Eigen::VectorXd h = rest.setup.options.prism_height;
    for (int v = 0; v < h.size(); ++v)
        if (rest.vertex_area[v] > 0) h[v] *= std::exp(mean[v] / rest.vertex_area[v]);
    return h;
}

std::vector<RigidMotion> motions(const DesignSpace& space, const Eigen::VectorXd& x) {
    std::vector<RigidMotion> all = space.rest->setup.motions;
    for (std::size_t p = 0; p < space.motion.size(); ++p)
        if (space.motion[p] >= 0) all.push_back(space.carried_motion[p]);
    for (int j = 0; j < space.size(); ++j) {
        const Variable& variable = space.variables[j];
        if (variable.kind != VariableKind::strain) continue;
        RigidMotion& motion = all[space.motion[variable.patch]];
        const double value = x[j] * variable.unit;
        (variable.component < 3 ? motion.rotation[variable.component] : motion.translation[variable.component - 3]) +=
            value;
    }
    return all;
}

void check_size(const DesignSpace& space, const Eigen::VectorXd& x) {
    if (x.size() != space.size())
        throw InvalidInput(text("x has ", x.size(), " entries, the space of level ", space.level, " has ", space.size(),
                                " variables"));
    if (!x.allFinite()) throw InvalidInput("x is not finite");
}

}  // namespace

bool DesignSpace::changes_height() const {
    if (carried_log_height.size() > 0) return true;
    for (const Variable& variable : variables)
        if (variable.kind == VariableKind::stiffness) return true;
    return false;
}

ShellDemand demand(const DesignSpace& space, const Eigen::VectorXd& x) {
    check_size(space, x);
    ShellDemand result;
    result.loads.force = traction_forces(space.rest->surface, total_traction(space, x));
    result.loads.spring = space.rest->setup.loads.spring;
    result.motions = motions(space, x);
    result.prism_height = heights(space, x);
    return result;
}

Eigen::VectorXd design_gradient(const DesignSpace& space, const Eigen::VectorXd& x,
                                const ShellSensitivities& sensitivities) {
    check_size(space, x);
    const RestFacts& rest = *space.rest;
    const int m = rest.surface.num_triangles();
    Points by_traction = Points::Zero(m, 3);
    for (int t = 0; t < m; ++t)
        for (int k = 0; k < 3; ++k)
            by_traction.row(t) += rest.area[t] / 3 * sensitivities.force.row(rest.surface.triangles(t, k));
    Eigen::VectorXd by_log_height;  // per vertex: dJ/dh h / (area around it)
    if (space.changes_height()) {
        by_log_height = sensitivities.prism_height.cwiseProduct(heights(space, x));
        for (int v = 0; v < by_log_height.size(); ++v)
            by_log_height[v] = rest.vertex_area[v] > 0 ? by_log_height[v] / rest.vertex_area[v] : 0;
    }
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(space.size());
    for (int j = 0; j < space.size(); ++j) {
        const Variable& variable = space.variables[j];
        double sum = 0;
        if (variable.kind == VariableKind::strain)
            sum = sensitivities.motion[space.motion[variable.patch]][variable.component];
        else
            for (const int t : space.patches().patches[variable.patch].triangles) {
                if (variable.kind == VariableKind::load)
                    sum += by_traction(t, variable.component);
                else if (variable.kind == VariableKind::load_normal)
                    sum += by_traction.row(t).dot(rest.normal.row(t));
                else
                    for (int k = 0; k < 3; ++k) sum += rest.area[t] / 3 * by_log_height[rest.surface.triangles(t, k)];
            }
        gradient[j] = sum * variable.unit;
    }
    return gradient;
}

void design_response(const DesignSpace& space, PrimoShell& shell,
                     const std::function<void(int j, const Points& dv)>& consume) {
    std::vector<std::array<Points, 6>> by_motion;
    for (const Variable& variable : space.variables) {
        if (variable.kind == VariableKind::stiffness)
            throw InvalidInput(
                "stiffness variables cannot be fitted: their forward response is not available; use load, "
                "load_normal or strain variables, or `strake run` on the same target");
        if (variable.kind == VariableKind::strain && by_motion.empty()) by_motion = shell.motion_response();
    }
    for (int j = 0; j < space.size();) {
        const Variable& variable = space.variables[j];
        if (variable.kind == VariableKind::strain) {
            consume(j, by_motion[space.motion[variable.patch]][variable.component] * variable.unit);
            ++j;
            continue;
        }
        std::vector<Points> forces;
        const int first = j;
        for (; j < space.size() && j - first < block_size && is_load(space.variables[j].kind); ++j) {
            Points traction = Points::Zero(space.rest->surface.num_triangles(), 3);
            add_traction(space, space.variables[j], space.variables[j].unit, traction);
            forces.push_back(traction_forces(space.rest->surface, traction));
        }
        const std::vector<Points> moved = shell.response(forces);
        for (std::size_t i = 0; i < moved.size(); ++i) consume(first + static_cast<int>(i), moved[i]);
    }
}

std::vector<std::pair<std::string, double>> physical_values(const DesignSpace& space, const Eigen::VectorXd& x) {
    std::vector<std::pair<std::string, double>> values;
    for (int j = 0; j < space.size(); ++j) values.emplace_back(space.variables[j].name, x[j] * space.variables[j].unit);
    return values;
}

}  // namespace strake
