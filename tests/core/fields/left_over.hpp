#pragma once
#include "core/fields/displacement_fields.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/QR>

namespace strake {

/// Share of the squared motion (by area) that no combination of the fields makes, by least squares in all unknowns: no
/// use is made of their orthogonality.
inline double left_over(const TriMesh& mesh, const DisplacementFields& fields, const Points& wanted) {
    const Eigen::VectorXd weight = vertex_areas(mesh).cwiseSqrt();
    Eigen::MatrixXd columns(3 * mesh.num_vertices(), fields.size());
    const auto flat = [&](const Points& u) {
        const Points scaled = weight.asDiagonal() * u;
        return Eigen::VectorXd(Eigen::VectorXd::Map(scaled.data(), scaled.size()));
    };
    for (int b = 0; b < fields.size(); ++b) columns.col(b) = flat(fields.field(b));
    const Eigen::VectorXd target = flat(wanted);
    return (columns * columns.colPivHouseholderQr().solve(target) - target).squaredNorm() / target.squaredNorm();
}

}  // namespace strake
