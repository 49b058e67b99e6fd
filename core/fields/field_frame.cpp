#include "core/fields/field_frame.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double equal_moments = 1e-3;  ///< of the largest
constexpr double flat = 1e-9;           ///< of the largest extent
constexpr double as_wide_as_long = 1.05;
constexpr double along = 1e-6;  ///< sine of the angle by which a stated axis may miss the plane

/// Orthonormal axes of the space that the columns span, from the coordinate directions that lie in it best.
Eigen::MatrixXd coordinate_basis(const Eigen::MatrixXd& span) {
    Eigen::MatrixXd basis(3, span.cols());
    Matrix3d left = span * span.transpose();
    for (Eigen::Index k = 0; k < span.cols(); ++k) {
        int best = 0;
        for (int c = 1; c < 3; ++c)
            if (left.col(c).norm() > left.col(best).norm() * (1 + 1e-6)) best = c;
        basis.col(k) = left.col(best).normalized();
        left -= basis.col(k) * (basis.col(k).transpose() * left);
    }
    return basis;
}

bool is_rotational(const std::optional<ShapeKind>& kind) { return kind && kind->type != ShapeKind::Type::extruded; }

/// Principal axes of the covariance within the span of the columns.
Eigen::MatrixXd principal_axes(const Matrix3d& covariance, const Eigen::MatrixXd& span) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(span.transpose() * covariance * span);
    const Eigen::VectorXd& moment = eigen.eigenvalues();
    const Eigen::Index n = span.cols();
    Eigen::MatrixXd axes = span * eigen.eigenvectors();
    for (Eigen::Index first = 0; first < n;) {
        Eigen::Index end = first + 1;
        while (end < n && moment[end] - moment[end - 1] <= equal_moments * moment[n - 1]) ++end;
        if (end - first > 1)
            axes.middleCols(first, end - first) = coordinate_basis(axes.middleCols(first, end - first));
        first = end;
    }
    return axes;
}

/// Each axis gets the coordinate direction that it is nearest to, all different, and points its way.
void name_axes(FieldFrame& frame) {
    std::array<int, 3> order{0, 1, 2}, best = order;
    double most = -1;
    do {
        double sum = 0;
        for (int k = 0; k < 3; ++k) sum += std::abs(frame.axes(order[k], k));
        if (sum > most * (1 + 1e-9)) most = sum, best = order;
    } while (std::next_permutation(order.begin(), order.end()));
    for (int k = 0; k < 3; ++k) {
        frame.letter[k] = "xyz"[best[k]];
        if (frame.axes(best[k], k) < 0) frame.axes.col(k) *= -1;
    }
}

/// Adds a direction, square to those before it. @throws InvalidInput: at an angle to one of them.
void add_axis(std::vector<Vector3d>& given, const Vector3d& axis, const char* what) {
    Vector3d left = axis;
    for (const Vector3d& before : given) {
        const double cosine = axis.dot(before), sine = axis.cross(before).norm();
        if (sine > along && std::abs(cosine) > along) throw InvalidInput(text("fields: ", what));
        if (sine <= along) return;
        left -= cosine * before;
    }
    given.push_back(left.normalized());
}

/// Axes that are given by the plane, by the kind of shape and by the stated axis of the sections, orthonormal, the
/// plane's normal first.
std::vector<Vector3d> given_axes(const std::optional<SymmetryPlane>& plane, const std::optional<Vector3d>& axis,
                                 const std::optional<ShapeKind>& kind) {
    std::vector<Vector3d> given;
    if (plane) given.push_back(plane->normal);
    if (kind)
        add_axis(given, kind->axis, "the axis of the invariance must lie in the plane of symmetry or be normal to it");
    if (!axis) return given;
    if (!(std::abs(axis->norm() - 1) < 1e-9))
        throw InvalidInput(text("fields: the axis has length ", axis->norm(), ", not 1"));
    if (is_rotational(kind) && kind->axis.cross(*axis).norm() > along)
        throw InvalidInput(text("fields: the shape is ", to_string(*kind), "; the axis of the sections is that one"));
    add_axis(given, *axis,
             plane ? "the axis must lie in the plane of symmetry or be normal to it"
                   : "the axis must be along or across that of the invariance");
    return given;
}

