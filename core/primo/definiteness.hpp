#pragma once
#include "core/primo/shell_impl.hpp"

namespace strake {

enum class Definiteness { yes, no, doubtful };

/// Is the shell's Hessian positive definite? Lanczos from noise: forces on all prisms move the soft modes most, and one
/// of them turns indefinite first. Beside a definite factor two to six substitutions tell, beside multigrid ten to
/// twenty linear cycles. "no" is a proof: a direction of negative curvature was met. One step at a time, so that its
/// substitutions can go along with those of a solve.
class DefinitenessProbe {
public:
    /// @param least_stiffness share of a direction's stiffness in the factor that has to be left without a doubt
    /// @param most_inexact_probes cycles of multigrid that may be spent
    DefinitenessProbe(const PrimoShell::Impl& shell, double least_stiffness, int most_inexact_probes = 40);

    bool is_open() const { return is_open_; }
    Definiteness found() const { return found_; }  ///< doubtful while it is open
    /// To be handed to the preconditioner, as a linear one, and what that made of it back to `advance`.
    const Eigen::VectorXd& residual() const { return r_; }
    /// @pre is_open(); the Hessian is the same in all steps.
    void advance(const PrimoShell::Impl& shell, const Eigen::VectorXd& z);

private:
    void close(Definiteness found) { found_ = found, is_open_ = false; }

    double least_stiffness_, rz_ = 0, least_ = std::numeric_limits<double>::infinity();
    bool is_exact_, is_open_ = true;
    Definiteness found_ = Definiteness::doubtful;
    Eigen::VectorXd r_, p_;
    std::vector<double> alpha_, beta_;
    std::size_t most_;
};

/// A probe from its first step to its end.
Definiteness probe_definiteness(PrimoShell::Impl& shell, double least_stiffness, int most_inexact_probes = 40);

}  // namespace strake
