#pragma once
#include "core/mesh/mesh.hpp"

/// Distance between surfaces with different triangulations.
namespace strake {

/// From one surface to the other, sampled at vertices, edge midpoints and triangle centroids: `max` is a lower bound of
/// the true maximum and misses only features between samples. Mean and root mean square are integrals over the first
/// surface (its triangles' edge midpoints, exact for quadratics).
struct SurfaceDistance {
    double max = 0, mean = 0, rms = 0;                  ///< length
    Eigen::Vector3d at = Eigen::Vector3d::Zero();       ///< where it is largest, on the first surface
    Eigen::Vector3d nearest = Eigen::Vector3d::Zero();  ///< closest point on the other surface
    int triangle = -1;                                  ///< of the first surface, where that is
    Eigen::VectorXd at_vertices;                        ///< n, of the first surface; NaN in no listed triangle
};

/// @param triangles of `from` that count, any order; empty: all. @throws InvalidInput: a surface without triangles, or
/// with a vertex that is not finite.
SurfaceDistance surface_distance(const TriMesh& from, const TriMesh& to, const std::vector<int>& triangles = {});

}  // namespace strake
