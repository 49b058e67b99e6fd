#pragma once
#include "core/mesh/adjacency.hpp"
#include "core/primo/shell.hpp"

/// Is a deformed surface still one that can be handed on? (DESIGN section 8.)
namespace strake {

/// A triangle is inverted when its normal makes more than 90 degrees with its rest normal turned by its own prism's
/// rotation; collapsed when its area or smallest height falls below 1e-3 of the rest value. An interior edge is folded
/// when its dihedral, below 120 degrees at rest, passes 170 degrees. Two triangles that intersect elsewhere than at
/// what they share are a defect unless they did so at the start.
class ValidityGuard {
public:
    ValidityGuard(const TriMesh& rest, const Adjacency& adjacent);

    /// The first defect in words ("triangle 12 is inverted (3 in all)"), or an empty text for a valid surface.
    std::string defect(const Points& vertices, const Poses& poses) const;

private:
    std::string intersection(const Points& vertices) const;

    Triangles triangles_;
    std::vector<std::array<int, 2>> intersecting_;  ///< pairs at rest, ascending
    Points normal_;                                 ///< at rest
    Eigen::VectorXd area_, height_;                 ///< at rest: area and smallest height
    std::vector<std::array<int, 2>> hinge_;         ///< the two triangles at interior edges that lie below 120 degrees
    std::vector<std::array<int, 2>> hinge_edge_;    ///< their vertices
};

}  // namespace strake
