#pragma once
#include "optimize/problem/problem.hpp"

/// What a Problem states about the shell, in the shell's own terms.
namespace strake {

struct ShellSetup {
    ShellOptions options;  ///< heights, pins, symmetry
    Loads loads;           ///< given tractions as forces, springs per vertex
    /// Motion k moves the triangles with pin k + 1: the given strains, in order, then those of the user variables.
    std::vector<RigidMotion> motions;
    std::vector<int> user_motion;  ///< per `Parameters::user_variables`: its number in `motions`; -1: a load
    std::vector<std::vector<int>>
        user_pinned;  ///< per `Parameters::user_variables`: the triangles that follow its motion
    std::vector<std::string> warnings;
};

/// Without a shell (`Problem::has_shell`) the pins alone: what is fixed.
/// With a wrap all of it is about the wrap, which `Problem::fixed` does not hold: `supports` do.
/// Pins: fixed triangles, then the given strains, then what user variables move. A triangle that is fixed and strained
/// is fixed (warning and count); so are attached ones, which may be under nothing else.
/// @throws InvalidInput: sizes, indices out of range, a triangle in two strains, a strain without a triangle left,;
/// anything of a shell where there is none; and as `place_user_variables`.
ShellSetup shell_setup(const Problem& problem);

/// The triangles of all attached parts.
std::vector<int> attached_triangles(const Problem& problem);

/// lambda_k = sum over the triangles at k of lambda_A A_T / 3 (n), summed in triangle order. `spring_per_area` is m
/// values in 1/length^2, or empty: empty result.
Eigen::VectorXd vertex_springs(const TriMesh& rest, const Eigen::VectorXd& spring_per_area);

}  // namespace strake
