#pragma once
#include "core/mesh/mesh.hpp"
#include "core/remesh/curves.hpp"
#include "core/remesh/triangle_tree.hpp"

#include <array>
#include <vector>

/// The input of remeshing, prepared once: cut open where it is non-manifold, with its features, ready for projection.
/// Internal to core/remesh.
namespace strake {

/// What a vertex may do: move on its patch, slide along its curve, or stay.
enum class VertexRole : char { free, ridge, fixed };

struct BaseSurface {
    // A manifold with boundary: vertices with several fans have one copy per fan.
    std::vector<Eigen::Vector3d> points;
    std::vector<int> origin;              ///< per point: vertex of the input
    std::vector<std::array<int, 3>> tri;  ///< corners
    std::vector<int> twin;                ///< per half-edge 3t+k (corner k to k+1): the other one; -1: none
    std::vector<int> group;               ///< per triangle; empty: none
    std::vector<int> first_half;          ///< per point: a half-edge out of it, the first of its fan
    std::vector<Eigen::Vector3d> normal;  ///< per triangle, unit; needles take that of the triangle beside them
    std::vector<Eigen::Vector3d>
        corner_normal;             ///< per half-edge: at the point it starts from, mean over the fan between features
    std::vector<char> barrier;     ///< per half-edge: a feature; patches end here
    std::vector<int> patch;        ///< per triangle: component without crossing features
    std::vector<VertexRole> role;  ///< per point
    std::vector<FeatureEdge> features;  ///< edges of the input that are features, on their curves
    std::vector<int> feature_of;        ///< per half-edge: index into features, or -1
    Curves curves;
    TriangleTree tree;
    double diagonal = 0, area = 0, mean_edge = 0;
    double edge_length = 0;  ///< target

    int next(int h) const { return h % 3 == 2 ? h - 2 : h + 1; }
    int prev(int h) const { return h % 3 == 0 ? h + 2 : h - 1; }
    int from(int h) const { return tri[h / 3][h % 3]; }
};

struct Foot {
    Eigen::Vector3d point;
    int triangle;
    double distance2;
    double wb, wc;  ///< weights of the triangle's second and third corner
};
/// Weights of the corners of triangle t at its point x; they sum to 1.
std::array<double, 3> weights_at(const BaseSurface& base, int t, const Eigen::Vector3d& x);
/// Unit normal at point x of triangle t, varying smoothly between features.
Eigen::Vector3d normal_at(const BaseSurface& base, int t, const Eigen::Vector3d& x);
Eigen::Vector3d normal_at(const BaseSurface& base, const Foot& foot);

/// Closest point on the patch of triangle `hint`: by descent from triangle to triangle; by the tree if that ends
/// farther than `reach` or takes long.
Foot project(const BaseSurface& base, const Eigen::Vector3d& x, int hint, double reach);

}  // namespace strake
