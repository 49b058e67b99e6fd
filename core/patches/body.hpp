#pragma once
#include "core/patches/segmentation.hpp"

#include <Eigen/Core>
#include <vector>

/// Measures of a surface for automatic levels. All converge under refinement, because the levels must be the same on
/// every triangulation of a body.
namespace strake {

struct Body {
    const SurfaceFeatures& features;
    Points normals, centroids;        ///< per triangle
    std::vector<double> edge_length;  ///< per edge
    double area = 0;
    Eigen::Vector3d centre;  ///< area centroid
    /// Columns: principal axes of the surface's second moments of area, longest extent first.
    Eigen::Matrix3d axes;

    const TriMesh& mesh() const { return features.mesh; }
    const Adjacency& adjacent() const { return features.adjacent; }
};

/// Principal axes whose moments differ by less than 2 % are arbitrary (a cube, a body of revolution): the coordinate
/// axes replace them. @throws InvalidInput when the area is zero.
Body measured(const SurfaceFeatures& features);

}  // namespace strake
