#pragma once
#include "core/error.hpp"
#include "derivatives.hpp"
#include "objectives/quantity/quantity.hpp"

#include <unistd.h>
#include <filesystem>
#include <fstream>

/// What tests ask of quantities.
namespace strake {

inline QuantityResult ask(const Quantity& quantity, const TriMesh& mesh, bool sensitivities = false) {
    return quantity.evaluate({mesh, sensitivities, 1, 0, {}});
}
inline double value(const Quantity& quantity, const TriMesh& mesh, std::size_t i = 0) {
    return ask(quantity, mesh).values.at(i);
}

inline Eigen::VectorXd flat(const Points& p) { return Eigen::Map<const Eigen::VectorXd>(p.data(), p.size()); }
inline Points points(const Eigen::VectorXd& x) { return Eigen::Map<const Points>(x.data(), x.size() / 3, 3); }

inline TriMesh moved(TriMesh mesh, double scale, const Eigen::RowVector3d& shift) {
    mesh.vertices = (scale * mesh.vertices).rowwise() + shift;
    return mesh;
}

/// Order of the Taylor remainder of value i, with its gradient times `factor`.
inline double order(const Quantity& quantity, const TriMesh& mesh, double factor = 1, std::size_t i = 0,
                    double h = 1e-3) {
    const auto J = [&](const Eigen::VectorXd& x) { return value(quantity, with_vertices(mesh, points(x)), i); };
    const Eigen::VectorXd g = flat(ask(quantity, mesh, true).dJ_dv.at(i));
    // Partly along g, so that a wrong factor shows.
    const Eigen::VectorXd p = 0.3 * random_vector(g.size(), 7) + 0.5 / g.cwiseAbs().maxCoeff() * g;
    return taylor_order(J, flat(mesh.vertices), factor * g, p, h);
}

/// The same for a half model, along directions that keep the vertices of the plane y = at in it.
inline double order_in_plane(const Quantity& quantity, const TriMesh& half, double at, double factor = 1,
                             std::size_t i = 0, double h = 1e-3) {
    const auto J = [&](const Eigen::VectorXd& x) { return value(quantity, with_vertices(half, points(x)), i); };
    const Points g = ask(quantity, half, true).dJ_dv.at(i);
    Points p = points(0.3 * random_vector(g.size(), 7)) + 0.5 / g.cwiseAbs().maxCoeff() * g;
    for (int v = 0; v < half.num_vertices(); ++v)
        if (std::abs(half.vertices(v, 1) - at) < 1e-9) p(v, 1) = 0;
    return taylor_order(J, flat(half.vertices), factor * flat(g), flat(p), h);
}

/// Order of the remainder of the residuals |r(v + hp) - r(v) - h dr/dv p|.
inline double residual_order(const Quantity& quantity, const TriMesh& mesh, double factor = 1, double h = 1e-3) {
    const Eigen::VectorXd x = flat(mesh.vertices), p = random_vector(x.size(), 5);
    const Residuals at = quantity.residuals(mesh, mesh);
    const auto remainder = [&](double s) {
        const TriMesh other = with_vertices(mesh, points(x + s * p));
        return (quantity.residuals(other, other).r - at.r - factor * s * (at.dr_dv * p)).norm();
    };
    return std::log10(remainder(h) / remainder(h / 10));
}

/// The message of the exception that `make` throws, or "".
template <class Make>
std::string refusal(const Make& make) {
    try {
        make();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "";
}

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A file in the folder of temporary files that goes with the scope.
struct TemporaryFile {
    std::filesystem::path path;
    TemporaryFile(const std::string& name, const std::string& content)
        : path(std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + name)) {
        std::ofstream(path, std::ios::binary) << content;
    }
    ~TemporaryFile() {
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
    }
};

}  // namespace strake
