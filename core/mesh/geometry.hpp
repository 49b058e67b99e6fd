#pragma once
#include "core/mesh/mesh.hpp"

#include <vector>

/// Elementary geometry of triangles. Lengths are in the surface's unit, angles in radians.
namespace strake {

struct Box {
    Eigen::Vector3d min, max;
};
Box bounding_box(const TriMesh& mesh);     ///< of all vertices that a triangle uses; zero box without triangles
double box_diagonal(const TriMesh& mesh);  ///< length of the bounding box's diagonal

/// 1 for each vertex that a triangle uses, else 0 (n).
std::vector<char> used_vertices(const TriMesh& mesh);

Eigen::Vector3d area_vector(const TriMesh& mesh, int t);  ///< (b-a) x (c-a) / 2: unit normal times area
Points triangle_normals(const TriMesh& mesh);             ///< m x 3 unit normals; zero rows for triangles of zero area
Eigen::VectorXd triangle_areas(const TriMesh& mesh);      ///< m
Points triangle_centroids(const TriMesh& mesh);           ///< m x 3
Points corner_angles(const TriMesh& mesh);                ///< m x 3, angle of triangle t at its corner k, by atan2

/// Exterior angle between two unit normals, atan2(|n1 x n2|, n1.n2) in [0, pi]; 0 is flat.
double dihedral(const Eigen::Vector3d& n1, const Eigen::Vector3d& n2);

/// One third of the areas of the incident triangles of each vertex (n). Sums to the area.
Eigen::VectorXd vertex_areas(const TriMesh& mesh);

double surface_area(const TriMesh& mesh);
/// 1/6 sum v0 . (v1 x v2), taken about the box's centre so that an offset costs no digits. Of an open
/// surface: the volume of the cone from that centre.
double enclosed_volume(const TriMesh& mesh);

/// Area-weighted centroid of the listed triangles. @throws InvalidInput when their area is zero.
Eigen::Vector3d area_centroid(const TriMesh& mesh, const std::vector<int>& triangles);

}  // namespace strake
