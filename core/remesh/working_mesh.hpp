#pragma once
#include "core/remesh/base_surface.hpp"

#include <Eigen/Geometry>

/// The surface being remeshed. Connectivity in flat arrays: half-edge 3t+k runs from corner k of triangle t to the next
/// one; removed triangles keep their place until compact(). Internal to core/remesh.
namespace strake {

/// 2 sqrt(3) |n| / (sum of squared edges), n the area vector times two: 1 equilateral, 0 degenerate.
inline double shape_quality(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const Eigen::Vector3d u = b - a, w = c - a;
    const double sum = u.squaredNorm() + w.squaredNorm() + (c - b).squaredNorm();
    return sum > 0 ? 3.4641016151377544 * u.cross(w).norm() / sum : 0.0;
}

struct WorkingMesh {
    const BaseSurface* base = nullptr;
    // Per vertex.
    std::vector<Eigen::Vector3d> pos;
    std::vector<Eigen::Vector3d> normal;  ///< of the input's triangle `foot`
    std::vector<int> foot;                ///< triangle of the input at or near the vertex
    std::vector<int> half;                ///< a half-edge out of it; on a boundary the one that has no twin
    std::vector<int> valence;             ///< edges
    std::vector<int> origin;              ///< vertex of the input, for unchanged vertices; else -1
    std::vector<double> size;             ///< target edge length
    std::vector<double> limit;            ///< limit in thin places; infinite elsewhere
    std::vector<VertexRole> role;
    std::vector<char>
        bent;  ///< the input bends more sharply than the shortest edges resolve: its normal is meaningless
    std::vector<char> settled;  ///< nothing to smooth until something changes nearby
    // Per half-edge.
    std::vector<int> corner, twin, feature;  ///< vertex it starts at, -1 removed; other half, -1 none; or -1
    std::vector<int> group;                  ///< per triangle, empty: none
    std::vector<int> patch;                  ///< per triangle: that of the input which it covers
    std::vector<FeatureEdge> features;
    std::vector<int> mark;  ///< scratch per vertex
    int stamp = 0;
    int compact_triangles = 0,
        changes = 0;  ///< at the last compact(); triangles made and removed since they were sorted

    static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static int prev(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
    int num_vertices() const { return static_cast<int>(pos.size()); }
    int num_triangles() const { return static_cast<int>(corner.size() / 3); }
    bool is_alive(int t) const { return corner[3 * t] >= 0; }
    int num_alive() const {
        int count = 0;
        for (int t = 0; t < num_triangles(); ++t) count += is_alive(t);
        return count;
    }
    int from(int h) const { return corner[h]; }
    int to(int h) const { return corner[next(h)]; }
    int apex(int h) const { return corner[prev(h)]; }
    double length2(int h) const { return (pos[to(h)] - pos[from(h)]).squaredNorm(); }
    double wanted(int a, int b) const { return 0.5 * (size[a] + size[b]); }
    bool is_boundary(int v) const { return twin[half[v]] < 0; }
    Eigen::Vector3d area_vector2(int t) const {
        const Eigen::Vector3d& a = pos[corner[3 * t]];
        return (pos[corner[3 * t + 1]] - a).cross(pos[corner[3 * t + 2]] - a);
    }

    /// Every half-edge out of v, counter-clockwise; f returns false to stop.
    template <class F>
    void around(int v, F&& f) const {
        const int first = half[v];
        for (int h = first; f(h);) {
            h = twin[prev(h)];
            if (h < 0 || h == first) return;
        }
    }
    /// Every neighbour of v.
    template <class F>
    void neighbours(int v, F&& f) const {
        const int first = half[v];
        for (int h = first;;) {
            f(to(h));
            const int back = prev(h);
            h = twin[back];
            if (h < 0) return f(from(back));
            if (h == first) return;
        }
    }
    bool are_neighbours(int a, int b) const {
        bool found = false;
        neighbours(valence[a] <= valence[b] ? a : b,
                   [&](int v) { found = found || v == (valence[a] <= valence[b] ? b : a); });
        return found;
    }

    double quality(int t) const {
        return shape_quality(pos[corner[3 * t]], pos[corner[3 * t + 1]], pos[corner[3 * t + 2]]);
    }
    void wake(int v) { settled[v] = 0; }
    void wake_around(int v) {
        settled[v] = 0;
        neighbours(v, [&](int u) { settled[u] = 0; });
    }

    /// Splits edge h at a new vertex at its middle, on a curve as near to it as allowed.
    int split(int h);
    double split_place(int f) const;  ///< where on its curve feature f is cut
    /// Turns edge h (interior, no feature) to join the apexes.
    void flip(int h);
    /// Removes the end `gone` of edge h and connects its triangles to the other end. @pre can_collapse(h, gone).
    void collapse(int h, int gone);
    /// The link condition, and the limits of roles.
    bool can_collapse(int h, int gone);
    /// Whether the chord after a collapse of feature h fits the curve (Curves::chord_fits).
    bool collapse_fits_curve(int h, int gone, double slack) const;

    /// The feature at ridge v that is not f; -1: none.
    int other_feature(int v, int f) const;
    /// Places v at its position on its curve.
    void place_on_curve(int v, int curve, double s);
    /// Foot and normal of vertex m, new in the middle of edge h.
    void find_foot(int m, int h);

    /// Renumbers vertices, triangles and features without gaps, unless the removed share is below `few`; in spatial
    /// order after many changes.
    void compact(double few = 0);

private:
    int new_triangle(int a, int b, int c, int like);
    void set_half(int v, int out);           ///< from a half-edge out of v: the one on the boundary, if there is one
    int split_feature(int f, int a, int m);  ///< f keeps its end at a; the number of the rest
    void join(int h, int g) {
        if (h >= 0) twin[h] = g;
        if (g >= 0) twin[g] = h;
    }
};

WorkingMesh working_mesh(const BaseSurface& base);

/// The mesh as a value. Merges copies of unchanged vertices of the input.
TriMesh as_mesh(const WorkingMesh& mesh, const std::vector<std::string>& group_names);

}  // namespace strake
