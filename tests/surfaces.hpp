#pragma once
#include "core/mesh/mesh.hpp"

/// Small surfaces of known shape for tests. All closed ones are oriented outward.
namespace strake {

TriMesh box_surface(const Eigen::Vector3d& size = Eigen::Vector3d::Ones(), int cells = 1);  ///< corner at the origin
TriMesh icosphere(int subdivisions);                                                        ///< unit radius
/// Rectangle [0, length] x [0, width] in the plane z = 0; `pattern` 0 aligned, 1 union jack.
TriMesh strip(double length, double width, int cells_x, int cells_y, int pattern = 1);
TriMesh hinge(double edge, double depth);  ///< two coplanar triangles, shared edge along y through the origin, apexes
                                           ///< at (-depth, 0, 0) and (depth, 0, 0)
TriMesh capped_cylinder(int facets, int rings, double radius = 1, double length = 2);
TriMesh ellipsoid(const Eigen::Vector3d& radii, int subdivisions);
/// The triangles whose centroids have y > at, with all vertices: half a model whose plane of symmetry is y = at.
TriMesh half_above(const TriMesh& mesh, double at = 0);
/// A half model of a crooked box, whose plane of symmetry is y = 1, and the whole of it.
struct HalfAndWhole {
    TriMesh half, whole;
};
HalfAndWhole crooked_box(int cells);
TriMesh refined(const TriMesh& mesh);  ///< every triangle into four, flat
/// Vertices and triangles in another order (seeded); `vertex_order[new] = old` and `triangle_order[new] = old`.
TriMesh renumbered(const TriMesh& mesh, unsigned seed, std::vector<int>* vertex_order = nullptr,
                   std::vector<int>* triangle_order = nullptr);

}  // namespace strake