Matrix3d all_axes(const TriMesh& rest, const std::optional<SymmetryPlane>& plane, std::vector<Vector3d> axes) {
    const Eigen::VectorXd area = vertex_areas(rest);
    Vector3d center = rest.vertices.transpose() * area / area.sum();
    if (plane) center -= (plane->normal.dot(center) - plane->offset) * plane->normal;
    const Points arm = rest.vertices.rowwise() - center.transpose();
    const Matrix3d covariance = arm.transpose() * area.asDiagonal() * arm;
    Eigen::MatrixXd span = Matrix3d::Identity();
    if (!axes.empty()) {
        Eigen::MatrixXd known(3, static_cast<Eigen::Index>(axes.size()));
        for (std::size_t k = 0; k < axes.size(); ++k) known.col(static_cast<Eigen::Index>(k)) = axes[k];
        span = coordinate_basis(Matrix3d::Identity() - known * known.transpose()).leftCols(3 - known.cols());
    }
    const Eigen::MatrixXd free = principal_axes(covariance, span);
    for (Eigen::Index k = 0; k < free.cols(); ++k) axes.emplace_back(free.col(k));
    Matrix3d all;
    for (int k = 0; k < 3; ++k) all.col(k) = axes[static_cast<std::size_t>(k)];
    return all;
}

/// The first extent, across the plane of symmetry, must be clearly the largest one to count as that.
Vector3d narrowed(Vector3d extent) {
    extent[0] /= as_wide_as_long;
    return extent;
}

/// The middle lies on the axis, and both extents across it are the largest distance from it.
void center_on(FieldFrame& frame, const TriMesh& rest, const ShapeKind& kind) {
    const Points arm = rest.vertices.rowwise() - kind.through.transpose();
    const Points across = arm - (arm * kind.axis) * kind.axis.transpose();
    const double radius = across.rowwise().norm().maxCoeff();
    for (int k = 1; k < 3; ++k) {
        frame.middle[k] = frame.axes.col(k).dot(kind.through);
        frame.half[k] = radius;
    }
}

}  // namespace

Vector3d FieldFrame::local(const Vector3d& x) const {
    const Vector3d at = axes.transpose() * x - middle;
    Vector3d result = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
        if (half[k] > 0) result[k] = at[k] / half[k];
    return result;
}

TriMesh with_loose_vertices_joined(TriMesh mesh) {
    if (mesh.num_triangles() == 0) return mesh;
    const std::vector<char> used = used_vertices(mesh);
    const Eigen::RowVector3d place = mesh.vertices.row(mesh.triangles(0, 0));
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (!used[static_cast<std::size_t>(v)]) mesh.vertices.row(v) = place;
    return mesh;
}

FieldFrame field_frame(const TriMesh& rest, const std::optional<SymmetryPlane>& plane, bool is_half,
                       const std::optional<Vector3d>& axis, const std::optional<ShapeKind>& kind,
                       bool by_extent_alone) {
    const Matrix3d axes = all_axes(rest, plane, given_axes(plane, axis, kind));
    Vector3d low, high;
    for (int k = 0; k < 3; ++k) {
        const Eigen::VectorXd at = rest.vertices * axes.col(k);
        low[k] = at.minCoeff(), high[k] = at.maxCoeff();
    }
    if (plane) {
        const double reach =
            is_half ? std::max(high[0] - plane->offset, plane->offset - low[0]) : 0.5 * (high[0] - low[0]);
        low[0] = plane->offset - reach, high[0] = plane->offset + reach;
    }
    const Vector3d extent = high - low;
    const Vector3d compared = plane && !by_extent_alone ? narrowed(extent) : extent;
    std::array<int, 3> order{0, 1, 2};
    const auto is_along = [&](int k, const Vector3d& d) { return std::abs(axes.col(k).dot(d)) > 1 - 1e-9; };
    const auto rank = [&](int k) {
        if (kind && is_along(k, kind->axis)) return is_rotational(kind) ? 2e300 : -1.0;
        return axis && is_along(k, *axis) ? 1e300 : compared[k];
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return rank(a) > rank(b) + 1e-9 * std::abs(rank(b)); });
    FieldFrame frame;
    for (int k = 0; k < 3; ++k) {
        frame.axes.col(k) = axes.col(order[k]);
        frame.half[k] = extent[order[k]] > flat * extent.maxCoeff() ? 0.5 * extent[order[k]] : 0;
        if (plane && order[k] == 0) frame.plane_axis = k;
    }
    name_axes(frame);
    for (int k = 0; k < 3; ++k) {  // signs may have changed
        const double sign = frame.axes.col(k).dot(axes.col(order[k])) < 0 ? -1 : 1;
        frame.middle[k] = sign * 0.5 * (low[order[k]] + high[order[k]]);
    }
    if (is_rotational(kind)) center_on(frame, rest, *kind);
    return frame;
}

}  // namespace strake
