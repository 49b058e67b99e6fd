#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

/// Closest triangle among those of one patch. Internal to core/remesh.
namespace strake {

/// Closest point of triangle abc to x.
struct TrianglePoint {
    Eigen::Vector3d point;
    int side;  ///< -1 inside, 0..2 on the edge from corner `side` to the next, 3..5 at corner `side - 3`
};
TrianglePoint closest_on_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                  const Eigen::Vector3d& x);

/// Boxes over pieces of triangles: long ones are cut, so that needles do not fill the tree with empty boxes.
class TriangleTree {
public:
    TriangleTree() = default;
    TriangleTree(const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<int, 3>>& tri, double piece);
    /// The triangle of patch `wanted` closest to x, nearer than the square root of `below2`; tie: the one with the
    /// smallest number; -1: none. Small patches far away would have the whole tree searched without that bound.
    int closest(const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<int, 3>>& tri,
                const std::vector<int>& patch, int wanted, const Eigen::Vector3d& x, double below2) const;

private:
    struct Piece {
        Eigen::Vector3d low, high;
        int triangle;
    };
    struct Node {
        Eigen::Vector3d low, high;
        int begin, end, right;  ///< pieces of a leaf (right < 0); the left child is the next node
    };
    void cut(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int t, double piece,
             int depth);
    void build(int begin, int end);
    std::vector<Piece> pieces_;
    std::vector<Node> nodes_;
};

}  // namespace strake
