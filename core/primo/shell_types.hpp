#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"
#include "core/primo/attachments.hpp"
#include "core/primo/linear/linear_solver.hpp"

#include <Eigen/Geometry>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

/// Options, loads and results of the shell (shell.hpp). Units: energy length^2, force length, traction 1/length, spring
/// per area 1/length^2.
namespace strake {

/// x -> about + exp(rotation) (x - about) + translation.
struct RigidMotion {
    Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rotation vector, radians
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< length
    Eigen::Vector3d about = Eigen::Vector3d::Zero();
};

constexpr int free_prism = -1;  ///< value of ShellOptions::pin
constexpr int fixed_prism = 0;  ///< pinned with zero motion; k > 0: pinned under motions[k - 1] of `solve`

struct ShellOptions {
    Eigen::VectorXd prism_height;           ///< h per vertex, full thickness, absolute length, > 0
    std::vector<int> pin;                   ///< per triangle; empty: all free
    std::optional<SymmetryPlane> symmetry;  ///< couples boundary edges in the plane to their mirror images
    bool couple_nonmanifold = false;        ///< edges of more than two triangles: couple every pair, else refuse
    /// Parts that follow others: without unknowns, supports or loads; null: none. Their prisms count as fixed
    /// regardless of `pin`; all results of the shell place their vertices after the others'.
    std::shared_ptr<const Attachments> attached;
    LinearSolver solver = LinearSolver::automatic;
    int expected_solves =
        100;  ///< rough number of equilibria and adjoints to come; with the size, it decides `automatic`
};

struct Loads {
    Points force;            ///< F_k per vertex, n x 3; empty: none
    Eigen::VectorXd spring;  ///< lambda_k per vertex, >= 0; empty: none
};

enum class SolveStatus { converged, not_converged, unstable, cancelled };
std::string to_string(SolveStatus status);

struct SolveRecord {
    int iteration;                           ///< 0: on the coarser shell that predicts the solution
    double energy, relative_gradient, step;  ///< step in diagonals
    double seconds;
};
using SolveProgress = std::function<bool(const SolveRecord&)>;  ///< return false to cancel

struct SolveOptions {
    double min_step = 1e-9;    ///< converged below this largest prism motion, in diagonals, > 0
    int max_iterations = 60;   ///< Newton iterations over all fallbacks, >= 1; four more if the last step is small
    bool fallbacks = true;     ///< after a failed attempt try line search and load steps; false: fail early
    bool keep_factor = false;  ///< try the factor of an earlier design as preconditioner before factorizing anew
};

struct SolveTimes {
    double assembly = 0, ordering = 0, factorization = 0, substitution = 0;  ///< wall seconds
};

struct Equilibrium {
    SolveStatus status = SolveStatus::not_converged;
    std::string reason;  ///< one line of text
    double energy = std::numeric_limits<double>::quiet_NaN();
    double gradient_norm = 0;      ///< forces, torques divided by h; length
    double relative_gradient = 0;  ///< over the norm of the applied forces (of the reactions, without loads)
    int iterations = 0, factorizations = 0, substitutions = 0, load_steps = 1;
    double last_step = 0;  ///< diagonals
    bool stable = false;   ///< the exact Hessian is positive definite at the end
    /// At the start and at the end: `automatic` may change from multigrid to a factor for good.
    LinearSolver first_solver = LinearSolver::direct, solver = LinearSolver::direct;
    SolveTimes seconds;
    std::vector<SolveRecord> records;
};

/// Pose of every prism: rotation, and displacement of its rest centroid.
struct Poses {
    std::vector<Eigen::Quaterniond> rotation;
    Points displacement;
};

struct AdjointOptions {
    double tolerance = 1e-10;  ///< relative, in the energy norm; limited by round-off
    bool prism_height = true;  ///< false: dJ/dh is omitted
};

/// dJ/d(everything) of one functional at an equilibrium.
struct ShellSensitivities {
    Points vertex;                                    ///< dJ/dv itself, n x 3, as it was given
    Points force;                                     ///< dJ/dF_k, n x 3
    Eigen::VectorXd spring;                           ///< dJ/dlambda_k, n
    Eigen::VectorXd prism_height;                     ///< dJ/dh_k, n
    std::vector<Eigen::Matrix<double, 6, 1>> motion;  ///< per motion of `solve`: dJ/d(rotation, translation)
    Eigen::MatrixXd wrench;  ///< m x 6: dJ/d(twist) of each prism pinned under a motion, about its centroid;
                             ///< zero rows elsewhere; empty without motions
    Points surface;          ///< dJ/dv of the surface where `vertex` is of less than its motion; empty: `vertex` is it
};

/// A connected part of the surface can move freely; the message names it and says what to do.
struct UnheldPart : std::runtime_error {
    using runtime_error::runtime_error;
};

}  // namespace strake
