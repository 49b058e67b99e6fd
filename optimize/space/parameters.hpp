#pragma once
#include "optimize/space/design_space.hpp"

/// Parameters: design variables that are not shape. They stand behind the shape variables of every
/// level and are the same on all of them. Scaling: x = 0 is the start, and a change of x by 1 is half of what the
/// bounds allow: value = start + x (max - min) / 2. In the metric each has size 1 and no part in the others.
namespace strake {

/// Appends the parameters to a space that has none yet.
void append_parameters(DesignSpace& space);

/// Names and physical values, never outside of the bounds.
std::vector<std::pair<std::string, double>> parameter_values(const DesignSpace& space, const Eigen::VectorXd& x);

/// Values of changes of wings (`Parameters::planform`), all of them.
struct PlanformValue {
    std::string name;
    double value;  ///< radians, or a share
    bool is_angle;
};
std::vector<PlanformValue> planform_values(const DesignSpace& space, const Eigen::VectorXd& x);

/// What a record of a design lists beside the values of quantities: parameters, then changes of wings.
std::vector<std::string> recorded_names(const Problem& problem);
std::vector<double> recorded_values(const DesignSpace& space, const Eigen::VectorXd& x);

/// Change of the physical value per change of x (num_parameters()).
Eigen::VectorXd parameter_units(const DesignSpace& space);

}  // namespace strake
