#pragma once
#include "core/mesh/mesh.hpp"

#include <array>
#include <vector>

/// The part of a surface that a parallel stream reaches.
namespace strake {

struct ShadowCutter;

/// For each triangle that faces the stream (u . n < 0): the projected area, along the unit vector u, of the part
/// without another such triangle upstream. Exact: the shadows of the others are cut out as polygons. The areas are
/// continuously differentiable in the vertices and in u except where two projected edges coincide (or a triangle's
/// normal passes u . n = 0 with other triangles behind it). The sum over all triangles is the area of the silhouette.
class VisibleAreas {
public:
    /// @param u unit vector. Cost: O(n log n) for triangles of similar size.
    /// @param with_derivatives must be true for add_gradient and derivative_along
    VisibleAreas(const TriMesh& mesh, const Eigen::Vector3d& u, bool with_derivatives);

    double area(int t) const { return area_[t]; }  ///< length^2; 0 where the triangle faces away
    bool partly_hidden(int t) const { return hidden_[t] != 0; }

    /// Adds the sum over t of weight[t] d area(t) / dv to dJ_dv (n x 3).
    void add_gradient(const Eigen::VectorXd& weight, Points& dJ_dv) const;
    /// Sum over t of weight[t] d area(t) for a change du of u, perpendicular to u.
    double derivative_along(const Eigen::VectorXd& weight, const Eigen::Vector3d& du) const;

private:
    /// A straight part of the border of a triangle's visible part, on the projected edge from vertex p to q.
    struct Border {
        int triangle, p, q;
        double along;             ///< position of its midpoint: 0 at p, 1 at q
        Eigen::Vector3d outward;  ///< normal perpendicular to u, times the length
    };
    void add_borders(const ShadowCutter& cutter, int t, int o, const std::vector<int>& hiders);

    const TriMesh& mesh_;
    Eigen::Vector3d u_;
    Eigen::VectorXd area_;
    std::vector<char> hidden_;     ///< other triangles cover some of it
    std::vector<Border> borders_;  ///< of the partly hidden ones, triangle by triangle
};

}  // namespace strake
