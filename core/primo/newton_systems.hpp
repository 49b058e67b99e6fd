#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/primo/conjugate_gradients.hpp"
#include "core/primo/energy.hpp"
#include "core/primo/shell_impl.hpp"

/// The linear systems of one nonlinear solve of the shell: solved by conjugate gradients on the factor of an earlier
/// iteration or design, as exactly as the next step can make use of; on a factor of their own where that does not do.
namespace strake {

/// Where a solve is.
struct Iterate {
    std::vector<Eigen::Matrix3d> turn;
    Jumps jump;
    Eigen::VectorXd gradient;    ///< 6 per free prism
    double norm = 0, scale = 0;  ///< of the gradient and of the applied forces, torques divided by h
};
Iterate iterate(const PrimoShell::Impl& shell, const Loads& loads);

class NewtonSystems {
public:
    /// Factorizations are counted in `end`, whose last step says how near the end is. All three must outlive this.
    NewtonSystems(PrimoShell::Impl& shell, const SolveOptions& options, Equilibrium& end)
        : shell_(shell), options_(options), end_(end) {}

    /// Forgets how the last steps went.
    void begin() { size_before_ = 0, contraction_ = 1, ends_below_ = 0, is_assembled_ = true, probe_.reset(); }
    /// From here on Hessians are exact, and a step shorter than that which leaves next to nothing is the last.
    void begin_end(double min_step) { is_assembled_ = false, ends_below_ = min_step; }
    /// Whether the last step was such a one.
    bool is_done() const;
    /// Says that a step of that size was taken, in diagonals.
    void took(double step);

    /// The Newton step with the Hessian at `at` whose stress term is that of `stress`.
    /// @param reuse try what is kept first; else, and from then on, it is built anew
    /// @return 6 per free prism; empty where the shell buckles
    /// @throws SolverError where the stiffness without stress is not positive definite
    Eigen::VectorXd step(const Iterate& at, const Jumps& stress, const Loads& loads, StressTerm term, bool& reuse);

    /// Whether the exact Hessian at `at`, the end, is positive definite: by conjugate gradients, or in doubt by a
    /// factor; beyond what a factor can hold, in doubt, where no direction of negative curvature was met. Leaves it
    /// assembled.
    bool is_minimum(const Iterate& at, const Loads& loads);

    /// Indefinite matrices met near the end.
    int clipped() const { return clipped_; }
    /// Whether the last step's matrix was indefinite, and made definite.
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
    double ends_below_ = 0;   ///< steps are the last below it; 0: none is
    double left_ = 1;         ///< of the last system's residual
    double before_last_ = 0;  ///< as much of the present one may be left, unless this step is the last
    double size_before_ = 0;  ///< of the last residual, in the norm of what is kept
    int spent_from_ = shell_.substitutions;
    double rate_ = 1;  ///< of conjugate gradients
    bool is_rate_measured_ = false;
    double moved_ = std::numeric_limits<double>::infinity();  ///< diagonals, since what is kept was built
    double contraction_ = 1;                                  ///< of the last step beside the one before
    bool is_assembled_ = true;  ///< such a Hessian as the steps are to be taken with, be it that of the step before
    std::optional<DefinitenessProbe> probe_;  ///< of the assembled Hessian, an exact one near the end
};

}  // namespace strake
