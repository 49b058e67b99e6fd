#pragma once
#include "objectives/quantity/quantity.hpp"

#include <array>

/// Direction of the flow and axes of its forces.
namespace strake {

/// A fixed angle, or a parameter of the case.
struct FlowAngle {
    double value = 0;           ///< radians
    std::string variable = {};  ///< not empty: name of the parameter; its value and derivative are used
};

struct Stream {
    Eigen::Vector3d forward = Eigen::Vector3d::UnitX();  ///< direction of the flow at zero angles; any nonzero length
    Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< not parallel to `forward`; only the perpendicular part counts
    FlowAngle alpha;                                ///< angle of attack, nose up
    FlowAngle beta;                                 ///< angle of sideslip, wind from the right
};

/// Unit vectors. With X forward, Z up, Y = Z x X (to the right):
///   drag = cos a cos b X - sin b Y + sin a cos b Z     the direction of the flow
///   side = cos a sin b X + cos b Y + sin a sin b Z
///   lift = -sin a X + cos a Z
struct StreamAxes {
    Eigen::Vector3d drag, side, lift;
};
struct StreamState {
    Eigen::Vector3d x, y, z;                   ///< X, Y, Z
    StreamAxes axes;                           ///< at the angles
    std::array<StreamAxes, 2> by_angle;        ///< derivatives by alpha and beta
    std::array<int, 2> parameters = {-1, -1};  ///< positions of alpha and beta among the parameters; -1: fixed
};

/// dJ/d(parameters) from the derivatives by alpha and beta; empty when both are fixed.
Eigen::VectorXd own_derivatives(const StreamState& at, const QuantityRequest& request,
                                const std::array<double, 2>& by_angle);
/// The same for a value that depends on the flow's direction; `by_drag_axis` is its derivative by that direction.
Eigen::VectorXd own_derivatives(const StreamState& at, const QuantityRequest& request,
                                const Eigen::Vector3d& by_drag_axis);

/// @throws InvalidInput: vectors that are zero, not finite or parallel; angles that are not finite.
void check_stream(const std::string& name, const Stream& stream);

/// @throws InvalidInput when an angle names an unknown parameter.
StreamState stream_state(const std::string& name, const Stream& stream,
                         const std::vector<std::pair<std::string, double>>& parameters);

}  // namespace strake
