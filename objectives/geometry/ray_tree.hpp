#pragma once
#include "core/mesh/mesh.hpp"

#include <vector>

namespace strake {

struct RayHit {
    int triangle = -1;  ///< -1: none
    double s = 0;       ///< parameter along the ray
    Eigen::Vector3d b;  ///< barycentric, of its corners in order
};

/// Boxes over the triangles of a surface, for rays. The mesh must outlive it. Thread-safe.
class RayTree {
public:
    explicit RayTree(const TriMesh& mesh);  ///< m log m
    /// The first triangle along x + s d, s > 0 (tie: the smallest number), that has no corner among those of triangle
    /// `from`. Borders count. @param d any nonzero length; s is in units of it
    RayHit first(const Eigen::Vector3d& x, const Eigen::Vector3d& d, int from) const;

private:
    struct Node {
        Eigen::Vector3d low, high;
        int begin, end, right;  ///< of a leaf right < 0; the left child is the next node
    };
    int build(int begin, int end, const Points& centroid);
    void test(int t, const Eigen::Vector3d& x, const Eigen::Vector3d& d, int from, RayHit& best) const;

    const TriMesh& mesh_;
    std::vector<int> order_;
    std::vector<Node> nodes_;
};

}  // namespace strake
