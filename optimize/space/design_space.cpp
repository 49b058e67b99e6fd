#include "optimize/space/design_space.hpp"

#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/mesh/geometry.hpp"
#include "core/planform/planform_motion.hpp"
#include "optimize/space/shape_map.hpp"
#include "optimize/space/user_variables.hpp"

namespace strake {
namespace {

constexpr int block_size = 16;  ///< right-hand sides at a time: enough for BLAS 3, little memory

/// The traction of degrees of freedom, added to what is there.
void add_traction(const DesignSpace& space, const Eigen::VectorXd& value, Points& traction) {
    for (const Patch& patch : space.patches().patches) {
        const double* at = value.data() + patch_dof::count * patch.id;
        const Eigen::RowVector3d vector(at[patch_dof::load], at[patch_dof::load + 1], at[patch_dof::load + 2]);
        if (!vector.isZero(0))
            for (const int t : patch.triangles) traction.row(t) += vector;
        if (at[patch_dof::normal] != 0)
            for (const int t : patch.triangles) traction.row(t) += at[patch_dof::normal] * space.rest->normal.row(t);
    }
    add_user_traction(*space.rest, space.user_values(value), traction);
}

Points total_traction(const DesignSpace& space, const Eigen::VectorXd& value) {
    Points traction = Points::Zero(space.rest->elastic().num_triangles(), 3);
    if (space.rest->given_traction.rows() > 0) traction = space.rest->given_traction;
    if (space.carried_traction.rows() > 0) traction += space.carried_traction;
    add_user_traction(*space.rest, space.carried_user_values, traction);
    add_traction(space, value, traction);
    return traction;
}

/// h_v = h0_v exp(sum A_T s_T / sum A_T) over the triangles at v, s_T the logarithm of the triangle's factor.
Eigen::VectorXd heights(const DesignSpace& space, const Eigen::VectorXd& value) {
    const RestFacts& rest = *space.rest;
    if (!space.changes_height()) return rest.setup.options.prism_height;
    Eigen::VectorXd log_factor = space.carried_log_height.size() > 0
                                     ? space.carried_log_height
                                     : Eigen::VectorXd::Zero(rest.elastic().num_triangles());
    for (const Patch& patch : space.patches().patches)
        for (const int t : patch.triangles) log_factor[t] += value[patch_dof::count * patch.id + patch_dof::stiffness];
    const TriMesh& elastic = rest.elastic();
    const Eigen::VectorXd& vertex_area = rest.elastic_vertex_area();
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(elastic.num_vertices());
    for (int t = 0; t < elastic.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) mean[elastic.triangles(t, k)] += rest.area[t] / 3 * log_factor[t];
    Eigen::VectorXd h = rest.setup.options.prism_height;
    for (int v = 0; v < h.size(); ++v)
        if (vertex_area[v] > 0) h[v] *= std::exp(mean[v] / vertex_area[v]);
    return h;
}

std::vector<RigidMotion> motions(const DesignSpace& space, const Eigen::VectorXd& value) {
    std::vector<RigidMotion> all = space.rest->setup.motions;
    add_user_motions(*space.rest, space.user_values(value) + space.carried_user_values, all);
    for (std::size_t p = 0; p < space.motion.size(); ++p) {
        if (space.motion[p] < 0) continue;
        RigidMotion motion = space.carried_motion[p];
        const Eigen::Index at = patch_dof::count * static_cast<Eigen::Index>(p);
        motion.rotation += value.segment<3>(at + patch_dof::rotation);
        motion.translation += value.segment<3>(at + patch_dof::translation);
        all.push_back(motion);
    }
    return all;
}

/// Of fields, or of changes of wings: their values from those of all user variables.
Eigen::VectorXd values_by(int UserVariable::*number, int size, const RestFacts& rest, const Eigen::VectorXd& of_user) {
    Eigen::VectorXd values = Eigen::VectorXd::Zero(size);
    const auto& user = rest.parameters.user_variables;
    for (std::size_t g = 0; g < user.size(); ++g)
        if (const int k = user[g].*number; k >= 0) values[k] += of_user[static_cast<Eigen::Index>(g)];
    return values;
}

Eigen::VectorXd field_values(const RestFacts& rest, const Eigen::VectorXd& of_user) {
    return values_by(&UserVariable::field, rest.parameters.fields->size(), rest, of_user);
}

/// The transpose: dJ/d(value) into the entries of their user variables.
void add_gradient_by(int UserVariable::*number, const DesignSpace& space, const Eigen::VectorXd& by_value,
                     Eigen::VectorXd& gradient) {
    const auto& user = space.rest->parameters.user_variables;
    for (std::size_t g = 0; g < user.size(); ++g)
        if (const int k = user[g].*number; k >= 0) gradient[space.num_patch_dofs() + static_cast<int>(g)] = by_value[k];
}

Eigen::VectorXd planform_of(const DesignSpace& space, const Eigen::VectorXd& value) {
    return values_by(&UserVariable::planform, space.rest->parameters.planform->size(), *space.rest,
                     space.user_values(value) + space.carried_user_values);
}

void check_size(const DesignSpace& space, const Eigen::VectorXd& x) {
    if (x.size() != space.size())
        throw InvalidInput(text("x has ", x.size(), " entries, the space of level ", space.level, " has ", space.size(),
                                " variables"));
    if (!x.allFinite()) throw InvalidInput("x is not finite");
}

/// Vertex velocities per unit of a degree of freedom that is a motion.
Points motion_velocity(const DesignSpace& space, const std::vector<std::array<Points, 6>>& by_motion, int dof) {
    const int g = dof - space.num_patch_dofs();
    if (g < 0) return by_motion[space.motion[dof / patch_dof::count]][dof % patch_dof::count - patch_dof::rotation];
    const auto& by_component = by_motion[space.rest->setup.user_motion[g]];
    const RigidMotion& motion = space.rest->parameters.user_variables[g].motion;
    Points dv = Points::Zero(space.rest->elastic().num_vertices(), 3);
    for (int c = 0; c < 3; ++c)
        dv += motion.rotation[c] * by_component[c] + motion.translation[c] * by_component[3 + c];
    return dv;
}

/// dJ/d(log of the height's factor) per triangle.
Eigen::VectorXd log_height_gradient(const DesignSpace& space, const Eigen::VectorXd& value,
                                    const ShellSensitivities& sensitivities) {
    const RestFacts& rest = *space.rest;
    Eigen::VectorXd by_vertex = sensitivities.prism_height.cwiseProduct(heights(space, value));
    for (int v = 0; v < by_vertex.size(); ++v)
        by_vertex[v] = rest.elastic_vertex_area()[v] > 0 ? by_vertex[v] / rest.elastic_vertex_area()[v] : 0;
    const TriMesh& elastic = rest.elastic();
    Eigen::VectorXd by_triangle = Eigen::VectorXd::Zero(elastic.num_triangles());
    for (int t = 0; t < elastic.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) by_triangle[t] += rest.area[t] / 3 * by_vertex[elastic.triangles(t, k)];
    return by_triangle;
}

/// dv by a unit of the variable, a change of a wing, at x.
Points planform_response(const DesignSpace& space, int j, const Eigen::VectorXd* x) {
    const Variable& variable = space.variables[j];
    const Parameters& p = space.rest->parameters;
    const Eigen::VectorXd at =
        x ? planform_change(space, *x) : Eigen::VectorXd(Eigen::VectorXd::Zero(p.planform->size()));
    return variable.unit * p.planform->derivative(at, p.user_variables[variable.component].planform);
}

/// dJ/d(degree of freedom), all of them.
Eigen::VectorXd dof_gradient(const DesignSpace& space, const Eigen::VectorXd& value,
                             const ShellSensitivities& sensitivities) {
    const RestFacts& rest = *space.rest;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(space.num_dofs());
    if (const auto& fields = rest.parameters.fields; fields && sensitivities.vertex.rows() > 0)
        add_gradient_by(&UserVariable::field, space, fields->gradient(sensitivities.vertex), gradient);
    if (const auto& planform = rest.parameters.planform)  // not linear in its values
        add_gradient_by(
            &UserVariable::planform, space,
            planform->gradient(planform_of(space, value),
                               sensitivities.surface.rows() > 0 ? sensitivities.surface : sensitivities.vertex),
            gradient);
    if (!rest.has_shell) return gradient;
    const bool heights_count = space.changes_height();
    Eigen::VectorXd by_log_height;
    if (heights_count) by_log_height = log_height_gradient(space, value, sensitivities);
    const TriMesh& elastic = rest.elastic();
    for (int t = 0; t < elastic.num_triangles(); ++t) {
        double* at = gradient.data() + patch_dof::count * space.patches().label[t];
        const Eigen::RowVector3d by_traction = traction_gradient(rest, sensitivities.force, t);
        for (int c = 0; c < 3; ++c) at[patch_dof::load + c] += by_traction[c];
        at[patch_dof::normal] += by_traction.dot(rest.normal.row(t));
        if (heights_count) at[patch_dof::stiffness] += by_log_height[t];
    }
    const std::vector<RigidMotion> moved = motions(space, value);
    add_user_gradient(rest, space.num_patch_dofs(), moved, sensitivities, gradient);
    if (sensitivities.wrench.rows() == 0) return gradient;
    for (std::size_t p = 0; p < space.motion.size(); ++p) {
        if (space.motion[p] < 0) continue;
        Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
        for (const int t : space.core[p]) {
            Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
            for (int k = 0; k < 3; ++k) centroid += elastic.vertices.row(elastic.triangles(t, k)) / 3;
            sum += motion_twist(moved[space.motion[p]], centroid).transpose() * sensitivities.wrench.row(t).transpose();
        }
        gradient.segment<6>(patch_dof::count * static_cast<Eigen::Index>(p) + patch_dof::rotation) = sum;
    }
    return gradient;
}

/// dJ/dx by that of the degrees of freedom.
Eigen::VectorXd by_variable(const DesignSpace& space, const Eigen::VectorXd& by_dof) {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(space.size());
    for (int j = 0; j < space.size(); ++j)
        for (const DegreeOfFreedom& move : space.variables[j].moves)
            gradient[j] += by_dof[move.index] * move.factor * space.variables[j].unit;
    return gradient;
}

/// A block of load variables from the first one on. @return the variable behind it
int respond_to_loads(const DesignSpace& space, PrimoShell* shell, int first,
                     const std::function<void(int j, const Points& dv, const Points& of_shell)>& consume,
                     double tolerance, const Points* surface) {
    std::vector<Points> forces;
    int j = first;
    for (; j < space.size() && j - first < block_size && is_load(space.variables[j].kind); ++j)
        forces.push_back(load_forces(space, Eigen::VectorXd::Unit(space.size(), j)));
    const bool has_wrap = space.rest->wrap != nullptr;
    const std::vector<Points> moved = has_wrap ? shell->response(forces, tolerance)
                                               : surface_response(*space.rest, shell, forces, tolerance, surface);
    for (std::size_t i = 0; i < moved.size(); ++i)
        if (has_wrap)
            consume(first + static_cast<int>(i), carried(*space.rest, moved[i]), moved[i]);
        else
            consume(first + static_cast<int>(i), moved[i], moved[i]);
    return j;
}

}  // namespace

int DesignSpace::num_parameters() const {
    int count = 0;
    while (count < size() && variables[size() - 1 - count].kind == VariableKind::parameter) ++count;
    return count;
}

bool DesignSpace::changes_height() const {
    if (carried_log_height.size() > 0) return true;
    for (const Variable& variable : variables)
        if (variable.kind == VariableKind::stiffness) return true;
    return false;
}

Eigen::VectorXd dofs(const DesignSpace& space, const Eigen::VectorXd& x) {
    check_size(space, x);
    Eigen::VectorXd value = Eigen::VectorXd::Zero(space.num_dofs());
    for (int j = 0; j < space.size(); ++j)
        for (const DegreeOfFreedom& move : space.variables[j].moves)
            value[move.index] += x[j] * space.variables[j].unit * move.factor;
    return value;
}

ShellDemand demand(const DesignSpace& space, const Eigen::VectorXd& x) {
    const Eigen::VectorXd value = dofs(space, x);
    ShellDemand result;
    if (space.rest->has_shell) {
        result.loads.force =
            kept_forces(*space.rest, traction_forces(space.rest->elastic(), total_traction(space, value)));
        result.loads.spring = space.rest->setup.loads.spring;
        result.motions = motions(space, value);
        result.prism_height = heights(space, value);
    }
    if (space.rest->parameters.fields)
        result.fields = field_values(*space.rest, space.user_values(value) + space.carried_user_values);
    if (space.rest->parameters.planform) result.planform = planform_of(space, value);
    return result;
}

Eigen::VectorXd planform_change(const DesignSpace& space, const Eigen::VectorXd& x) {
    return planform_of(space, dofs(space, x));
}

bool ShellDemand::same_shell(const ShellDemand& other) const {
    const auto same_motion = [](const RigidMotion& a, const RigidMotion& b) {
        return a.rotation == b.rotation && a.translation == b.translation && a.about == b.about;
    };
    return loads.force.rows() == other.loads.force.rows() && loads.force == other.loads.force &&
           loads.spring.size() == other.loads.spring.size() && loads.spring == other.loads.spring &&
           prism_height.size() == other.prism_height.size() && prism_height == other.prism_height &&
           std::equal(motions.begin(), motions.end(), other.motions.begin(), other.motions.end(), same_motion);
}

Points load_forces(const DesignSpace& space, const Eigen::VectorXd& change) {
    Points traction = Points::Zero(space.rest->elastic().num_triangles(), 3);
    add_traction(space, dofs(space, change), traction);
    return kept_forces(*space.rest, traction_forces(space.rest->elastic(), traction));
}

Points field_motion(const DesignSpace& space, const Eigen::VectorXd& change, const Points* surface) {
    const RestFacts& rest = *space.rest;
    if (!rest.parameters.fields) return Points::Zero(rest.surface.num_vertices(), 3);
    const Eigen::VectorXd values = field_values(rest, space.user_values(dofs(space, change)));
    return surface_rates(rest, rest.parameters.fields->displacement(values), surface);
}

Eigen::VectorXd design_gradient(const DesignSpace& space, const Eigen::VectorXd& x,
                                const ShellSensitivities& sensitivities) {
    return by_variable(space, dof_gradient(space, dofs(space, x), sensitivities));
}

Eigen::VectorXd design_gradient_of_fields(const DesignSpace& space, const Eigen::VectorXd& by_field) {
    Eigen::VectorXd by_dof = Eigen::VectorXd::Zero(space.num_dofs());
    add_gradient_by(&UserVariable::field, space, by_field, by_dof);
    return by_variable(space, by_dof);
}

void design_response(const DesignSpace& space, PrimoShell* shell,
                     const std::function<void(int j, const Points& dv)>& consume, double tolerance,
                     const Points* surface, const Eigen::VectorXd* x) {
    design_response(
        space, shell, [&](int j, const Points& dv, const Points&) { consume(j, dv); }, tolerance, surface, x);
}

void design_response(const DesignSpace& space, PrimoShell* shell,
                     const std::function<void(int j, const Points& dv, const Points& of_shell)>& consume,
                     double tolerance, const Points* surface, const Eigen::VectorXd* x) {
    const Points none;
    std::vector<std::array<Points, 6>> by_motion;
    for (const Variable& variable : space.variables) {
        if (variable.kind == VariableKind::stiffness)
            throw InvalidInput(
                "stiffness variables cannot be fitted: their forward response is not available; use load, "
                "normal or strain variables, or `strake run` on the same target");
        if (variable.kind == VariableKind::strain && by_motion.empty()) by_motion = shell->motion_response();
    }
    for (int j = 0; j < space.size();) {
        if (space.variables[j].kind == VariableKind::parameter) {
            consume(j++, Points::Zero(space.rest->surface.num_vertices(), 3), none);
            continue;
        }
        if (space.variables[j].kind == VariableKind::field) {
            const Variable& variable = space.variables[j];
            const Parameters& p = space.rest->parameters;
            const Points moved = variable.unit * p.fields->field(p.user_variables[variable.component].field);
            consume(j++, surface_rates(*space.rest, moved, surface), none);
            continue;
        }
        if (space.variables[j].kind == VariableKind::planform) {
            consume(j, planform_response(space, j, x), none);
            ++j;
            continue;
        }
        if (space.variables[j].kind == VariableKind::strain) {
            Points dv = Points::Zero(space.rest->elastic().num_vertices(), 3);
            for (const DegreeOfFreedom& move : space.variables[j].moves)
                dv += motion_velocity(space, by_motion, move.index) * (move.factor * space.variables[j].unit);
            consume(j++, surface_rates(*space.rest, carried(*space.rest, dv), surface), none);
            continue;
        }
        j = respond_to_loads(space, shell, j, consume, tolerance, surface);
    }
}

std::vector<std::pair<std::string, double>> physical_values(const DesignSpace& space, const Eigen::VectorXd& x) {
    std::vector<std::pair<std::string, double>> values;
    for (int j = 0; j < space.num_shape(); ++j)
        values.emplace_back(space.variables[j].name, x[j] * space.variables[j].unit);
    return values;
}

}  // namespace strake
