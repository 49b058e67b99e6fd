#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity/quantity.hpp"

/// Area distribution S(x): areas of parallel sections.
namespace strake {

/// Sections m . x = c_i at stations between the two ends of the surface along m. Their areas, projected along `axis`,
/// equal the area ahead of them that faces -axis; by the divergence theorem, for a closed surface,
///   S(c) = - sum over triangles of (axis . s_t) f_t(c),
/// s_t the area vector and f_t the share of the triangle with m . x < c. m need not be parallel to the axis: with
/// m = axis + (vector across) the sections are oblique and their areas the normal areas of the area rule. Excluding the
/// triangles of a base extends the body behind it as a cylinder along the axis.
struct AreaCuts {
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit
    Eigen::Vector3d m = Eigen::Vector3d::UnitX();
    std::vector<double> stations;     ///< ascending, in [0, 1]: 0 and 1 are the surface's ends
    std::vector<char> excluded = {};  ///< per triangle: not counted; empty: none
};
struct AreaDistribution {
    double begin = 0, end = 0;          ///< least and largest m . x
    int first = 0, last = 0;            ///< the vertices at these ends (tie: the smallest number)
    Eigen::VectorXd area, by_position;  ///< per station: S_i, and dS_i / dc_i at fixed vertices
};

/// Continuously differentiable in the vertices except where a triangle lies in a section.
/// Cost: O(triangles + crossings).
AreaDistribution area_distribution(const TriMesh& mesh, const AreaCuts& cuts);

/// Adds sum_i by_area[i] dS_i/dv + by_begin d begin/dv + by_end d end/dv to dJ_dv (n x 3); the stations move with the
/// ends.
void add_area_gradient(const TriMesh& mesh, const AreaCuts& cuts, const AreaDistribution& at,
                       const Eigen::VectorXd& by_area, double by_begin, double by_end, Points& dJ_dv);

/// Areas of `count` sections normal to a direction, evenly spaced between the ends of the surface: name.1 ...
/// name.count, length^2; section i lies at i / (count + 1) of the length and moves with the ends. With `symmetry`: the
/// areas of the half.
/// @throws InvalidInput: an open or inside-out surface; a count outside [1, 1000]; a zero direction, or one across the
/// plane of symmetry.
Quantity section_areas(const std::string& name, const TriMesh& start, const Eigen::Vector3d& direction, int count,
                       const std::optional<SymmetryPlane>& symmetry = {});

}  // namespace strake
