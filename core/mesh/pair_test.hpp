#pragma once
#include <Eigen/Core>
#include <array>

/// Whether two triangles of one surface meet away from shared corners. Internal to intersection_tree.cpp: a quick
/// conservative test, and an exact one for the rest.
namespace strake {

struct Corners {
    std::array<Eigen::Vector3d, 3> at;
    std::array<int, 3> id;  ///< equal numbers: a shared corner, with equal coordinates
};

/// Whether floating-point arithmetic with proven error bounds shows that they meet at most at the corners and edges
/// they share: a plane separates them, or touches them there only. About 20 ns.
bool surely_disjoint(const Corners& s, const Corners& t);

enum class Meeting {
    none,
    apart,    ///< sharing no corner
    adjacent  ///< beside the corner or the edge they share
};
/// Exact predicates (CGAL). Degenerate triangles and those with the same three corners meet nothing; topology() reports
/// them.
Meeting exact_meeting(const Corners& s, const Corners& t);

}  // namespace strake
