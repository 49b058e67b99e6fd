#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity/quantity.hpp"

/// Zero-lift wave drag in supersonic flow from the area distribution of its sections.
namespace strake {

struct WaveDrag {
    Eigen::Vector3d forward = Eigen::Vector3d::UnitX();  ///< direction of the flow; any nonzero length
    double mach = 1;            ///< 1: normal sections (slender body); > 1: oblique ones, averaged over the roll angle
    int stations = 40;          ///< interior stations, in [4, 400]
    int angles = 8;             ///< roll angles roll angles, for mach > 1, in [1, 360]
    double reference_area = 1;  ///< > 0
    /// Per triangle: part of a base, which the wake or jet extends as a cylinder; empty: none.
    std::vector<char> base = {};
    /// A closed surface that stays where it is; its areas are added to those of the surface. Empty: none. Where it lies
    /// within the surface it counts twice. With `symmetry` the half of it, too.
    TriMesh beside = {};
};

/// D / (q reference_area) by von Karman's slender-body integral
///   D/q = -1/(2 pi) int int S''(x) S''(y) ln |x - y| dx dy
/// of the smoothest distribution through the sections' areas S_i (Eminton and Lord), the one of least drag among all
/// that interpolate them with S' = 0 at the ends:
///   D/q = 4/pi (B/L)^2 + 4 pi/L^2 sum c_i (P^-1)_ij c_j,   B = S_n - S_0,   c_i = S_i - S_0 - B u(k_i)
/// This quadratic form in the areas is never negative. It underestimates the integral and converges to it from below as
/// stations are added. Above Mach 1: the mean of that over roll angles phi, for sections m . x = constant, m = X - beta
/// (cos phi Y + sin phi Z), beta^2 = M^2 - 1 (area rule of Harris). The ends are those of the surface along m; S_0 and
/// S_n are taken 0.1 % of the length inside them. Oblique sections see a flat base as a tail that closes within a few
/// radii; list its triangles in `base` to avoid this. Base drag is not included. With `symmetry`: half the drag of the
/// whole body. Kinks: where another vertex becomes the first or last along m; a triangle parallel to a section makes S
/// jump. Cost: one pass over the triangles for each roll angle.
/// @throws InvalidInput: numbers outside their limits; an open surface, or one beside it; a flow that crosses the plane
/// of symmetry.
Quantity wave_drag(const std::string& name, const TriMesh& start, const WaveDrag& flow,
                   const std::optional<SymmetryPlane>& symmetry = {});

/// P_ij = sum over n >= 2 of g_n(k_i) g_n(k_j) / n, g_n(k) = sin((n-1) t)/(n-1) - sin((n+1) t)/(n+1), cos t = 1 - 2 k,
/// in closed form (four times the matrix of Eminton and Lord), for stations k in (0, 1); and u(k).
Eigen::MatrixXd eminton_matrix(const std::vector<double>& stations);
double eminton_base(double k);

}  // namespace strake
