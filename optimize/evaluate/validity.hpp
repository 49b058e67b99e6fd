#pragma once
#include "core/mesh/intersection_tree.hpp"
#include "optimize/evaluate/closed_parts.hpp"

#include <set>

/// Is a deformed surface still one that can be handed on? (DESIGN section 8.)
namespace strake {

struct ValidityOptions {
    std::vector<int> fixed;                 ///< triangles whose vertices must not move by a bit
    std::optional<SymmetryPlane> symmetry;  ///< closes what is open on it
    std::vector<int> attached = {};         ///< triangles that go with others (core/primo/attachments.hpp)
};

/// What is refused, in the order of the tests:
/// - a vertex that is not finite, or one of a fixed triangle that is not bit-identical to the start;
/// - an inverted triangle: its normal makes more than 90 degrees with its rest normal turned by its own prism's
///   rotation; a collapsed one: its area or smallest height is below 1e-3 of the rest value;
/// - a folded interior edge: its dihedral, below 120 degrees at rest, is above 170 degrees;
/// - a closed part turned inside out (ClosedParts);
/// - two triangles that intersect elsewhere than at what they share and did not at the start (IntersectionTree); but of
///   two connected parts that pierce each other at the start, one of them attached, the cut may wander;
/// - a closed part that has gone wholly into another one, or out of it.
class ValidityGuard {
public:
    /// @throws InvalidInput when a fixed triangle is none. Cost: one search for intersections.
    ValidityGuard(const TriMesh& rest, const Adjacency& adjacent, const ValidityOptions& options = {});

    /// The first defect in words, where it is and how many there are of its kind ("triangle 12 is inverted (3 in all),
    /// at (0.1, 0.2, 0.3)"), or an empty text for a valid surface. @throws InvalidInput on wrong sizes.
    std::string defect(const Points& vertices, const Poses& poses) const;

private:
    void let_cuts_wander(const TriMesh& rest, const Adjacency& adjacent, const std::vector<int>& attached);
    std::string moved_fixed(const Points& vertices) const;
    std::string bad_triangles(const Points& vertices, const Poses& poses, Points& normal) const;
    std::string folded(const Points& vertices, const Points& normal) const;
    std::string intersection(const Points& vertices) const;

    Triangles triangles_;
    Points rest_;
    std::vector<int> fixed_vertices_;  ///< ascending
    std::vector<int> component_;       ///< per triangle its connected part; empty where nothing is attached
    IntersectionTree tree_;
    ClosedParts parts_;
    std::set<std::pair<int, int>> piercing_;      ///< connected parts whose cut may wander, the smaller number first
    Points normal_;                               ///< at rest
    Eigen::VectorXd area_, height_;               ///< at rest: area and smallest height
    std::vector<std::array<int, 2>> hinge_;       ///< the two triangles at interior edges that lie below 120 degrees
    std::vector<std::array<int, 2>> hinge_edge_;  ///< their vertices
};

}  // namespace strake
