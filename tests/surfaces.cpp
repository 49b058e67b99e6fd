#include "surfaces.hpp"

#include "core/mesh/geometry.hpp"
#include "core/mesh/weld.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

namespace strake {
namespace {

TriMesh make(const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<int, 3>>& triangles) {
    TriMesh mesh;
    mesh.vertices.resize(points.size(), 3);
    mesh.triangles.resize(triangles.size(), 3);
    for (std::size_t i = 0; i < points.size(); ++i) mesh.vertices.row(i) = points[i];
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (int k = 0; k < 3; ++k) mesh.triangles(i, k) = triangles[i][k];
    return mesh;
}

/// Merges equal vertices (bit for bit), in the order of first appearance.
TriMesh welded(const std::vector<std::array<Eigen::Vector3d, 3>>& soup) {
    std::map<std::array<double, 3>, int> index;
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 3>> triangles;
    for (const auto& corners : soup) {
        std::array<int, 3> t{};
        for (int k = 0; k < 3; ++k) {
            const auto [at, fresh] =
                index.try_emplace({corners[k].x(), corners[k].y(), corners[k].z()}, static_cast<int>(points.size()));
            if (fresh) points.push_back(corners[k]);
            t[k] = at->second;
        }
        triangles.push_back(t);
    }
    return make(points, triangles);
}

std::vector<int> shuffled(int n, std::uint64_t state) {
    std::vector<int> order(n);
    std::iota(order.begin(), order.end(), 0);
    for (int i = n - 1; i > 0; --i) {
        state ^= state << 13, state ^= state >> 7, state ^= state << 17;
        std::swap(order[i], order[state % (i + 1)]);
    }
    return order;
}

}  // namespace

TriMesh box_surface(const Eigen::Vector3d& size, int cells) {
    std::vector<std::array<Eigen::Vector3d, 3>> soup;
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side)
            for (int i = 0; i < cells; ++i)
                for (int j = 0; j < cells; ++j) {
                    const auto corner = [&](int a, int b) {
                        Eigen::Vector3d p;
                        p[axis] = side * size[axis];
                        p[(axis + 1) % 3] = size[(axis + 1) % 3] * a / cells;
                        p[(axis + 2) % 3] = size[(axis + 2) % 3] * b / cells;
                        return p;
                    };
                    const Eigen::Vector3d a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1),
                                          d = corner(i, j + 1);
                    if (side == 1)
                        soup.push_back({a, b, c}), soup.push_back({a, c, d});
                    else
                        soup.push_back({a, c, b}), soup.push_back({a, d, c});
                }
    return welded(soup);
}

TriMesh half_above(const TriMesh& mesh, double at) {
    TriMesh half = mesh;
    const Points centroids = triangle_centroids(mesh);
    int count = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (centroids(t, 1) > at) half.triangles.row(count++) = mesh.triangles.row(t);
    half.triangles.conservativeResize(count, 3);
    return half;
}

HalfAndWhole crooked_box(int cells) {
    TriMesh box = box_surface({3, 2, 1}, cells);
    for (int v = 0; v < box.num_vertices(); ++v) {
        const double x = box.vertices(v, 0), y = box.vertices(v, 1) - 1, z = box.vertices(v, 2);
        box.vertices.row(v) += Eigen::RowVector3d(0.4 * y * y + 0.2 * std::sin(2 * z), 0.1 * y * std::cos(x),
                                                  0.3 * std::sin(x) + 0.2 * y * y * x);
    }
    const TriMesh half = half_above(box, 1);
    TriMesh both = half;
    const int nv = half.num_vertices(), nt = half.num_triangles();
    both.vertices.conservativeResize(2 * nv, 3);
    both.triangles.conservativeResize(2 * nt, 3);
    both.vertices.bottomRows(nv) = half.vertices;
    both.vertices.col(1).tail(nv) = 2 - half.vertices.col(1).array();
    for (int t = 0; t < nt; ++t)
        both.triangles.row(nt + t) << nv + half.triangles(t, 0), nv + half.triangles(t, 2), nv + half.triangles(t, 1);
    return {half, welded(both)};
}

