#pragma once

/// Pressure coefficients of a perfect gas in closed form. Angles in radians.
namespace strake {

/// Stagnation pressure coefficient behind a normal shock (Rayleigh's pitot formula):
///   2/(g M^2) ( ((g+1)^2 M^2 / (4 g M^2 - 2 (g-1)))^(g/(g-1)) (1 - g + 2 g M^2)/(g+1) - 1 )
/// 1.8088 at Mach 5, 1.8394 in the limit (gamma = 1.4). @throws InvalidInput unless mach >= 1 and 1 < gamma < 5/3 +
/// eps.
double stagnation_cp(double mach, double gamma);

/// Prandtl-Meyer function nu(M), M >= 1.
double prandtl_meyer_angle(double mach, double gamma);

struct PressureCoefficient {
    double cp = 0;
    double by_angle = 0;  ///< d cp / d turn
};
/// After an expansion of the free stream by the angle `turn` >= 0; the vacuum's -2/(g M^2) beyond the largest turn.
/// @pre mach > 1.
PressureCoefficient expanded_cp(double mach, double gamma, double turn);

}  // namespace strake
