#pragma once
#include "bench/coarse_to_fine/comparators.hpp"

#include <string>

/// The box that a user would put around a body of cases/published: a lattice of cubic B-splines.
namespace strake::evidence {

struct LatticeBox {
    std::array<int, 3> points{4, 4, 4};  ///< along x, y, z, each at least 1: one does not vary along that axis
    std::string moves = "xyz";           ///< directions in which they move
};

/// Control points on clamped, even knots over the box of what is free; where something is held beyond one of its sides,
/// the box ends at that. Left out: points that would move what is held, motions across the plane of symmetry of points
/// that reach it, what of a motion does not keep the kind of shape (`invariance`), and motions that those before them
/// make already. @throws InvalidInput: a direction that is none, nothing that moves.
ComparedMotion lattice_box(const Problem& problem, const LatticeBox& box);

}  // namespace strake::evidence
