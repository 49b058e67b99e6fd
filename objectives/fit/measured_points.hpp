#pragma once
#include "objectives/quantity/quantity.hpp"

#include <filesystem>

/// Distance of measured points (from a scan or a coordinate measuring machine) to the surface.
namespace strake {

struct MeasuredPoint {
    Eigen::Vector3d at;
    double weight = 1;  ///< >= 0; only ratios count
};

/// J = sum w_i d_i^2 / sum w, length squared: the weighted mean square distance of the points to the closest point of
/// the surface. Residuals are d_i sqrt(w_i / sum w), positive on the side of the normals, dd_i/dv_k = -u_i b_ik: u the
/// direction from the surface to the point, b the barycentric coordinates of the closest point. Exact wherever that
/// point is unique.
/// @throws InvalidInput: no points; a point or weight that is not finite; a negative weight; no positive weight.
Quantity measured_points(const std::string& name, const TriMesh& start, const std::vector<MeasuredPoint>& points);

/// Rows x,y,z[,weight]. @throws InputError `FILE:LINE: what`.
std::vector<MeasuredPoint> read_measured_points(const std::filesystem::path& file);

}  // namespace strake
