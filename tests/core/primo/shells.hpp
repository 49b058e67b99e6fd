#pragma once
#include "core/mesh/geometry.hpp"
#include "core/primo/shell.hpp"
#include "derivatives.hpp"
#include "surfaces.hpp"

/// Small loaded shells for the tests of core/primo.
namespace strake {

inline ShellOptions uniform(const TriMesh& mesh, double height) {
    ShellOptions options;
    options.prism_height = Eigen::VectorXd::Constant(mesh.num_vertices(), height);
    options.pin.assign(mesh.num_triangles(), free_prism);
    return options;
}

/// Pins the triangles whose centroid satisfies `inside`.
template <class Inside>
void pin_where(const TriMesh& mesh, ShellOptions& options, int value, const Inside& inside) {
    const Points c = triangle_centroids(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (inside(Eigen::Vector3d(c.row(t)))) options.pin[t] = value;
}

/// Dead load of a uniform traction on the triangles whose centroid satisfies `inside`.
template <class Inside>
Loads traction_where(const TriMesh& mesh, const Eigen::Vector3d& traction, const Inside& inside) {
    const Points c = triangle_centroids(mesh);
    Points t = Points::Zero(mesh.num_triangles(), 3);
    for (int i = 0; i < mesh.num_triangles(); ++i)
        if (inside(Eigen::Vector3d(c.row(i)))) t.row(i) = traction;
    return {traction_forces(mesh, t), {}};
}

/// The loads whose linear response moves the surface by `share` diagonals.
inline Loads scaled_to(PrimoShell& shell, const TriMesh& mesh, Loads loads, double share) {
    const double moved = (shell.linear_response(loads) - mesh.vertices).rowwise().norm().maxCoeff();
    loads.force *= share * box_diagonal(mesh) / moved;
    return loads;
}

}  // namespace strake
