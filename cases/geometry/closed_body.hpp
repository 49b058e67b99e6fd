#pragma once
#include "core/mesh/mesh.hpp"

#include <functional>

/// Smooth closed bodies given by a formula for their skin: sphere, superellipsoid, tube, fuselage with nacelles.
namespace strake::example {

/// Point of the right half of a skin: `along` in [0, 1] from nose to tail, `around` in [0, 1] from the top line over
/// the side (y > 0) to the bottom line. At both ends of `along` it is one point whatever `around`.
using BodySkin = std::function<Eigen::Vector3d(double along, double around)>;

/// Closed surface of that skin and its mirror image, symmetric in y bit for bit, with vertices on y = 0 and normals
/// pointing outward; edge length near uniform.
/// @param triangles wanted, 200 to 5 000 000; met within 5 %. @throws InvalidInput outside of it.
TriMesh closed_body(int triangles, const BodySkin& skin);

/// Sphere about the origin.
TriMesh sphere(int triangles, double radius = 1);

/// |x/a|^n + |y/b|^n + |z/c|^n = 1 about the origin: an ellipsoid at n = 2, a brick with round edges for larger n.
struct SuperellipsoidShape {
    Eigen::Vector3d half_axes{0.5, 0.4, 0.35};
    double exponent = 2.5;  ///< n, in [1, 10]
};
TriMesh superellipsoid(int triangles, const SuperellipsoidShape& shape = {});

/// Capsule of elliptic section along x, from x = 0 to `length`; the ends are half ellipsoids.
struct TubeShape {
    double length = 4;
    double half_width = 0.5;   ///< in y
    double half_height = 0.5;  ///< in z
};
TriMesh tube(int triangles, const TubeShape& shape = {});

/// Fuselage with a nacelle blended into either side. x downstream from the nose, y to the right, z up.
struct FuselageShape {
    double length = 6;
    double radius = 0.5;
    double nose = 0.2, tail = 0.4;                    ///< shares of the length that taper
    double nacelle_begin = 0.42, nacelle_end = 0.66;  ///< shares of the length
    double nacelle_height = 0.55;                     ///< out of the skin, over the radius
    double nacelle_angle_deg = 75;                    ///< of its axis from the top
    double nacelle_half_angle_deg = 38;
};
TriMesh fuselage(int triangles, const FuselageShape& shape = {});

}  // namespace strake::example
