#pragma once
#include "core/mesh/topology.hpp"

/// Finds where a surface passes through itself, again and again while its vertices move.
namespace strake {

/// A tree of boxes over the triangles by their place at rest; every search refits the boxes, so that its cost hardly
/// depends on how far the vertices went. A pair whose boxes meet is first tried for a separating plane in floating
/// point with proven error bounds; only what is left sees exact predicates. Nothing is missed, and the result does not
/// depend on the tree.
class IntersectionTree {
public:
    /// Cost: m log m and one search.
    explicit IntersectionTree(const TriMesh& rest);

    /// intersections(rest).
    const Intersections& at_rest() const { return at_rest_; }

    /// Pairs that intersect elsewhere than at what they share with these vertices (n x 3, finite) and did not at rest,
    /// ascending. A pair of which no vertex has moved is not looked at. Vertices at one place at rest that are still
    /// within 1e-9 of the diagonal of each other are shared; others that meet by moving are not: they touch.
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
    void build(int begin, int end, std::vector<Centre>& centres);
    Points with_closed_seams(const Points& vertices, std::vector<int>& id) const;
    Intersections search(const Points& vertices, const std::vector<char>& moved) const;

    Points rest_;
    Triangles triangles_;
    std::vector<int> twin_;   ///< per vertex: the first at the same place at rest; empty when all places differ
    double seam_ = 0;         ///< what twins may be apart
    std::vector<int> order_;  ///< triangles with three different corners, leaf by leaf
    std::vector<Node> nodes_;
    Intersections at_rest_;
};

}  // namespace strake