TriMesh refined(const TriMesh& mesh) {
    std::vector<Eigen::Vector3d> points;
    for (int v = 0; v < mesh.num_vertices(); ++v) points.push_back(mesh.vertices.row(v));
    std::map<std::pair<int, int>, int> middle;
    const auto mid = [&](int a, int b) {
        const auto [at, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<int>(points.size()));
        if (fresh) points.push_back(0.5 * (points[a] + points[b]));
        return at->second;
    };
    std::vector<std::array<int, 3>> triangles;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const int a = mesh.triangles(t, 0), b = mesh.triangles(t, 1), c = mesh.triangles(t, 2);
        const int ab = mid(a, b), bc = mid(b, c), ca = mid(c, a);
        triangles.insert(triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    return make(points, triangles);
}

TriMesh icosphere(int subdivisions) {
    const double g = std::numbers::phi;
    TriMesh mesh = make({{-1, g, 0},
                         {1, g, 0},
                         {-1, -g, 0},
                         {1, -g, 0},
                         {0, -1, g},
                         {0, 1, g},
                         {0, -1, -g},
                         {0, 1, -g},
                         {g, 0, -1},
                         {g, 0, 1},
                         {-g, 0, -1},
                         {-g, 0, 1}},
                        {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                         {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                         {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}});
    for (int s = 0; s < subdivisions; ++s) {
        mesh = refined(mesh);
        for (int v = 0; v < mesh.num_vertices(); ++v) mesh.vertices.row(v).normalize();
    }
    for (int v = 0; v < mesh.num_vertices(); ++v) mesh.vertices.row(v).normalize();
    return mesh;
}

TriMesh ellipsoid(const Eigen::Vector3d& radii, int subdivisions) {
    TriMesh mesh = icosphere(subdivisions);
    mesh.vertices = mesh.vertices * radii.asDiagonal();
    return mesh;
}

TriMesh strip(double length, double width, int cells_x, int cells_y, int pattern) {
    std::vector<Eigen::Vector3d> points;
    for (int j = 0; j <= cells_y; ++j)
        for (int i = 0; i <= cells_x; ++i) points.emplace_back(length * i / cells_x, width * j / cells_y, 0);
    std::vector<std::array<int, 3>> triangles;
    for (int j = 0; j < cells_y; ++j)
        for (int i = 0; i < cells_x; ++i) {
            const int a = j * (cells_x + 1) + i, b = a + 1, d = a + cells_x + 1, c = d + 1;
            if (pattern == 1 && (i + j) % 2)
                triangles.insert(triangles.end(), {{a, b, d}, {b, c, d}});
            else
                triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
        }
    return make(points, triangles);
}

TriMesh hinge(double edge, double depth) {
    return make({{0, -edge / 2, 0}, {0, edge / 2, 0}, {-depth, 0, 0}, {depth, 0, 0}}, {{0, 1, 2}, {1, 0, 3}});
}

TriMesh capped_cylinder(int facets, int rings, double radius, double length) {
    std::vector<Eigen::Vector3d> points;
    for (int r = 0; r <= rings; ++r)
        for (int f = 0; f < facets; ++f) {
            const double a = 2 * std::numbers::pi * f / facets;
            points.emplace_back(length * r / rings, radius * std::cos(a), radius * std::sin(a));
        }
    std::vector<std::array<int, 3>> triangles;
    for (int r = 0; r < rings; ++r)
        for (int f = 0; f < facets; ++f) {
            const int a = r * facets + f, b = r * facets + (f + 1) % facets, c = b + facets, d = a + facets;
            triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
        }
    const int base = static_cast<int>(points.size()), top = base + 1;
    points.emplace_back(0, 0, 0);
    points.emplace_back(length, 0, 0);
    for (int f = 0; f < facets; ++f) {
        triangles.push_back({base, (f + 1) % facets, f});
        triangles.push_back({top, rings * facets + f, rings * facets + (f + 1) % facets});
    }
    return make(points, triangles);
}

TriMesh renumbered(const TriMesh& mesh, unsigned seed, std::vector<int>* vertex_order,
                   std::vector<int>* triangle_order) {
    const std::vector<int> v = shuffled(mesh.num_vertices(), 2 * seed + 1),
                           t = shuffled(mesh.num_triangles(), 2 * seed + 77);
    std::vector<int> place(v.size());
    for (std::size_t i = 0; i < v.size(); ++i) place[v[i]] = static_cast<int>(i);
    TriMesh result = mesh;
    for (std::size_t i = 0; i < v.size(); ++i) result.vertices.row(i) = mesh.vertices.row(v[i]);
    for (std::size_t i = 0; i < t.size(); ++i)
        for (int k = 0; k < 3; ++k) result.triangles(i, k) = place[mesh.triangles(t[i], (k + i % 3) % 3)];
    if (vertex_order) *vertex_order = v;
    if (triangle_order) *triangle_order = t;
    return result;
}

}  // namespace strake
