#pragma once
#include "core/fields/field_functions.hpp"
#include "core/fields/thin_products.hpp"
#include "core/fields/wing_coordinates.hpp"

#include <optional>

/// The functions of displacement fields and their sums at points. Internal to core/fields.
namespace strake {

/// Functions at one point; room for them is made once.
class LocalFunctions {
public:
    explicit LocalFunctions(const FunctionSpace& space);
    void set(const Eigen::Vector3d& x);
    double value(const Powers& p) const;
    double slope(const Powers& p, int k) const;  ///< along the axis k of the frame, per length

private:
    const FunctionSpace& space_;
    std::vector<FunctionsAlong> along_;
    std::optional<WingFunctions> of_wing_;
};

/// A sum of functions and its gradient at many points. Functions that differ along the axis alone are summed there
/// first.
class FunctionSum {
public:
    FunctionSum(const FunctionSpace& space, const Coefficients& c);
    /// Column k of the gradient: along the axis k of the frame, per length.
    void at(const Eigen::Vector3d& x, Eigen::Vector3d& value, Eigen::Matrix3d& by_local);

private:
    struct Group {
        int second, third;        ///< numbers of the functions across the axis
        std::vector<int> along;   ///< and of those along it
        Eigen::Matrix3Xd factor;  ///< a column for each of these
    };
    void at_wing(const Eigen::Vector3d& x, Eigen::Vector3d& value, Eigen::Matrix3d& by_local);

    const FunctionSpace& space_;
    std::vector<FunctionsAlong> along_;
    std::vector<Group> groups_;
    std::optional<WingFunctions> of_wing_;
    std::vector<std::pair<Powers, Eigen::Vector3d>> terms_;  ///< of a wing
};

}  // namespace strake
