#pragma once
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/topology.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

/// What tests of remeshing measure, by means other than those of the code under test.
namespace strake {

struct Shape {
    double mean = 0, fifth_percentile = 0, smallest = 1;  ///< 2 inradius / circumradius
    double smallest_angle = 180, largest_angle = 0;       ///< degrees
    double regular = 0;                                   ///< share of interior vertices with six edges
    double mean_edge = 0;
};
inline Shape shape_of(const TriMesh& mesh) {
    Shape shape;
    std::vector<double> ratios;
    const Points angles = corner_angles(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        double product = 8;
        for (int k = 0; k < 3; ++k) {
            product *= std::sin(0.5 * angles(t, k));
            shape.smallest_angle = std::min(shape.smallest_angle, angles(t, k) * 180 / std::numbers::pi);
            shape.largest_angle = std::max(shape.largest_angle, angles(t, k) * 180 / std::numbers::pi);
        }
        ratios.push_back(product);
        shape.mean += product / mesh.num_triangles();
    }
    std::sort(ratios.begin(), ratios.end());
    shape.smallest = ratios.front();
    shape.fifth_percentile = ratios[ratios.size() / 20];
    const Adjacency adjacent = adjacency(mesh);
    std::vector<char> open(mesh.num_vertices(), 0);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto [a, b] = adjacent.edges[e];
        shape.mean_edge += (mesh.vertices.row(a) - mesh.vertices.row(b)).norm() / adjacent.num_edges();
        if (adjacent.edge_triangles[e].size() == 1) open[a] = open[b] = 1;
    }
    int interior = 0, regular = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (open[v]) continue;
        ++interior;
        regular += adjacent.vertex_triangles[v].size() == 6;
    }
    shape.regular = interior > 0 ? static_cast<double>(regular) / interior : 1;
    return shape;
}

/// Edges of dihedral >= `degrees`.
inline std::vector<std::array<Eigen::Vector3d, 2>> creases_of(const TriMesh& mesh, double degrees) {
    const Adjacency adjacent = adjacency(mesh);
    const Points normals = triangle_normals(mesh);
    std::vector<std::array<Eigen::Vector3d, 2>> creases;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto pair = adjacent.edge_triangles[e];
        if (pair.size() != 2) continue;
        if (dihedral(normals.row(pair[0]), normals.row(pair[1])) < degrees * std::numbers::pi / 180) continue;
        creases.push_back({mesh.vertices.row(adjacent.edges[e][0]), mesh.vertices.row(adjacent.edges[e][1])});
    }
    return creases;
}
inline std::vector<std::array<Eigen::Vector3d, 2>> boundary_of(const TriMesh& mesh) {
    const Adjacency adjacent = adjacency(mesh);
    std::vector<std::array<Eigen::Vector3d, 2>> edges;
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (adjacent.edge_triangles[e].size() == 1)
            edges.push_back({mesh.vertices.row(adjacent.edges[e][0]), mesh.vertices.row(adjacent.edges[e][1])});
    return edges;
}

inline double distance(const Eigen::Vector3d& x, const std::vector<std::array<Eigen::Vector3d, 2>>& edges) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [a, b] : edges) {
        const double t = std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (x - a - t * (b - a)).norm());
    }
    return nearest;
}
/// The farthest that an end (and, if wanted, the middle) of an edge of `from` is from those of `to`.
inline double farthest(const std::vector<std::array<Eigen::Vector3d, 2>>& from,
                       const std::vector<std::array<Eigen::Vector3d, 2>>& to, bool middles) {
    double far = 0;
    for (const auto& [a, b] : from) {
        far = std::max({far, distance(a, to), distance(b, to)});
        if (middles) far = std::max(far, distance(0.5 * (a + b), to));
    }
    return far;
}

/// Of vertices and centroids of `from`, to the surface `to`.
inline double one_sided(const TriMesh& from, const TriMesh& to) {
    const ClosestPointTree tree(to);
    double far = 0;
    for (int v = 0; v < from.num_vertices(); ++v) far = std::max(far, tree.find(from.vertices.row(v)).distance);
    const Points centroids = triangle_centroids(from);
    for (int t = 0; t < from.num_triangles(); ++t) far = std::max(far, tree.find(centroids.row(t)).distance);
    return far;
}
/// The quality that remeshing promises where no feature forbids it.
inline void expect_goals(const Shape& shape) {
    EXPECT_GT(shape.mean, 0.975);
    EXPECT_GT(shape.fifth_percentile, 0.92);
    EXPECT_GT(shape.smallest_angle, 30);
    EXPECT_LT(shape.largest_angle, 115);
    EXPECT_GT(shape.regular, 0.75);
}

inline double hausdorff(const TriMesh& a, const TriMesh& b) { return std::max(one_sided(a, b), one_sided(b, a)); }

inline int euler(const TriMesh& mesh) {
    return mesh.num_vertices() - adjacency(mesh).num_edges() + mesh.num_triangles();
}

inline bool same_bits(const TriMesh& a, const TriMesh& b) {
    return a.vertices.rows() == b.vertices.rows() && a.triangles.rows() == b.triangles.rows() &&
           a.vertices == b.vertices && a.triangles == b.triangles && a.group == b.group;
}

}  // namespace strake
