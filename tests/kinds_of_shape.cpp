#include "tests/kinds_of_shape.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace strake {
namespace {

using Eigen::Vector3d;

void add(std::vector<std::array<int, 3>>& triangles, int a, int b, int c) { triangles.push_back({a, b, c}); }

TriMesh made(const std::vector<Vector3d>& vertices, const std::vector<std::array<int, 3>>& triangles) {
    TriMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
    for (std::size_t v = 0; v < vertices.size(); ++v) mesh.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v];
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        mesh.triangles.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1], triangles[t][2];
    return mesh;
}

}  // namespace

TriMesh extruded_section(int around, int rows) {
    std::vector<Vector3d> x;
    std::vector<std::array<int, 3>> t;
    for (int r = 0; r <= rows; ++r)
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * std::numbers::pi * i / around;
            x.emplace_back(0.5 * std::cos(angle), static_cast<double>(r) / rows,
                           0.12 * std::sin(angle) * (1 - 0.4 * std::cos(angle)));
        }
    for (int r = 0; r < rows; ++r)
        for (int i = 0; i < around; ++i) {
            const int a = r * around + i, b = r * around + (i + 1) % around;
            add(t, a, a + around, b), add(t, b, a + around, b + around);
        }
    for (const int r : {0, rows}) {
        const int middle = static_cast<int>(x.size());
        x.emplace_back(0, static_cast<double>(r) / rows, 0);
        for (int i = 0; i < around; ++i) {
            const int a = r * around + i, b = r * around + (i + 1) % around;
            r == 0 ? add(t, a, b, middle) : add(t, b, a, middle);
        }
    }
    return made(x, t);
}

TriMesh body_of_revolution(int around, int along) {
    std::vector<Vector3d> x;
    std::vector<std::array<int, 3>> t;
    for (int r = 0; r <= along; ++r)
        for (int i = 0; i < around; ++i) {
            const double s = -1 + 2.0 * r / along, radius = 0.5 * (1 - 0.6 * s * s);
            // Coordinates are equal on both sides of the planes y = 0 and z = 0, by every bit.
            const int quarter = around / 4, k = i % quarter;
            const double angle = 0.5 * std::numbers::pi * k / quarter;
            double c = std::cos(angle), d = std::sin(angle);
            if (i / quarter == 1) std::swap(c, d), c = -c;
            if (i / quarter == 2) c = -c, d = -d;
            if (i / quarter == 3) std::swap(c, d), d = -d;
            x.emplace_back(s, radius * c, radius * d);
        }
    for (int r = 0; r < along; ++r)
        for (int i = 0; i < around; ++i) {
            const int a = r * around + i, b = r * around + (i + 1) % around;
            add(t, a, b, a + around), add(t, b, b + around, a + around);
        }
    for (const int r : {0, along}) {
        const int middle = static_cast<int>(x.size());
        x.emplace_back(r == 0 ? -1 : 1, 0, 0);
        for (int i = 0; i < around; ++i) {
            const int a = r * around + i, b = r * around + (i + 1) % around;
            r == 0 ? add(t, b, a, middle) : add(t, a, b, middle);
        }
    }
    return made(x, t);
}

TriMesh cyclic_body(int count, int per_sector) {
    // A torus-like ring whose section grows and leans within each sector.
    constexpr int around = 8;
    std::vector<Vector3d> x;
    std::vector<std::array<int, 3>> t;
    const int n = count * per_sector;
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < around; ++k) {
            const double share = static_cast<double>(i % per_sector) / per_sector;
            const double section = 2 * std::numbers::pi * k / around;
            const double size = 0.2 * (1 + 0.4 * std::sin(2 * std::numbers::pi * share));
            const double radius = 1 + size * std::cos(section);
            const double angle = 2 * std::numbers::pi * i / n + 0.05 * std::sin(section) * share;
            x.emplace_back(size * std::sin(section) + 0.05 * share * (1 - share), radius * std::cos(angle),
                           radius * std::sin(angle));
        }
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < around; ++k) {
            const int next = (i + 1) % n;
            const int a = i * around + k, b = i * around + (k + 1) % around;
            const int c = next * around + k, d = next * around + (k + 1) % around;
            add(t, a, b, c), add(t, b, d, c);
        }
    return made(x, t);
}

