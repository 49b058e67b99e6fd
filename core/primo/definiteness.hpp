#pragma once
#include "core/primo/shell_impl.hpp"

namespace strake {

enum class Definiteness { yes, no, uncertain };

/// Is the shell's Hessian positive definite? Lanczos iteration from random forces: these excite the soft modes most,
/// and a soft mode becomes indefinite first. With a definite factor it takes two to six substitutions, with multigrid
/// ten to twenty linear cycles. "no" is a proof: a direction of negative curvature was found. Runs step by step, to
/// share the substitutions of a solve.
class DefinitenessProbe {
public:
    /// @param min_stiffness least share of a direction's stiffness in the factor that counts as certain
    /// @param max_inexact_probes multigrid cycles allowed
    DefinitenessProbe(const PrimoShell::Impl& shell, double min_stiffness, int max_inexact_probes = 40);

    bool is_open() const { return is_open_; }
    Definiteness found() const { return found_; }  ///< uncertain while open
    /// Vector for the (linear) preconditioner; pass its result to `advance`.
    const Eigen::VectorXd& residual() const { return r_; }
    /// @pre is_open(); the Hessian is the same in all steps.
    void advance(const PrimoShell::Impl& shell, const Eigen::VectorXd& z);

private:
    void close(Definiteness found) { found_ = found, is_open_ = false; }

    double min_stiffness_, rz_ = 0, smallest_ = std::numeric_limits<double>::infinity();
    bool is_exact_, is_open_ = true;
    Definiteness found_ = Definiteness::uncertain;
    Eigen::VectorXd r_, p_;
    std::vector<double> alpha_, beta_;
    std::size_t max_probes_;
};

/// Runs a probe to its end.
Definiteness probe_definiteness(PrimoShell::Impl& shell, double min_stiffness, int max_inexact_probes = 40);

}  // namespace strake
