#pragma once
#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/wing.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/io.hpp"
#include "core/primo/shell.hpp"

#include <cmath>
#include <string>

/// Surfaces held at one end and loaded on the rest, for the benchmarks of the shell.
namespace strake {

/// "wing:22000", "body:131000" (lifting body) or a file.
inline TriMesh bench_surface(const std::string& name) {
    const auto colon = name.find(':');
    const std::string kind = name.substr(0, colon);
    if (colon != std::string::npos && kind == "wing") return example::wing(std::stoi(name.substr(colon + 1)));
    if (colon != std::string::npos && kind == "body") return example::lifting_body(std::stoi(name.substr(colon + 1)));
    return read_surface(name).mesh;
}

/// The first 5 % of the longest axis are fixed; the traction acts across it, from 30 % on.
struct LoadedShell {
    TriMesh mesh;
    ShellOptions options;
    Loads unit;  ///< linear response of one diagonal

    explicit LoadedShell(const std::string& name, double spring_distance = 0) : mesh(bench_surface(name)) {
        const Box box = bounding_box(mesh);
        const double diagonal = box_diagonal(mesh);
        options.prism_height = Eigen::VectorXd::Constant(mesh.num_vertices(), 0.02 * diagonal);
        options.pin.assign(mesh.num_triangles(), free_prism);
        const Points centroid = triangle_centroids(mesh);
        int axis = 0;
        const double length = (box.max - box.min).maxCoeff(&axis);
        const int across = axis == 2 ? 0 : 2;
        Points traction = Points::Zero(mesh.num_triangles(), 3);
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const double at = (centroid(t, axis) - box.min[axis]) / length;
            if (at < 0.05) options.pin[t] = fixed_prism;
            if (at > 0.3) traction(t, across) = 1;
        }
        unit.force = traction_forces(mesh, traction);
        PrimoShell shell(mesh, options);
        unit.force *= diagonal / (shell.linear_response(unit) - mesh.vertices).rowwise().norm().maxCoeff();
        if (spring_distance > 0) unit.spring = unit.force.rowwise().norm() / (2 * spring_distance * diagonal);
    }

    Loads loads(double share) const {
        Loads result = unit;
        result.force *= share;
        result.spring *= share;
        return result;
    }
};

/// A share more in size and as much sideways.
inline Loads changed(const Loads& loads, double share) {
    Loads result = loads;
    for (Eigen::Index k = 0; k < result.force.rows(); ++k) {
        const Eigen::RowVector3d F = loads.force.row(k);
        result.force.row(k) += share * (F + Eigen::RowVector3d(F.y() + F.z(), F.z() + F.x(), F.x() + F.y()) / 2);
    }
    return result;
}

/// The same forces, weighted by a wave that differs by number: functionals that are not alike.
inline Points wavy(const Points& force, int number) {
    Points result = force;
    for (Eigen::Index k = 0; k < force.rows(); ++k)
        result.row(k) *= 1 + std::sin(0.001 * (number + 1) * static_cast<double>(k));
    return result;
}

}  // namespace strake
