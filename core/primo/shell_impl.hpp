#pragma once
#include "core/primo/energy.hpp"
#include "core/primo/spd_solver.hpp"

/// Inside of PrimoShell, shared by shell.cpp (state), equilibrium.cpp (Newton) and sensitivities.cpp.
namespace strake {

struct PrimoShell::Impl {
    RestState rest;
    Poses poses;
    Loads loads;                       ///< complete; of the last converged solve
    std::vector<RigidMotion> motions;  ///< of the last solve
    BlockMatrix H;                     ///< exact Hessian at `poses` when has_tangent
    bool has_tangent = false;
    std::vector<char> spring_pattern;  ///< vertices with a spring when H was laid out
    SpdSolver factor;                  ///< of an exact Hessian at factor_rotation
    std::vector<Eigen::Quaterniond> factor_rotation;
    SolveTimes seconds;

    Impl(const TriMesh& mesh, const ShellOptions& options);

    void reset_poses();
    void place_pinned(const std::vector<RigidMotion>& motions);
    /// Lays out H and orders the factor when the set of springs has changed.
    void prepare(const Eigen::VectorXd& spring);
    void assemble(const std::vector<Eigen::Matrix3d>& turn, const Jumps& stress, const Loads& loads, StressTerm term);
    bool factorize();  ///< of H at `poses`; false if indefinite
    /// Applies the kept factor in each prism's co-rotated frame: only relative rotations of neighbours spoil it.
    Eigen::MatrixXd precondition(const Eigen::MatrixXd& B);
    void advance(const Eigen::VectorXd& twist);
    /// Exact Hessian and its factor at `poses`, under the loads of the last solve.
    void need_tangent();
    /// H X = B at `poses`, to `tolerance` of each column or the round-off of H X. @pre need_tangent().
    Eigen::MatrixXd solve_tangent(const Eigen::MatrixXd& B, double tolerance = 1e-11);
    Points vertices() const;
    Points placed() const {
        return rest.attached ? vertices() : Points();
    }  ///< where attached parts are differentiated
};

/// Preconditioned conjugate gradients on the shell's current H.
struct CgResult {
    Eigen::VectorXd x;
    int iterations = 0;
    double relative_residual = 1;
    bool positive = true;  ///< no direction of negative curvature met
};
CgResult conjugate_gradients(PrimoShell::Impl& shell, const Eigen::VectorXd& b, double tolerance, int max_iterations);

/// Force and torque on a prism squared, the torque divided by the prism's height.
inline double wrench_square(const Eigen::Vector3d& torque, const Eigen::Vector3d& force, double height) {
    return torque.squaredNorm() / (height * height) + force.squaredNorm();
}

/// Largest motion of a prism (translation plus rotation times its radius), in diagonals.
double step_size(const RestState& rest, const Eigen::VectorXd& twist);

/// Left Jacobian of the rotation vector: exp(r + dr) = exp(J dr) exp(r).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& r);
Eigen::Quaterniond rotation_of(const Eigen::Vector3d& rotation_vector);

}  // namespace strake
