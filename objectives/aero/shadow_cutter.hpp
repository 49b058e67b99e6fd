#pragma once
#include "core/mesh/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <vector>

/// Cuts shadows out of triangles, in the plane perpendicular to the stream. Internal to `VisibleAreas`.
namespace strake {

using ShadowPiece = std::vector<Eigen::Vector2d>;  ///< convex polygon, anticlockwise

/// A part of a segment; empty unless from < to.
struct Interval {
    double from, to;
};

inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a[0] * b[1] - a[1] * b[0]; }
double area_of(const ShadowPiece& piece);

/// The projected triangles, in a grid of square cells.
struct ShadowCutter {
    const TriMesh& mesh;
    Eigen::Vector3d b1, b2;
    Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> at;  ///< projected vertices
    Eigen::VectorXd depth;                                         ///< along u
    std::vector<int> front;                                        ///< triangles that face the stream
    double cell = 1, tolerance = 0;
    Eigen::Vector2d low;
    int columns = 1, rows = 1;
    std::vector<int> begin, items;           ///< per cell, places in `front`, the nearest first
    std::vector<double> nearest, farthest;   ///< depths of the front triangles
    std::vector<Eigen::AlignedBox2d> boxes;  ///< of the front triangles, projected

    ShadowCutter(const TriMesh& m, const Eigen::Vector3d& u);
    void fill_grid();
    template <class Visit>
    void cells_of(int i, const Visit& visit) const;  ///< that the box of front[i] meets

    Eigen::Vector2d corner(int t, int k) const { return at.row(mesh.triangles(t, k)); }
    ShadowPiece piece_of(int t) const { return {corner(t, 0), corner(t, 1), corner(t, 2)}; }
    /// Twice the area of x with edge k of t: > 0 inside. From the smaller to the larger vertex, so that both triangles
    /// at an edge get the same bits.
    double side(int t, int k, const Eigen::Vector2d& x) const {
        const int v = mesh.triangles(t, k), w = mesh.triangles(t, (k + 1) % 3);
        const Eigen::Vector2d p = at.row(std::min(v, w)), q = at.row(std::max(v, w));
        return cross(q - p, x - p) * (v < w ? 1 : -1);
    }
    bool apart(int t, int o) const;
    bool share_edge(int t, int o) const;
    double depth_at(int t, const Eigen::Vector2d& x) const;
    void split(const ShadowPiece& piece, int t, int k, ShadowPiece* inside, ShadowPiece* outside) const;
    bool hides(int o, int t) const;
    void subtract(std::vector<ShadowPiece>& pieces, int o, double least) const;
    std::optional<std::vector<ShadowPiece>> cut_out(int i, double least, std::vector<int>& seen,
                                                    std::vector<int>& hiders) const;
    Interval within(int o, const Eigen::Vector2d& a, const Eigen::Vector2d& b, double margin) const;
    bool continues(int o, int k, const std::vector<int>& hiders) const;
    std::vector<Interval> seen_of_edge(int t, int o, int k, const std::vector<int>& hiders) const;
};

}  // namespace strake
