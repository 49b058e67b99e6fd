#pragma once
#include "core/mesh/topology.hpp"

#include <memory>

/// Finds self-intersections of a surface, repeatedly while its vertices move.
namespace strake {

/// A bounding-box tree over the triangles at rest; each search refits the boxes, so its cost barely depends on the
/// displacement. A pair whose boxes meet is first tested for a separating plane in floating point with proven error
/// bounds; only the remaining pairs need exact predicates. Nothing is missed, and the result does not depend on the
/// tree.
class IntersectionTree {
public:
    /// Cost: m log m and one search.
    explicit IntersectionTree(std::shared_ptr<const TriMesh> rest);
    explicit IntersectionTree(const TriMesh& rest) : IntersectionTree(std::make_shared<const TriMesh>(rest)) {}

    /// intersections(rest).
    const Intersections& at_rest() const { return at_rest_; }

    /// Pairs that intersect away from shared vertices and edges with these vertices (n x 3, finite) and did not at
    /// rest, ascending. Pairs without a moved vertex are skipped. Vertices that coincide at rest and stay within 1e-9
    /// diagonals count as shared; vertices that meet by moving do not: they touch.
    std::vector<std::array<int, 2>> fresh(const Points& vertices) const;

private:
    struct Node {
        int begin, end, right;  ///< range in `order_`; right child, or -1 for a leaf; the left child is the next node
    };
    struct Search;
    struct Centre {
        Eigen::Vector3d at;
        int triangle;
    };
    void set_order();
    void build(int begin, int end, std::vector<Centre>& centres);
    Points with_closed_seams(const Points& vertices, std::vector<int>& id) const;
    Intersections search(const Points& vertices, const std::vector<char>& moved) const;

    std::shared_ptr<const TriMesh> rest_;
    std::vector<int> twin_;   ///< per vertex: the first at the same place at rest; empty when all places differ
    double seam_ = 0;         ///< largest distance of twins
    std::vector<int> order_;  ///< triangles with three different corners, leaf by leaf
    std::vector<Node> nodes_;
    Intersections at_rest_;
};

}  // namespace strake
