#pragma once
#include "optimize/problem.hpp"

/// What a Problem states about the shell, in the shell's own terms.
namespace strake {

struct ShellSetup {
    ShellOptions options;              ///< heights, pins, symmetry
    Loads loads;                       ///< given tractions as forces, springs per vertex
    std::vector<RigidMotion> motions;  ///< motion k moves the triangles with pin k + 1: the given strains, in order
    std::vector<std::string> warnings;
};

/// Pins: fixed triangles, then the given strains. A triangle that is fixed and strained is fixed (warning and count).
/// @throws InvalidInput: sizes, indices out of range, a triangle in two strains, a strain without a triangle left.
ShellSetup shell_setup(const Problem& problem);

/// lambda_k = sum over the triangles at k of lambda_A A_T / 3 (n), summed in triangle order. `spring_per_area` is m
/// values in 1/length^2, or empty: empty result.
Eigen::VectorXd vertex_springs(const TriMesh& rest, const Eigen::VectorXd& spring_per_area);

}  // namespace strake
