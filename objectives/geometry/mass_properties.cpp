#include "objectives/geometry/mass_properties.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double equal_moments = 1e-9;  // of the largest

/// V, int x and int x x^T; or what a value's derivatives by them are.
struct Integrals {
    double V = 0;
    Vector3d x = Vector3d::Zero();
    Matrix3d xx = Matrix3d::Zero();
};

struct Corners {
    Vector3d a, b, c;
};

Corners corners(const TriMesh& mesh, int t, const Vector3d& o) {
    const auto at = [&](int k) { return Vector3d(Vector3d(mesh.vertices.row(mesh.triangles(t, k))) - o); };
    return {at(0), at(1), at(2)};
}

Integrals integrals(const TriMesh& mesh, const Vector3d& o) {
    Integrals sum;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto [a, b, c] = corners(mesh, t, o);
        const double V = a.dot(b.cross(c)) / 6;
        const Vector3d s = a + b + c;
        sum.V += V;
        sum.x += V / 4 * s;
        sum.xx += V / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
    }
    return sum;
}

Points gradient(const TriMesh& mesh, const Vector3d& o, const Integrals& by) {
    Points dJ_dv = Points::Zero(mesh.num_vertices(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto [a, b, c] = corners(mesh, t, o);
        const std::array<Vector3d, 3> W{by.xx * a, by.xx * b, by.xx * c}, six_dV{b.cross(c), c.cross(a), a.cross(b)};
        const double V = a.dot(six_dV[0]) / 6;
        const Vector3d s = a + b + c, Ws = W[0] + W[1] + W[2], shared = V * (by.x / 4 + Ws / 10);
        const double per_V = by.V + by.x.dot(s) / 4 + (a.dot(W[0]) + b.dot(W[1]) + c.dot(W[2]) + s.dot(Ws)) / 20;
        for (int k = 0; k < 3; ++k) dJ_dv.row(mesh.triangles(t, k)) += per_V / 6 * six_dV[k] + V / 10 * W[k] + shared;
    }
    return dJ_dv;
}

constexpr std::array<std::array<int, 2>, 6> entries{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}}};

class Body {
public:
    Body(const std::string& name, const Integrals& at, const Vector3d& o, const Matrix3d& reference)
        : name_(name), at_(at), o_(o) {
        centroid_ = at.x / at.V;
        const Matrix3d about = at.xx - at.V * centroid_ * centroid_.transpose();
        inertia_ = about.trace() * Matrix3d::Identity() - about;
        const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(0.5 * (inertia_ + inertia_.transpose()));
        moments_ = solver.eigenvalues();
        axes_ = solver.eigenvectors();
        for (int k = 0; k < 3; ++k)
            if (axes_.col(k).dot(reference.col(k)) < 0) axes_.col(k) *= -1;
    }
    const Matrix3d& axes() const { return axes_; }
    double value(int i) const {
        if (i < 3) return o_[i] + centroid_[i];
        if (i < 9) return inertia_(entries[i - 3][0], entries[i - 3][1]);
        if (i < 12) return moments_[i - 9];
        return axes_((i - 12) % 3, (i - 12) / 3);
    }
    /// d value(i) / d integrals.
    Integrals derivative(int i) const {
        Integrals by;
        if (i < 3) {
            by.V = -centroid_[i] / at_.V;
            by.x[i] = 1 / at_.V;
            return by;
        }
        Matrix3d by_inertia = Matrix3d::Zero();
        if (i < 9) {
            const auto [r, c] = entries[i - 3];
            by_inertia(r, c) += 0.5;
            by_inertia(c, r) += 0.5;
        } else if (i < 12)
            by_inertia = axes_.col(i - 9) * axes_.col(i - 9).transpose();
        else
            by_inertia = by_axis((i - 12) / 3, (i - 12) % 3);
        // I = tr(C) 1 - C,  C = xx - x x^T / V.
        by.xx = by_inertia.trace() * Matrix3d::Identity() - by_inertia;
        by.x = -2 * by.xx * centroid_;
        by.V = centroid_.dot(by.xx * centroid_);
        return by;
    }

private:
    /// dq_k = sum_j q_j (q_j . dI q_k) / (l_k - l_j).
    Matrix3d by_axis(int k, int component) const {
        Matrix3d by = Matrix3d::Zero();
        for (int j = 0; j < 3; ++j) {
            if (j == k) continue;
            const double gap = moments_[k] - moments_[j];
            if (std::abs(gap) < equal_moments * moments_[2])
                throw InvalidInput(text(name_, ": principal moments ", j + 1, " and ", k + 1,
                                        " are equal, their axes are not defined"));
            by += axes_(component, j) / gap * axes_.col(j) * axes_.col(k).transpose();
        }
        return 0.5 * (by + by.transpose());
    }
    std::string name_;
    Integrals at_;
    Vector3d o_, centroid_, moments_;
    Matrix3d inertia_, axes_;
};

/// Turned so that the largest component of each axis is positive.
Matrix3d signed_axes(Matrix3d axes) {
    for (int k = 0; k < 3; ++k) {
        int largest = 0;
        axes.col(k).cwiseAbs().maxCoeff(&largest);
        if (axes(largest, k) < 0) axes.col(k) *= -1;
    }
    return axes;
}

}  // namespace

std::vector<std::string> mass_property_values() {
    std::vector<std::string> names{"centroid_x", "centroid_y", "centroid_z",  "ixx",         "iyy",        "izz", "ixy",
                                   "iyz",        "izx",        "principal_1", "principal_2", "principal_3"};
    for (int k = 1; k <= 3; ++k)
        for (const char* c : {"x", "y", "z"}) names.push_back(text("axis_", k, "_", c));
    return names;
}

Quantity mass_properties(const std::string& name, const TriMesh& start, const std::optional<SymmetryPlane>& symmetry) {
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    require_closed(name, start, symmetry);
    const Box box = bounding_box(start);
    Vector3d o = 0.5 * (box.min + box.max);
    if (symmetry) o -= (symmetry->normal.dot(o) - symmetry->offset) * symmetry->normal;
    const auto whole = [symmetry](const TriMesh& mesh) { return symmetry ? whole_of(mesh, *symmetry) : mesh; };
    const Integrals first = integrals(whole(start), o);
    const double d = (box.max - box.min).norm();
    if (!(std::abs(first.V) > 1e-12 * d * d * d)) throw InvalidInput(text(name, ": the surface encloses no volume"));
    const Matrix3d reference = signed_axes(Body(name, first, o, Matrix3d::Identity()).axes());
    std::vector<std::string> names;
    for (const std::string& value : mass_property_values()) names.push_back(name + "." + value);
    return checked_quantity(name, names, start, [=, count = names.size()](const QuantityRequest& request) {
        const TriMesh mesh = whole(request.surface);
        const Body body(name, integrals(mesh, o), o, reference);
        QuantityResult result;
        for (std::size_t i = 0; i < count; ++i) result.values.push_back(body.value(static_cast<int>(i)));
        if (!request.want_sensitivities) return result;
        result.dJ_dv.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            if (!request.wants(i)) continue;
            const Points g = gradient(mesh, o, body.derivative(static_cast<int>(i)));
            result.dJ_dv[i] = symmetry ? folded(g, *symmetry) : g;
        }
        return result;
    });
}

}  // namespace strake
