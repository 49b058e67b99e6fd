#pragma once
#include "optimize/space/rest_facts.hpp"

namespace strake {

/// How sharply a motion leaves what is held: the largest angle by which the normal of a free triangle turns that shares
/// an edge with a held one.
struct BorderTurn {
    double degrees = 0;
    int triangle = -1;  ///< where; -1: nothing turns, or nothing is held
};

/// @param held per triangle. @param motion n x 3, which is scaled to the largest displacement `size` (length)
/// @param adjacent of the surface
BorderTurn border_turn(const RestFacts& rest, const Adjacency& adjacent, const std::vector<char>& held,
                       const Points& motion, double size);

/// Per triangle: pinned at rest, as `border_turn` asks for it.
std::vector<char> pinned_triangles(const RestFacts& rest);

}  // namespace strake
