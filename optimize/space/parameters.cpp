#include "optimize/space/parameters.hpp"

#include "core/planform/planform_motion.hpp"
namespace strake {

void append_parameters(DesignSpace& space) {
    const int before = space.size(), count = static_cast<int>(space.rest->program_parameters.size());
    if (count == 0) return;
    const int after = before + count;
    Eigen::MatrixXd metric = Eigen::MatrixXd::Identity(after, after);
    metric.topLeftCorner(before, before) = space.metric;
    space.metric = std::move(metric);
    space.lower.conservativeResize(after);
    space.upper.conservativeResize(after);
    for (int i = 0; i < count; ++i) {
        const ProgramParameter& parameter = space.rest->program_parameters[i];
        Variable variable;
        variable.name = parameter.name;
        variable.kind = VariableKind::parameter;
        variable.patch = -1;
        variable.component = i;
        variable.unit = 0.5 * (parameter.max - parameter.min);
        variable.offset = parameter.start;
        space.lower[before + i] = (parameter.min - parameter.start) / variable.unit;
        space.upper[before + i] = (parameter.max - parameter.start) / variable.unit;
        space.variables.push_back(std::move(variable));
    }
}

std::vector<std::pair<std::string, double>> parameter_values(const DesignSpace& space, const Eigen::VectorXd& x) {
    std::vector<std::pair<std::string, double>> values;
    for (int i = 0; i < space.num_parameters(); ++i) {
        const ProgramParameter& parameter = space.rest->program_parameters[i];
        const int j = space.num_shape() + i;
        // Round-off of the scaling is no reason to leave the bounds.
        values.emplace_back(parameter.name,
                            std::clamp(parameter.start + x[j] * space.variables[j].unit, parameter.min, parameter.max));
    }
    return values;
}

Eigen::VectorXd parameter_units(const DesignSpace& space) {
    Eigen::VectorXd units(space.num_parameters());
    for (int i = 0; i < space.num_parameters(); ++i) units[i] = space.variables[space.num_shape() + i].unit;
    return units;
}

std::vector<std::pair<std::string, double>> planform_values(const DesignSpace& space, const Eigen::VectorXd& x) {
    std::vector<std::pair<std::string, double>> all;
    const auto& planform = space.rest->parameters.planform;
    if (!planform) return all;
    const auto& user = space.rest->parameters.user_variables;
    const Eigen::VectorXd values = space.user_values(dofs(space, x)) + space.carried_user_values;
    for (std::size_t g = 0; g < user.size(); ++g)
        if (user[g].planform >= 0) all.emplace_back(user[g].name, values[static_cast<Eigen::Index>(g)]);
    return all;
}

bool is_planform_angle(const RestFacts& rest, const std::string& name) {
    if (!rest.parameters.planform) return false;
    for (const PlanformMotion::Variable& v : rest.parameters.planform->variables())
        if (v.name == name) return is_angle(v.change);
    return false;
}

std::vector<std::string> recorded_names(const Problem& problem) {
    std::vector<std::string> names;
    for (const ProgramParameter& variable : problem.program_parameters) names.push_back(variable.name);
    for (const UserVariable& variable : problem.parameters.user_variables)
        if (variable.planform >= 0) names.push_back(variable.name);
    return names;
}

std::vector<double> recorded_values(const DesignSpace& space, const Eigen::VectorXd& x) {
    std::vector<double> values;
    for (const auto& [name, value] : parameter_values(space, x)) values.push_back(value);
    for (const auto& [name, value] : planform_values(space, x)) values.push_back(value);
    return values;
}

}  // namespace strake
