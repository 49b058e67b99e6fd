#pragma once
#include "objectives/stream.hpp"

/// Forces of a hypersonic flow by modified Newtonian pressures, triangle by triangle.
namespace strake {

enum class LeeSide {
    zero,          ///< Cp = 0
    prandtl_meyer  ///< the free stream expanded by the angle that the surface turns away, down to the vacuum
};

struct NewtonianFlow {
    Stream stream;
    double mach = 10;                   ///< >= 1; > 1 for prandtl_meyer
    double gamma = 1.4;                 ///< in (1, 2]
    std::optional<double> cp_max = {};  ///< > 0; without it by Rayleigh's pitot formula
    LeeSide lee = LeeSide::zero;
    bool shadows = true;                              ///< what lies behind other parts of the surface feels nothing
    Eigen::Vector3d about = Eigen::Vector3d::Zero();  ///< point of the moments
    double reference_area = 1, reference_length = 1;  ///< > 0
};

/// Values, in this order: name.drag, .lift, .side, .lift_to_drag, .roll, .pitch, .yaw: forces over dynamic pressure and
/// reference area, along the axes of the stream; moments over these and the reference length, about the body's axes
/// (right wing down, nose up, nose right). With both references 1 forces are areas. A half model's are those of the
/// half.
///   F = - sum Cp_t nu_t s_t,   M = sum (c_t - about) x F_t,   Cp = cp_max (u . n)^2 where u . n < 0
/// s_t is the outward area vector, c_t the centroid, u the flow's direction and nu_t the share of the triangle that the
/// stream reaches (`VisibleAreas`). The surface must be oriented outward.
/// Smooth where u . n passes zero with lee side `zero`; with `prandtl_meyer` the pressure has a kink there.
/// Its field is name.cp: Cp nu, the mean over the triangles at the vertex by their areas.
/// @throws InvalidInput: numbers outside of their limits; a start surface that is turned inside out (closed, negative
/// volume).
Quantity newtonian(const std::string& name, const TriMesh& start, const NewtonianFlow& flow);

inline const std::vector<std::string> newtonian_values{"drag", "lift", "side", "lift_to_drag", "roll", "pitch", "yaw"};

}  // namespace strake
