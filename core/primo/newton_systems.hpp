#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/primo/conjugate_gradients.hpp"
#include "core/primo/energy.hpp"
#include "core/primo/shell_impl.hpp"

/// The linear systems of one nonlinear solve of the shell. Conjugate gradients with the factor of an earlier iteration
/// or design solve them as accurately as the next step can use; if that fails, a new factor does.
namespace strake {

/// State of a solve.
struct Iterate {
    std::vector<Eigen::Matrix3d> turn;
    Jumps jump;
    Eigen::VectorXd gradient;    ///< 6 per free prism
    double norm = 0, scale = 0;  ///< of the gradient and of the applied forces, torques divided by h
};
Iterate iterate(const PrimoShell::Impl& shell, const Loads& loads);

class NewtonSystems {
public:
    /// Counts factorizations in `end`, whose last step measures the distance to the solution. All three must outlive
    /// this.
    NewtonSystems(PrimoShell::Impl& shell, const SolveOptions& options, Equilibrium& end)
        : shell_(shell), options_(options), end_(end) {}

    /// Forgets the history of steps.
    void begin() { size_before_ = 0, contraction_ = 1, ends_below_ = 0, is_assembled_ = true, probe_.reset(); }
    /// From here on Hessians are exact, and a step below `min_step` with a negligible residual is the last.
    void begin_end(double min_step) { is_assembled_ = false, ends_below_ = min_step; }
    /// Whether the last step was final in this sense.
    bool is_done() const;
    /// Records the size of a step, in diagonals.
    void took(double step);

    /// The Newton step with the Hessian at `at` whose stress term is that of `stress`.
    /// @param reuse try the kept preconditioner first; set to false when it is rebuilt
    /// @return 6 per free prism; empty when the shell buckles
    /// @throws SolverError if the stiffness without stress is not positive definite
    Eigen::VectorXd step(const Iterate& at, const Jumps& stress, const Loads& loads, StressTerm term, bool& reuse);

    /// Whether the exact Hessian at `at`, the end, is positive definite: by conjugate gradients or, if uncertain, by a
    /// factor; if too large for a factor, by the absence of directions of negative curvature. Leaves it assembled.
    bool is_minimum(const Iterate& at, const Loads& loads);

    /// Number of indefinite matrices near the end.
    int clipped() const { return clipped_; }
    /// Whether the last step's matrix was indefinite and was made definite.
    bool was_clipped() const { return was_clipped_; }

private:
    void assemble(const Iterate& at, const Jumps& stress, const Loads& loads, StressTerm term);
    bool is_at_hand(const Loads& loads, StressTerm term) const;
    Definiteness probed();
    void factorize(const Iterate& at, const Jumps& stress, const Loads& loads);
    bool clip(const Iterate& at, const Jumps& stress, const Loads& loads);
    bool is_minimum_beside_multigrid(bool renew);
    bool is_buckling() const;
    void adapt(double size, CgOptions& cg);
    CgResult solve_inexactly(const Iterate& at);

    PrimoShell::Impl& shell_;
    const SolveOptions& options_;
    Equilibrium& end_;
    int clipped_ = 0;
    bool was_clipped_ = false;
    double ends_below_ = 0;   ///< a shorter step is the last; 0: none is
    double left_ = 1;         ///< of the last system's residual
    double before_last_ = 0;  ///< allowed residual of the current one, unless this step is the last
    double size_before_ = 0;  ///< of the last residual, in the norm of the preconditioner
    int spent_from_ = shell_.substitutions;
    double rate_ = 1;  ///< of conjugate gradients
    bool is_rate_measured_ = false;
    double moved_ = std::numeric_limits<double>::infinity();  ///< diagonals, since the preconditioner was built
    double contraction_ = 1;                                  ///< ratio of the last step to the one before
    bool is_assembled_ = true;                ///< a Hessian for the next step is assembled, maybe of the step before
    std::optional<DefinitenessProbe> probe_;  ///< of the assembled Hessian, an exact one near the end
};

}  // namespace strake
