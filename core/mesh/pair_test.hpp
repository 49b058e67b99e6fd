#pragma once
#include <Eigen/Core>
#include <array>

/// Two triangles of one surface: do they meet elsewhere than at the corners they share? Internal to
/// intersection_tree.cpp: a quick test that is never wrong when it says no, and an exact one for what is left.
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
/// Exact predicates (CGAL). Triangles on a line and those with the same three corners meet nothing: topology() tells.
Meeting exact_meeting(const Corners& s, const Corners& t);

}  // namespace strake
