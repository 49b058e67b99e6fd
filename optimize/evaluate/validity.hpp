#pragma once
#include "core/mesh/intersection_tree.hpp"
#include "optimize/evaluate/closed_parts.hpp"
#include "optimize/evaluate/contacts.hpp"
#include "optimize/evaluate/edge_folds.hpp"

#include <functional>
#include <optional>
#include <set>

/// Is a deformed surface still one that can be handed on?
namespace strake {

struct ValidityOptions {
    std::vector<int> fixed;                 ///< triangles whose vertices must not move by a bit
    std::optional<SymmetryPlane> symmetry;  ///< closes what is open on it
    std::vector<int> attached = {};         ///< triangles that go with others (core/primo/attachments.hpp)
    bool by_map = false;  ///< the surface is moved by a map of space: `defect` with `maps` will be asked
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
///
/// A surface that is moved by a map of space alone may be any: piercing itself, of slivers, not manifold. Then:
/// - the map may not fold: the determinant of its linear part is above 0.05 at the centroid of every triangle;
/// - inverted is a triangle whose normal makes more than 90 degrees with that of its image under this linear part;
/// those
///   thinner than a thousandth of their longest edge are not judged, nor are the edges at them, as any bending of an
///   edge turns them over;
/// - intersections at contacts that are there at rest (`Contacts`) are none where the two triangles are nearer to each
///   other at rest than twice the chord errors of the map across them. (Points of two flat triangles that meet are
///   images of points that are nearer than the sum of the errors over the least stretch of the map.)
class ValidityGuard {
public:
    static constexpr double min_determinant = 0.05;  ///< of a map that does not fold

    /// @throws InvalidInput when a fixed triangle is none. Cost: one search for intersections.
    ValidityGuard(std::shared_ptr<const TriMesh> rest, const Adjacency& adjacent, const ValidityOptions& options = {});
    ValidityGuard(const TriMesh& rest, const Adjacency& adjacent, const ValidityOptions& options = {})
        : ValidityGuard(std::make_shared<const TriMesh>(rest), adjacent, options) {}

    /// The first defect in words, where it is and how many there are of its kind ("triangle 12 is inverted (3 in all),
    /// at (0.1, 0.2, 0.3)"), or an empty text for a valid surface. @throws InvalidInput on wrong sizes.
    std::string defect(const Points& vertices, const Poses& poses) const;
    /// The same of a surface that a map of space has moved. @param maps per triangle: its linear part at the centroid.
    /// @pre ValidityOptions::by_map.
    std::string defect(const Points& vertices, const std::vector<Eigen::Matrix3d>& maps) const;
    const EdgeFolds& edge_folds() const { return folds_; }

private:
    /// Per triangle: the vector that its rest normal becomes, of any length.
    using Expected = std::function<Eigen::Vector3d(int triangle)>;
    std::string defect(const Points& vertices, const Expected& expected,
                       const std::vector<Eigen::Matrix3d>* maps) const;
    std::string folding(const std::vector<Eigen::Matrix3d>& maps) const;
    double chord_error(int t, const Points& vertices, const Eigen::Matrix3d& map) const;
    void check_size(Eigen::Index vertices, std::size_t per_triangle, const char* of) const;
    void let_cuts_wander(const TriMesh& rest, const Adjacency& adjacent, const std::vector<int>& attached);
    std::string moved_fixed(const Points& vertices) const;
    std::string bad_triangles(const Points& vertices, const Expected& expected, Points& normal) const;
    std::string folded(const Points& vertices, const Points& normal) const;
    std::string intersection(const Points& vertices, const std::vector<Eigen::Matrix3d>* maps) const;

    const Triangles& triangles() const { return rest_->triangles; }

    std::shared_ptr<const TriMesh> rest_;  ///< one for all that follow
    std::vector<int> fixed_vertices_;      ///< ascending
    std::vector<int> component_;           ///< per triangle its connected part; empty where nothing is attached
    IntersectionTree tree_;
    ClosedParts parts_;
    std::set<std::pair<int, int>> piercing_;  ///< connected parts whose cut may wander, the smaller number first
    std::optional<Contacts> contacts_;        ///< of a surface that is moved by maps
    std::vector<char> is_sliver_;             ///< of the same, per triangle; else empty
    Points normal_;                           ///< at rest
    Eigen::VectorXd area_, height_;           ///< at rest: area and smallest height
    EdgeFolds folds_;
};

}  // namespace strake
