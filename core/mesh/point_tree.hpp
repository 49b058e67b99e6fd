#pragma once
#include "core/mesh/mesh.hpp"

#include <utility>
#include <vector>

/// Nearest points of a set.
namespace strake {

/// A k-d tree over a copy of the points. Queries are exact, thread-safe and the same on every machine.
class PointTree {
public:
    explicit PointTree(const Points& points);  ///< n x 3, finite, n >= 0

    /// The nearest point's number (tie: the smallest) and its distance; -1 and infinity without points.
    std::pair<int, double> nearest(const Eigen::Vector3d& x) const;
    /// Numbers of all points at a distance <= radius, ascending; `found` is emptied first.
    void within(const Eigen::Vector3d& x, double radius, std::vector<int>& found) const;

    /// Numbers of all points at a distance <= radius from the segment from p to q, ascending; some that are farther by
    /// rounding are among them. `found` is emptied first. Time does not grow with how long the segment is.
    void near_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& q, double radius, std::vector<int>& found) const;

private:
    /// @param node whose box is that of the range; its halves are 2 node + 1 and 2 node + 2
    void build(int begin, int end, std::size_t node);
    void search(int begin, int end, const Eigen::Vector3d& x, int& best, double& least) const;
    void collect(int begin, int end, const Eigen::Vector3d& x, double radius, std::vector<int>& found) const;
    void collect(int begin, int end, std::size_t node, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                 double radius, std::vector<int>& found) const;

    Points points_;            ///< in the order of the tree: the middle of a range divides it
    std::vector<int> number_;  ///< of each of them in the input
    std::vector<char> axis_;   ///< in which the middle divides
    struct Box {
        Eigen::RowVector3d low, high;
    };
    std::vector<Box> box_;  ///< per node
};

}  // namespace strake
