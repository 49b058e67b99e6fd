#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

/// Closest triangle among those of one patch. Internal to core/remesh.
namespace strake {

/// Closest point of triangle abc to x.
struct TrianglePoint {
    Eigen::Vector3d point;
    int side;       ///< -1 inside, 0..2 on the edge from corner `side` to the next, 3..5 at corner `side - 3`
    double wb, wc;  ///< weights of corners b and c
};
inline TrianglePoint closest_on_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                         const Eigen::Vector3d& x) {
    // The seven regions of a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
    const Eigen::Vector3d ab = b - a, ac = c - a, ax = x - a;
    const double d1 = ab.dot(ax), d2 = ac.dot(ax);
    if (d1 <= 0 && d2 <= 0) return {a, 3, 0, 0};
    const Eigen::Vector3d bx = x - b;
    const double d3 = ab.dot(bx), d4 = ac.dot(bx);
    if (d3 >= 0 && d4 <= d3) return {b, 4, 1, 0};
    const Eigen::Vector3d cx = x - c;
    const double d5 = ab.dot(cx), d6 = ac.dot(cx);
    if (d6 >= 0 && d5 <= d6) return {c, 5, 0, 1};
    const double wc = d1 * d4 - d3 * d2;
    if (wc <= 0 && d1 >= 0 && d3 <= 0) {
        const double t = d1 / (d1 - d3);
        return {a + t * ab, 0, t, 0};
    }
    const double wb = d5 * d2 - d1 * d6;
    if (wb <= 0 && d2 >= 0 && d6 <= 0) {
        const double t = d2 / (d2 - d6);
        return {a + t * ac, 2, 0, t};
    }
    const double wa = d3 * d6 - d5 * d4;
    if (wa <= 0 && d4 >= d3 && d5 >= d6) {
        const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {b + t * (c - b), 1, 1 - t, t};
    }
    const double whole = wa + wb + wc;
    if (!(whole > 0)) return {a, 3, 0, 0};
    return {a + wb / whole * ab + wc / whole * ac, -1, wb / whole, wc / whole};
}

/// Boxes over pieces of triangles: long ones are cut, so that needles do not fill the tree with empty boxes.
class TriangleTree {
public:
    TriangleTree() = default;
    /// @param tri in order of space: where none is long, that saves sorting them.
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
    void build(int begin, int end, bool is_in_order);
    void part(int begin, int middle, int end);
    std::vector<Piece> pieces_;
    std::vector<Node> nodes_;
};

}  // namespace strake
