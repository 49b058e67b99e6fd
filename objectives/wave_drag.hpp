#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity.hpp"

/// Zero-lift wave drag in supersonic flow from the distribution of the sections' areas.
namespace strake {

struct WaveDrag {
    Eigen::Vector3d forward = Eigen::Vector3d::UnitX();  ///< where the air goes; any length but zero
    double mach = 1;            ///< 1: normal sections (slender body); > 1: oblique ones, averaged over the roll angle
    int stations = 40;          ///< inner ones, in [4, 400]
    int angles = 8;             ///< roll angles around the circle, with mach > 1, in [1, 360]
    double reference_area = 1;  ///< > 0
    /// Per triangle: belongs to a base, behind which the body goes on as a cylinder (its wake or jet); empty: none.
    std::vector<char> base = {};
};

/// D / (q reference_area) by von Karman's slender-body integral
///   D/q = -1/(2 pi) int int S''(x) S''(y) ln |x - y| dx dy
/// of the smoothest distribution through the sections' areas S_i (Eminton and Lord): among all with S' = 0 at the ends
/// that pass through them the one of least drag, so that
///   D/q = 4/pi (B/L)^2 + 4 pi/L^2 sum c_i (P^-1)_ij c_j,   B = S_n - S_0,   c_i = S_i - S_0 - B u(k_i)
/// a quadratic form in the areas: never negative, and below the integral for finitely many stations, rising towards it.
/// Above Mach 1 the mean over roll angles phi of that for sections m . x = constant, m = X - beta (cos phi Y + sin phi
/// Z), beta^2 = M^2 - 1 (area rule of Harris). The ends are those of the surface along m; S_0 and S_n are taken 0.1 %
/// of the length inside of them. Oblique sections see a flat base as a tail that closes within a few radii, unless its
/// triangles are left out by `base`. The base's own drag is not in it. With `symmetry` half of the whole body's drag.
/// Kinks: where another vertex becomes the first or last along a m; a triangle parallel to a section makes S jump.
/// Cost: one pass over the triangles for each roll angle.
/// @throws InvalidInput: numbers outside of their limits, an open surface, a plane of symmetry that the flow crosses.
Quantity wave_drag(const std::string& name, const TriMesh& start, const WaveDrag& flow,
                   const std::optional<SymmetryPlane>& symmetry = {});

/// P_ij = sum over n >= 2 of g_n(k_i) g_n(k_j) / n, g_n(k) = sin((n-1) t)/(n-1) - sin((n+1) t)/(n+1), cos t = 1 - 2 k,
/// in closed form (four times the matrix of Eminton and Lord), for stations k in (0, 1); and u(k).
Eigen::MatrixXd eminton_matrix(const std::vector<double>& stations);
double eminton_base(double k);

}  // namespace strake
