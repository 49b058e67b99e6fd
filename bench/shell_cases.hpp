#pragma once
#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/wing.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "core/primo/shell.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <sys/resource.h>

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

/// Keeps what is freed, as the program does (cli/main.cpp).
inline void keep_large_blocks() {
#ifdef __GLIBC__
    mallopt(M_MMAP_MAX, 0);
    mallopt(M_TRIM_THRESHOLD, -1);
#endif
}

/// CPU seconds of the process, user and system.
inline double cpu() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

inline double peak_gigabytes() {
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / (1 << 20);
}

/// The first 5 % of the longest axis are fixed; the traction of one acts across it, from 30 % on.
struct HeldShell {
    TriMesh mesh;
    ShellOptions options;
    Loads loads;
    double diagonal = box_diagonal(mesh);

    /// @param prism_height over the diagonal
    explicit HeldShell(TriMesh surface, double prism_height = 0.02) : mesh(std::move(surface)) {
        options.prism_height = Eigen::VectorXd::Constant(mesh.num_vertices(), prism_height * diagonal);
        options.pin.assign(mesh.num_triangles(), free_prism);
        const Box box = bounding_box(mesh);
        const Points centroid = triangle_centroids(mesh);
        int axis = 0;
        const double length = (box.max - box.min).maxCoeff(&axis);
        Points traction = Points::Zero(mesh.num_triangles(), 3);
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const double at = (centroid(t, axis) - box.min[axis]) / length;
            if (at < 0.05) options.pin[t] = fixed_prism;
            if (at > 0.3) traction(t, axis == 2 ? 0 : 2) = 1;
        }
        loads.force = traction_forces(mesh, traction);
    }

    /// Scales the loads so that the linear response is that many diagonals.
    void scale_loads(double displacement) {
        PrimoShell shell(mesh, options);
        const Points moved = shell.linear_response(loads) - mesh.vertices;
        loads.force *= displacement * diagonal / moved.rowwise().norm().maxCoeff();
    }
};

/// Held and loaded so, with springs where asked for.
struct LoadedShell {
    TriMesh mesh;
    ShellOptions options;
    Loads unit;  ///< linear response of one diagonal

    explicit LoadedShell(const std::string& name, double spring_distance = 0) {
        HeldShell held(bench_surface(name));
        held.scale_loads(1);
        mesh = held.mesh, options = held.options, unit = held.loads;
        if (spring_distance > 0) unit.spring = unit.force.rowwise().norm() / (2 * spring_distance * held.diagonal);
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
