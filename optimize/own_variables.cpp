#include "optimize/own_variables.hpp"

#include "core/error.hpp"

namespace strake {

void check_own(const std::vector<OwnVariable>& own) {
    for (std::size_t i = 0; i < own.size(); ++i) {
        const OwnVariable& v = own[i];
        if (v.name.empty() || v.name.find('.') != std::string::npos)
            throw InvalidInput(text("variable ", i, " is called '", v.name, "': a name without a dot is needed"));
        for (std::size_t k = 0; k < i; ++k)
            if (own[k].name == v.name) throw InvalidInput(text("two variables are called '", v.name, "'"));
        if (!std::isfinite(v.min) || !std::isfinite(v.max) || !(v.min < v.max))
            throw InvalidInput(text("variable ", v.name, ": min = ", v.min, " must be < max = ", v.max));
        if (!(v.min <= v.start && v.start <= v.max))
            throw InvalidInput(
                text("variable ", v.name, ": start = ", v.start, " must be in [", v.min, ", ", v.max, "]"));
    }
}

void append_own(DesignSpace& space) {
    const int before = space.size(), count = static_cast<int>(space.rest->own.size());
    if (count == 0) return;
    const int after = before + count;
    Eigen::MatrixXd metric = Eigen::MatrixXd::Identity(after, after);
    metric.topLeftCorner(before, before) = space.metric;
    space.metric = std::move(metric);
    space.lower.conservativeResize(after);
    space.upper.conservativeResize(after);
    for (int i = 0; i < count; ++i) {
        const OwnVariable& own = space.rest->own[i];
        Variable variable;
        variable.name = own.name;
        variable.kind = VariableKind::own;
        variable.patch = -1;
        variable.component = i;
        variable.unit = 0.5 * (own.max - own.min);
        variable.offset = own.start;
        space.lower[before + i] = (own.min - own.start) / variable.unit;
        space.upper[before + i] = (own.max - own.start) / variable.unit;
        space.variables.push_back(std::move(variable));
    }
}

std::vector<std::pair<std::string, double>> own_values(const DesignSpace& space, const Eigen::VectorXd& x) {
    std::vector<std::pair<std::string, double>> values;
    for (int i = 0; i < space.num_own(); ++i) {
        const OwnVariable& own = space.rest->own[i];
        const int j = space.num_shape() + i;
        // Round-off of the scaling is no reason to leave the bounds.
        values.emplace_back(own.name, std::clamp(own.start + x[j] * space.variables[j].unit, own.min, own.max));
    }
    return values;
}

Eigen::VectorXd own_units(const DesignSpace& space) {
    Eigen::VectorXd units(space.num_own());
    for (int i = 0; i < space.num_own(); ++i) units[i] = space.variables[space.num_shape() + i].unit;
    return units;
}

}  // namespace strake
