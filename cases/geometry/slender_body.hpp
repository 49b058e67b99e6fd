#pragma once
#include "core/mesh/mesh.hpp"

/// Closed bodies of revolution about the x axis from x = 0 to their length, pointed at both ends.
namespace strake::example {

/// Radius of the Sears-Haack body, r = max_radius (4 k (1 - k))^(3/4), k = x / length: the least wave drag at given
/// length and volume V = 3 pi^2 / 16 max_radius^2 length.
double sears_haack_radius(double k, double max_radius);

/// A Sears-Haack body whose sectional areas are multiplied by 1 + waviness 4 k (1 - k) sin(2 pi waves k).
struct WavyBodyShape {
    double length = 10, max_radius = 0.5;
    double waviness = 0.3;  ///< in [0, 0.9]
    double waves = 2.5;
};
/// @param triangles wanted, 200 to 5 000 000; met within 5 %.
TriMesh wavy_body(int triangles, const WavyBodyShape& shape = {});

}  // namespace strake::example