TriMesh part_above(const TriMesh& mesh, const SymmetryPlane& plane, std::vector<int>& number) {
    std::vector<int> place(static_cast<std::size_t>(mesh.num_vertices()), -1);
    std::vector<Vector3d> x;
    std::vector<std::array<int, 3>> t;
    number.clear();
    for (int i = 0; i < mesh.num_triangles(); ++i) {
        Vector3d middle = Vector3d::Zero();
        for (int k = 0; k < 3; ++k) middle += mesh.vertices.row(mesh.triangles(i, k)).transpose() / 3;
        if (plane.normal.dot(middle) < plane.offset) continue;
        std::array<int, 3> corners{};
        for (int k = 0; k < 3; ++k) {
            int& at = place[static_cast<std::size_t>(mesh.triangles(i, k))];
            if (at < 0) {
                at = static_cast<int>(x.size());
                x.emplace_back(mesh.vertices.row(mesh.triangles(i, k)));
                number.push_back(mesh.triangles(i, k));
            }
            corners[static_cast<std::size_t>(k)] = at;
        }
        t.push_back(corners);
    }
    return made(x, t);
}

std::vector<int> held_end(const TriMesh& mesh, const ShapeKind& kind) {
    // In the coordinates of the bodies above, which a test may have turned: distances from the axis and along it.
    std::vector<int> held;
    const Vector3d across = kind.type == ShapeKind::Type::extruded
                                ? Vector3d(mesh.vertices.row(0) - mesh.vertices.colwise().mean())
                                : kind.axis;
    const Vector3d direction = (across - across.dot(kind.axis) * kind.axis).norm() > 1e-6
                                   ? Vector3d((across - across.dot(kind.axis) * kind.axis).normalized())
                                   : kind.axis;
    const Eigen::VectorXd at = mesh.vertices * direction;
    const double low = at.minCoeff(), high = at.maxCoeff();
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        bool is_in = true;
        for (int k = 0; k < 3; ++k) is_in &= at[mesh.triangles(t, k)] < low + 0.237 * (high - low);
        if (is_in) held.push_back(t);
    }
    return held;
}

namespace {

double off_extruded(const TriMesh& mesh, const Vector3d& axis) {
    const Eigen::VectorXd along = mesh.vertices * axis;
    const Points section = mesh.vertices - along * axis.transpose();
    double worst = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        Eigen::VectorXd distance = (section.rowwise() - section.row(v)).rowwise().norm();
        distance[v] = std::numeric_limits<double>::infinity();
        worst = std::max(worst, distance.minCoeff());
        for (const double end : {along.minCoeff(), along.maxCoeff()})  // ends stay across
            if (std::abs(along[v] - end) < 0.05) worst = std::max(worst, std::abs(along[v] - end));
    }
    return worst;
}

double off_revolved(const TriMesh& mesh, const ShapeKind& kind) {
    const Points arm = mesh.vertices.rowwise() - kind.through.transpose();
    const Eigen::VectorXd along = arm * kind.axis;
    const Eigen::VectorXd radius = (arm - along * kind.axis.transpose()).rowwise().norm();
    double worst = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        double least = radius[v];  // a vertex on the axis has no ring
        for (int w = 0; w < mesh.num_vertices(); ++w)
            if (w != v) least = std::min(least, std::hypot(along[v] - along[w], radius[v] - radius[w]));
        worst = std::max(worst, least);
    }
    return worst;
}

double off_cyclic(const TriMesh& mesh, const ShapeKind& kind) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(2 * std::numbers::pi / kind.count, kind.axis).toRotationMatrix();
    double worst = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Vector3d image = kind.through + turn * (Vector3d(mesh.vertices.row(v)) - kind.through);
        worst = std::max(worst, (mesh.vertices.rowwise() - image.transpose()).rowwise().norm().minCoeff());
    }
    return worst;
}

}  // namespace

double off_kind(const TriMesh& mesh, const ShapeKind& kind) {
    if (kind.type == ShapeKind::Type::extruded) return off_extruded(mesh, kind.axis);
    return kind.type == ShapeKind::Type::revolved ? off_revolved(mesh, kind) : off_cyclic(mesh, kind);
}

}  // namespace strake
