#include "core/primo/definiteness.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/primo/linear/vectors.hpp"

namespace strake {
namespace {

constexpr std::size_t max_probes = 6;
constexpr std::size_t min_inexact_probes = 10;  // beside a preconditioner whose own spectrum has to be explored first
constexpr double settled = 0.8;                 // a least Ritz value that stops decreasing is the eigenvalue
constexpr double settled_inexactly = 0.99;
constexpr double some_distrust = 1.1;    // of the largest value found
constexpr double hardly_hidden = 0.01;   // largest share of the noise in an undetected direction there,
constexpr double surely_hidden = 1e-16;  // and before it settles: far below that of any single prism's motion

/// Random numbers in [-1, 1), the same in every run.
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

/// Largest share of the noise in a direction of negative curvature that is consistent with Lanczos' least value after
/// this many steps. Uses the Chebyshev polynomial of that degree, bounded by one on [least, largest]: the least value
/// is at most the Rayleigh quotient of the noise transformed by it.
double largest_hidden_share(Range ritz, std::size_t steps) {
    const double x = ritz.least / (some_distrust * ritz.largest);
    const double growth = std::cosh(static_cast<double>(steps - 1) * std::acosh((1 + x) / (1 - x)));
    return (1 - x) / (x * growth * growth);
}

}  // namespace

DefinitenessProbe::DefinitenessProbe(const PrimoShell::Impl& shell, double min_stiffness, int max_inexact_probes)
    : min_stiffness_(min_stiffness),
      is_exact_(shell.kept.is_exact()),
      r_(6L * shell.rest.num_free()),
      max_probes_(is_exact_ ? max_probes : static_cast<std::size_t>(max_inexact_probes)) {
    for (Eigen::Index i = 0; i < r_.size(); ++i) {
        const double arm = i % 6 < 3 ? shell.rest.prism_height[shell.rest.free_prisms[i / 6]] : 1;
        r_[i] = arm * noise(static_cast<std::uint64_t>(i));
    }
    is_open_ = max_probes_ > 0;
}

void DefinitenessProbe::advance(const PrimoShell::Impl& shell, const Eigen::VectorXd& z) {
    const double next = dot(r_, z);
    if (!(next > 0) || !std::isfinite(next)) return close(Definiteness::uncertain);
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
    const double before = std::exchange(smallest_, ritz.least);
    if (!is_exact_) {  // softer than its preconditioner everywhere: only ratios of its values are meaningful
        if (!(smallest_ > 0)) return close(Definiteness::uncertain);
        const double hidden = largest_hidden_share(ritz, k + 1);
        const bool is_settled = k >= min_inexact_probes && smallest_ > settled_inexactly * before;
        if (hidden < (is_settled ? hardly_hidden : surely_hidden)) return close(Definiteness::yes);
    } else {
        if (smallest_ < min_stiffness_) return close(Definiteness::uncertain);
        if (k > 0 && smallest_ > settled * before) return close(Definiteness::yes);
    }
    if (alpha_.size() == max_probes_) close(Definiteness::uncertain);
}

Definiteness probe_definiteness(PrimoShell::Impl& shell, double min_stiffness, int max_inexact_probes) {
    DefinitenessProbe probe(shell, min_stiffness, max_inexact_probes);
    while (probe.is_open()) probe.advance(shell, shell.precondition(probe.residual(), Cycle::linear));
    return probe.found();
}

}  // namespace strake
