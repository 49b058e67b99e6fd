#pragma once
#include "objectives/quantity.hpp"

#include <array>

/// The direction of a flow and the axes in which its forces are told.
namespace strake {

/// An angle that is fixed, or the value of one of the case's own variables.
struct FlowAngle {
    double value = 0;           ///< radians
    std::string variable = {};  ///< not empty: its value counts, and derivatives by it are given
};

struct Stream {
    Eigen::Vector3d forward = Eigen::Vector3d::UnitX();  ///< where the air goes at zero angles; any length but zero
    Eigen::Vector3d up = Eigen::Vector3d::UnitZ();       ///< not parallel to it; only its part across counts
    FlowAngle alpha;                                     ///< of attack, nose up
    FlowAngle beta;                                      ///< of sideslip, wind from the right
};

/// Unit vectors. With X forward, Z up, Y = Z x X (to the right):
///   drag = cos a cos b X - sin b Y + sin a cos b Z     the direction of the flow
///   side = cos a sin b X + cos b Y + sin a sin b Z
///   lift = -sin a X + cos a Z
struct StreamAxes {
    Eigen::Vector3d drag, side, lift;
};
struct StreamState {
    Eigen::Vector3d x, y, z;             ///< X, Y, Z
    StreamAxes axes;                     ///< at the angles
    std::array<StreamAxes, 2> by_angle;  ///< derivatives by alpha and beta
    std::array<int, 2> own = {-1, -1};   ///< where alpha and beta stand among the own variables; -1: fixed
};

/// dJ/d(own variables) from the derivatives by alpha and beta; empty where both are fixed.
Eigen::VectorXd own_derivatives(const StreamState& at, const QuantityRequest& request,
                                const std::array<double, 2>& by_angle);
/// The same of a value that depends on the direction of the flow, `by_drag_axis` across it.
Eigen::VectorXd own_derivatives(const StreamState& at, const QuantityRequest& request,
                                const Eigen::Vector3d& by_drag_axis);

/// @throws InvalidInput: vectors that are zero, not finite or parallel; angles that are not finite.
void check_stream(const std::string& name, const Stream& stream);

/// @throws InvalidInput when a variable that is named is not among `own`.
StreamState stream_state(const std::string& name, const Stream& stream,
                         const std::vector<std::pair<std::string, double>>& own);

}  // namespace strake
