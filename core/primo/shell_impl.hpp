#pragma once
#include "core/primo/energy.hpp"
#include "core/primo/linear/preconditioner.hpp"
#include "core/primo/shell.hpp"

/// Implementation of PrimoShell, shared by shell.cpp (state), equilibrium.cpp (Newton) and sensitivities.cpp.
namespace strake {

struct PrimoShell::Impl {
    RestState rest;
    Poses poses;
    Loads loads;                       ///< complete; of the last converged solve
    std::vector<RigidMotion> motions;  ///< of the last solve
    BlockMatrix H;                     ///< exact Hessian at `poses` when has_tangent, without the springs' part
    bool has_tangent = false;
    Eigen::VectorXd spring;  ///< of the assembled Hessian, with the poses at that time; empty without springs
    std::vector<Eigen::Matrix3d> spring_turn;
    std::vector<char> spring_pattern;    ///< vertices with springs, checked to support every part
    std::optional<Equilibrium> reached;  ///< by the last solve, while the prisms have not moved since
    double reached_step = 0;             ///< its tolerance
    Preconditioner kept;                 ///< of a Hessian at kept_rotation, of this or an earlier design
    std::vector<Eigen::Quaterniond> kept_rotation;
    bool is_kept_here = false;                     ///< `kept` was built at `poses`
    std::vector<Eigen::Matrix3d> turn_since_kept;  ///< of the free prisms to `poses`; empty: not computed yet
    double rate = 0;                               ///< of conjugate gradients on `kept`, when last measured; 0: not yet
    double spent = 0;          ///< substitutions beyond the usual since `kept` was built, also by sensitivities
    int substitutions = 0;     ///< in all
    Eigen::MatrixXf adjoints;  ///< of the last functionals, if few, with the poses at that time
    std::vector<Eigen::Quaterniond> adjoint_rotation;
    SolveTimes seconds;

    Impl(RestState rest, LinearSolver solver, int expected_solves);

    void reset_poses();
    void place_pinned(const std::vector<RigidMotion>& motions);
    /// Allocates H once, and checks that every part is supported when the set of springs has changed. @throws
    /// UnheldPart
    void prepare(const Eigen::VectorXd& spring);
    void assemble(const std::vector<Eigen::Matrix3d>& turn, const Jumps& stress, const Loads& loads, StressTerm term);
    /// Builds `kept` from H at `poses`, with lumped springs; false if indefinite. Without springs, true is a proof.
    bool factorize();
    Eigen::VectorXd product(const Eigen::VectorXd& x) const;  ///< the assembled Hessian times x
    Eigen::MatrixXd products(const Eigen::MatrixXd& X) const;
    void has_moved();  ///< invalidates results at the earlier poses
    /// Applies the kept preconditioner in each prism's co-rotated frame: only relative rotations of neighbours degrade
    /// it.
    Eigen::MatrixXd precondition(const Eigen::Ref<const Eigen::MatrixXd>& B, Cycle kind = Cycle::best);
    void turn_to_kept(Eigen::MatrixXd& X, bool back);
    Points free_centroids() const;  ///< of the free prisms at `poses`
    std::vector<Eigen::Quaterniond> free_rotations() const;
    void advance(const Eigen::VectorXd& twist);
    /// Ensures the exact Hessian at `poses`, under the loads of the last solve, and a preconditioner.
    void need_tangent();
    Points vertices() const;
    Points placed() const {
        return rest.attached ? vertices() : Points();
    }  ///< positions at which attached parts are differentiated
};

/// Force and torque on a prism squared, the torque divided by the prism's height.
inline double wrench_square(const Eigen::Vector3d& torque, const Eigen::Vector3d& force, double height) {
    return torque.squaredNorm() / (height * height) + force.squaredNorm();
}

/// @throws InvalidInput unless every pinned region has a finite motion and none leaves the symmetry plane
void check_motions(const RestState& rest, const std::vector<RigidMotion>& motions);

/// Largest motion of a prism (translation plus rotation times its radius), in diagonals.
double step_size(const RestState& rest, const Eigen::VectorXd& twist);

/// Left Jacobian of the rotation vector: exp(r + dr) = exp(J dr) exp(r).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& r);
Eigen::Quaterniond rotation_of(const Eigen::Vector3d& rotation_vector);

}  // namespace strake
