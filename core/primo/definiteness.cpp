#include "core/primo/definiteness.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/primo/vectors.hpp"

namespace strake {
namespace {

constexpr std::size_t most_probes = 6;
constexpr std::size_t least_inexact_probes = 10;  // beside a preconditioner whose own spectrum has to be explored first
constexpr double settled = 0.8;                   // a least Ritz value that falls no further is the eigenvalue
constexpr double settled_inexactly = 0.99;
constexpr double some_distrust = 1.1;    // of the largest value found
constexpr double hardly_hidden = 0.01;   // share of the noise that an unseen direction has to be below there,
constexpr double surely_hidden = 1e-16;  // and where it has not settled: far below that of any single prism's motion

/// Numbers in [-1, 1) that are the same in every run, whatever was drawn before.
double noise(std::uint64_t n) {
    n = (n + 0x9e3779b97f4a7c15ull) * 0xbf58476d1ce4e5b9ull;
    n = (n ^ (n >> 27)) * 0x94d049bb133111ebull;
    return static_cast<double>((n ^ (n >> 31)) >> 11) * 0x1p-52 - 1;
}

struct Range {
    double least, largest;
};

/// Least and largest eigenvalue of Lanczos' matrix, from the coefficients of conjugate gradients.
Range ritz_range(const std::vector<double>& alpha, const std::vector<double>& beta) {
    const auto n = static_cast<Eigen::Index>(alpha.size());
    Eigen::VectorXd diagonal(n), beside(n - 1);
    for (Eigen::Index k = 0; k < n; ++k) {
        diagonal[k] = 1 / alpha[k] + (k > 0 ? beta[k - 1] / alpha[k - 1] : 0);
        if (k + 1 < n) beside[k] = std::sqrt(beta[k]) / alpha[k];
    }
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
    eigen.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
    return {eigen.eigenvalues()[0], eigen.eigenvalues()[n - 1]};
}

/// If one direction had negative curvature, how large its share of the noise could be at most for Lanczos' least value
/// to be no lower after so many steps. By the Chebyshev polynomial of their number that is within one on [least,
/// largest]: the least value is no larger than the Rayleigh quotient of what it makes of the noise.
double largest_hidden_share(Range ritz, std::size_t steps) {
    const double x = ritz.least / (some_distrust * ritz.largest);
    const double growth = std::cosh(static_cast<double>(steps - 1) * std::acosh((1 + x) / (1 - x)));
    return (1 - x) / (x * growth * growth);
}

}  // namespace

DefinitenessProbe::DefinitenessProbe(const PrimoShell::Impl& shell, double least_stiffness, int most_inexact_probes)
    : least_stiffness_(least_stiffness),
      is_exact_(shell.kept.is_exact()),
      r_(6L * shell.rest.num_free()),
      most_(is_exact_ ? most_probes : static_cast<std::size_t>(most_inexact_probes)) {
    for (Eigen::Index i = 0; i < r_.size(); ++i) {
        const double arm = i % 6 < 3 ? shell.rest.prism_height[shell.rest.free_prisms[i / 6]] : 1;
        r_[i] = arm * noise(static_cast<std::uint64_t>(i));
    }
    is_open_ = most_ > 0;
}

void DefinitenessProbe::advance(const PrimoShell::Impl& shell, const Eigen::VectorXd& z) {
    const double next = dot(r_, z);
    if (!(next > 0) || !std::isfinite(next)) return close(Definiteness::doubtful);
    const std::size_t k = alpha_.size();
    if (k > 0) {
        beta_.push_back(next / rz_);
        scale_and_add(p_, beta_.back(), z);
    } else {
        p_ = z;
    }
    rz_ = next;
    const Eigen::VectorXd Hp = shell.product(p_);
    const double curvature = dot(p_, Hp);
    if (!(curvature > 0)) return close(Definiteness::no);
    alpha_.push_back(rz_ / curvature);
    add_multiple(r_, -alpha_.back(), Hp);
    const Range ritz = ritz_range(alpha_, beta_);
    const double before = std::exchange(least_, ritz.least);
    if (!is_exact_) {  // softer than its preconditioner everywhere: its values mean little by themselves
        if (!(least_ > 0)) return close(Definiteness::doubtful);
        const double hidden = largest_hidden_share(ritz, k + 1);
        const bool is_settled = k >= least_inexact_probes && least_ > settled_inexactly * before;
        if (hidden < (is_settled ? hardly_hidden : surely_hidden)) return close(Definiteness::yes);
    } else {
        if (least_ < least_stiffness_) return close(Definiteness::doubtful);
        if (k > 0 && least_ > settled * before) return close(Definiteness::yes);
    }
    if (alpha_.size() == most_) close(Definiteness::doubtful);
}

Definiteness probe_definiteness(PrimoShell::Impl& shell, double least_stiffness, int most_inexact_probes) {
    DefinitenessProbe probe(shell, least_stiffness, most_inexact_probes);
    while (probe.is_open()) probe.advance(shell, shell.precondition(probe.residual(), Cycle::linear));
    return probe.found();
}

}  // namespace strake
