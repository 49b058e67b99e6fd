#pragma once
#include "core/mesh/mesh.hpp"

#include <array>
#include <vector>

/// What of a surface a stream of parallel rays reaches.
namespace strake {

struct ShadowCutter;

/// Per triangle that faces the stream (u . n < 0) the area of the part that no other such triangle lies upstream of,
/// projected along the unit vector u. Exact: the shadows of the others are cut out as polygons. So the areas are
/// continuous in the vertices and in u, and so are their derivatives but where two projected edges come to lie on each
/// other (or a triangle's normal passes u . n = 0 with other triangles behind it).
/// The sum over all triangles is the area of the silhouette.
class VisibleAreas {
public:
    /// @param u unit vector. Cost: O(n log n) for triangles of similar size.
    /// @param with_derivatives without, add_gradient and derivative_along are not to be asked.
    VisibleAreas(const TriMesh& mesh, const Eigen::Vector3d& u, bool with_derivatives);

    double area(int t) const { return area_[t]; }  ///< length^2; 0 where the triangle faces away
    bool partly_hidden(int t) const { return hidden_[t] != 0; }

    /// Adds sum over t of weight[t] d area(t) / dv to dJ_dv (n x 3).
    void add_gradient(const Eigen::VectorXd& weight, Points& dJ_dv) const;
    /// sum over t of weight[t] d area(t) when u changes by du (across u).
    double derivative_along(const Eigen::VectorXd& weight, const Eigen::Vector3d& du) const;

private:
    /// A straight part of the border of what is seen of a triangle, on the projected edge from vertex p to q.
    struct Border {
        int triangle, p, q;
        double along;             ///< of its middle: 0 at p, 1 at q
        Eigen::Vector3d outward;  ///< normal across u, times the length
    };
    void add_borders(const ShadowCutter& cutter, int t, int o, const std::vector<int>& hiders);

    const TriMesh& mesh_;
    Eigen::Vector3d u_;
    Eigen::VectorXd area_;
    std::vector<char> hidden_;     ///< other triangles cover some of it
    std::vector<Border> borders_;  ///< of the partly hidden ones, triangle by triangle
};

}  // namespace strake
