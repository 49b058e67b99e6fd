#pragma once
#include "objectives/aero/stream.hpp"

/// Forces of a hypersonic flow by modified Newtonian pressures, triangle by triangle.
namespace strake {

enum class LeewardPressure {
    zero,          ///< Cp = 0
    prandtl_meyer  ///< Prandtl-Meyer expansion of the free stream by the surface's angle, down to vacuum
};

struct NewtonianFlow {
    Stream stream;
    double mach = 10;                   ///< >= 1; > 1 for prandtl_meyer
    double gamma = 1.4;                 ///< in (1, 2]
    std::optional<double> cp_max = {};  ///< > 0; default: Rayleigh's pitot formula
    LeewardPressure leeward = LeewardPressure::zero;
    bool shadows = true;  ///< parts hidden from the stream have no pressure
    Eigen::Vector3d moment_center = Eigen::Vector3d::Zero();
    double reference_area = 1, reference_length = 1;  ///< > 0
    /// Whether side, roll and yaw are among the values: a half model at no sideslip has none, but for those of its half
    /// alone.
    bool has_side_values = true;
};

/// Values, in this order: name.drag, .lift, .side, .lift_to_drag, .roll, .pitch, .yaw. Forces are divided by dynamic
/// pressure and reference area, along the axes of the stream; moments also by the reference length, about the body's
/// axes (right wing down, nose up, nose right). With both references 1, forces are areas. A half model gives the
/// coefficients of the half.
///   F = - sum Cp_t nu_t s_t,   M = sum (c_t - moment_center) x F_t,   Cp = cp_max (u . n)^2 where u . n < 0
/// s_t is the outward area vector, c_t the centroid, u the flow's direction and nu_t the share of the triangle that the
/// stream reaches (`VisibleAreas`). The surface must be oriented outward.
/// Smooth where u . n passes zero with leeward pressure `zero`; with `prandtl_meyer` the pressure has a kink there, and
/// on a base square to the stream below Mach 2.56 (gamma = 1.4; above, the base has the vacuum's pressure). Derivatives
/// on such a base take its pressure as constant.
/// Field name.cp: Cp nu at each vertex, the area-weighted mean over its triangles.
/// @throws InvalidInput: numbers outside their limits; a start surface that is inside out (closed, with negative
/// volume).
Quantity newtonian(const std::string& name, const TriMesh& start, const NewtonianFlow& flow);

/// One of side, roll, yaw.
inline bool is_side_value(const std::string& name) { return name == "side" || name == "roll" || name == "yaw"; }
inline const std::vector<std::string> newtonian_values{"drag", "lift", "side", "lift_to_drag", "roll", "pitch", "yaw"};

}  // namespace strake
