#pragma once
#include "surfaces.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

/// Surfaces with one defect each.
namespace strake::defective {

inline TriMesh joined(const TriMesh& a, const TriMesh& b) {
    TriMesh both;
    both.vertices.resize(a.num_vertices() + b.num_vertices(), 3);
    both.vertices << a.vertices, b.vertices;
    both.triangles.resize(a.num_triangles() + b.num_triangles(), 3);
    both.triangles << a.triangles, (b.triangles.array() + a.num_vertices()).matrix();
    return both;
}

inline TriMesh moved(TriMesh mesh, const Eigen::RowVector3d& by, double scale = 1) {
    mesh.vertices = (scale * mesh.vertices).rowwise() + by;
    return mesh;
}

inline int add_vertex(TriMesh& mesh, const Eigen::Vector3d& at) {
    mesh.vertices.conservativeResize(mesh.num_vertices() + 1, 3);
    mesh.vertices.row(mesh.num_vertices() - 1) = at;
    return mesh.num_vertices() - 1;
}

inline void add_triangle(TriMesh& mesh, int a, int b, int c) {
    mesh.triangles.conservativeResize(mesh.num_triangles() + 1, 3);
    mesh.triangles.row(mesh.num_triangles() - 1) << a, b, c;
}

inline TriMesh without(const TriMesh& mesh, const std::function<bool(int)>& is_gone) {
    TriMesh rest = mesh;
    int kept = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (!is_gone(t)) rest.triangles.row(kept++) = mesh.triangles.row(t);
    rest.triangles.conservativeResize(kept, 3);
    return rest;
}

inline TriMesh turned(TriMesh mesh, const std::function<bool(int)>& is_turned) {
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (is_turned(t)) std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
    return mesh;
}

inline Eigen::Vector3d centroid(const TriMesh& mesh, int t) {
    return (mesh.vertices.row(mesh.triangles(t, 0)) + mesh.vertices.row(mesh.triangles(t, 1)) +
            mesh.vertices.row(mesh.triangles(t, 2))) /
           3;
}

/// No two triangles share a vertex.
inline TriMesh unwelded(const TriMesh& mesh) {
    TriMesh soup;
    soup.vertices.resize(3 * mesh.num_triangles(), 3);
    soup.triangles.resize(mesh.num_triangles(), 3);
    for (int i = 0; i < mesh.triangles.size(); ++i) {
        soup.vertices.row(i) = mesh.vertices.row(mesh.triangles.data()[i]);
        soup.triangles.data()[i] = i;
    }
    return soup;
}

/// The triangles above z = 0 get vertices of their own, shifted by so much in x.
inline TriMesh cracked(const TriMesh& mesh, double shift) {
    TriMesh torn = mesh;
    std::vector<int> copy(static_cast<std::size_t>(mesh.num_vertices()), -1);
    std::vector<char> below(copy.size());
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (centroid(mesh, t).z() <= 0)
            for (int k = 0; k < 3; ++k) below[mesh.triangles(t, k)] = 1;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (centroid(mesh, t).z() <= 0) continue;
        for (int k = 0; k < 3; ++k) {
            const int v = mesh.triangles(t, k);
            if (!below[v]) continue;
            if (copy[v] < 0)
                copy[v] = add_vertex(torn, mesh.vertices.row(v).transpose() + Eigen::Vector3d(shift, 0, 0));
            torn.triangles(t, k) = copy[v];
        }
    }
    return torn;
}

/// Triangle 0 is cut at the middle of its first edge; its neighbour is not.
inline TriMesh with_t_junction(const TriMesh& mesh) {
    TriMesh split = mesh;
    const int a = mesh.triangles(0, 0), b = mesh.triangles(0, 1), c = mesh.triangles(0, 2);
    const int m = add_vertex(split, 0.5 * (mesh.vertices.row(a) + mesh.vertices.row(b)));
    split.triangles.row(0) << a, m, c;
    add_triangle(split, m, b, c);
    return split;
}

/// The gap of that closed by a triangle of no area.
inline TriMesh with_cap(const TriMesh& mesh) {
    TriMesh capped = with_t_junction(mesh);
    add_triangle(capped, mesh.triangles(0, 0), mesh.triangles(0, 1), capped.num_vertices() - 1);
    return capped;
}

/// The first edge of triangle 0 split right beside its first vertex: two needles.
inline TriMesh with_needles(const TriMesh& mesh) {
    TriMesh split = mesh;
    const int a = mesh.triangles(0, 0), b = mesh.triangles(0, 1), c = mesh.triangles(0, 2);
    const int m = add_vertex(split, mesh.vertices.row(a) + 1e-13 * (mesh.vertices.row(b) - mesh.vertices.row(a)));
    for (int t = 1; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k)
            if (mesh.triangles(t, k) == b && mesh.triangles(t, (k + 1) % 3) == a) {
                const int d = mesh.triangles(t, (k + 2) % 3);
                split.triangles.row(t) << b, m, d;
                add_triangle(split, m, a, d);
            }
    split.triangles.row(0) << a, m, c;
    add_triangle(split, m, b, c);
    return split;
}

/// A band of n quads around the unit circle with so many half turns; width in both directions 0.3.
inline TriMesh twisted_band(int n, int half_turns) {
    TriMesh band;
    band.vertices.resize(2 * n, 3);
    for (int i = 0; i < n; ++i) {
        const double u = 2 * std::numbers::pi * i / n, tilt = half_turns * u / 2;
        const Eigen::Vector3d out(std::cos(u), std::sin(u), 0),
            arm = std::cos(tilt) * out + std::sin(tilt) * Eigen::Vector3d::UnitZ();
        band.vertices.row(2 * i) = out + 0.3 * arm;
        band.vertices.row(2 * i + 1) = out - 0.3 * arm;
    }
    for (int i = 0; i < n; ++i) {
        int a = 2 * ((i + 1) % n), b = a + 1;
        if (i + 1 == n && half_turns % 2) std::swap(a, b);
        add_triangle(band, 2 * i, a, 2 * i + 1);
        add_triangle(band, a, b, 2 * i + 1);
    }
    return band;
}

/// A Klein bottle: a figure of eight turned half around while it runs along a circle.
inline TriMesh klein_bottle(int n, int m) {
    TriMesh bottle;
    bottle.vertices.resize(n * m, 3);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            const double u = 2 * std::numbers::pi * i / n, v = 2 * std::numbers::pi * (j + 0.5) / m;
            const double x = std::sin(v), y = 0.7 * std::sin(2 * v), r = 3 + std::cos(u / 2) * x - std::sin(u / 2) * y;
            bottle.vertices.row(i * m + j) << r * std::cos(u), r * std::sin(u),
                std::sin(u / 2) * x + std::cos(u / 2) * y;
        }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            // After one turn the figure has turned by a half: v becomes -v.
            const auto at = [&](int row, int column) {
                if (row == n) column = 2 * m - 1 - column;
                return row % n * m + column % m;
            };
            add_triangle(bottle, at(i, j), at(i + 1, j), at(i, j + 1));
            add_triangle(bottle, at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        }
    return bottle;
}

}  // namespace strake::defective
