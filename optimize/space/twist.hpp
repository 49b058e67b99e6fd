#pragma once
#include "optimize/problem/problem.hpp"

/// Twist of sections about a stated axis at several stations along it, as user variables: each turns the section at
/// its station and leaves those at the others where they are.
namespace strake {

struct TwistSpec {
    std::string name;                                 ///< the variables are called name.1, name.2, ...
    std::vector<int> triangles;                       ///< of the surface that is twisted, ascending
    Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< unit; twist is positive by the right hand
    Eigen::Vector3d about = Eigen::Vector3d::Zero();  ///< a point on the axis
    std::vector<double> stations;                     ///< axis . (x - about), rising; empty: `count` of them
    int count = 3;                                    ///< evenly from end to end of the triangles, >= 2
    double max_angle = 0.1;                           ///< radians at x = 1, > 0
};

struct TwistVariables {
    std::vector<UserVariable> variables;  ///< of the stations that are not held; physical value: radians
    std::vector<double> stations;         ///< all of them
    std::vector<char> held;               ///< per station: most of its section is fixed or strained
};

/// The loads that twist. The motion of the sections is the least-squares fit, over the area of the triangles, of
/// d = sum_k hat_k (theta_k axis x r + tau_k) to the displacement; the hats are linear between the stations and
/// constant beyond the first and the last, tau_k is across the axis, and both are zero where a section is held.
/// Variable k has theta_k = 1 and all other theta and tau zero in the linear response at rest: of all shapes with this
/// motion of the sections the one of least energy. Cost: a factorization and three back-substitutions a station.
/// @throws InvalidInput: limits, a station beside the surface, all of them held, stations too close. UnheldPart.
TwistVariables twist_variables(const Problem& problem, const TwistSpec& spec);

/// theta_k of a displacement field (n x 3) in radians, the fit above; zero where a section is held.
Eigen::VectorXd section_twists(const TriMesh& rest, const TwistSpec& spec, const std::vector<char>& held,
                               const Points& displacement);

}  // namespace strake
