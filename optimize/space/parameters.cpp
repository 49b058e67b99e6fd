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

std::vector<PlanformValue> planform_values(const DesignSpace& space, const Eigen::VectorXd& x) {
    std::vector<PlanformValue> all;
    const auto& planform = space.rest->parameters.planform;
    if (!planform) return all;
    const Eigen::VectorXd values = planform_change(space, x);
    for (int j = 0; j < planform->size(); ++j) {
        const PlanformMotion::Variable& variable = planform->variables()[static_cast<std::size_t>(j)];
        all.push_back({variable.name, values[j], is_angle(variable.change)});
    }
    return all;
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
    for (const PlanformValue& change : planform_values(space, x)) values.push_back(change.value);
    return values;
}

}  // namespace strake
