#pragma once
#include "core/mesh/point_tree.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <optional>

namespace strake {

/// Samples of a surface by levels: its vertices on level 0; on level l one sample per cell of edge spacing * 2^l, at
/// the area-weighted centroid of its vertices. Numbers run through all levels.
struct SurfaceSamples {
    struct Level {
        int first = 0;        ///< number of its first sample
        double spacing = 0;   ///< edge of the cells
        std::vector<int> of;  ///< per vertex: its sample, counted from `first`; -1 for vertices without area
        PointTree tree{Points(0, 3)};
    };
    std::vector<Level> levels;
    Points position;              ///< all samples
    Eigen::VectorXd area;         ///< all samples
    Eigen::VectorXd vertex_area;  ///< n
    int size() const { return static_cast<int>(area.size()); }

    /// Area-weighted mean over the vertices of each sample (rows), and its transpose.
    Points mean(const Points& at_vertices) const;
    Points transposed_mean(const Points& at_samples) const;
};

/// @param edge_length mean edge length per vertex; the finest spacing is their 1 % quantile.
/// @param symmetry cells are symmetric about this plane.
SurfaceSamples surface_samples(const TriMesh& mesh, const Eigen::VectorXd& edge_length,
                               const std::optional<SymmetryPlane>& symmetry);

}  // namespace strake
