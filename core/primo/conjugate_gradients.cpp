#include "core/primo/conjugate_gradients.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/error.hpp"
#include "core/primo/vectors.hpp"

namespace strake {
namespace {

constexpr int most_probes = 6;
constexpr int least_inexact_probes = 10;  // beside a preconditioner whose own spectrum has to be explored first
constexpr double settled = 0.8;           // a least Ritz value that falls no further than this is the eigenvalue
constexpr double settled_inexactly = 0.99;
constexpr double alike = 1e-6;        // share of the largest eigenvalue of a Gram matrix that counts as none
constexpr int few_iterations = 6;     // after which the rate means something
constexpr int usual = 3;              // iterations on the matrix's own factor
constexpr int most_iterations = 120;  // of a solve to full accuracy

/// Numbers in [-1, 1) that are the same in every run, whatever was drawn before.
double noise(std::uint64_t n) {
    n = (n + 0x9e3779b97f4a7c15ull) * 0xbf58476d1ce4e5b9ull;
    n = (n ^ (n >> 27)) * 0x94d049bb133111ebull;
    return static_cast<double>((n ^ (n >> 31)) >> 11) * 0x1p-52 - 1;
}

/// Least eigenvalue of Lanczos' matrix, from the coefficients of conjugate gradients.
double least_ritz(const std::vector<double>& alpha, const std::vector<double>& beta) {
    const auto n = static_cast<Eigen::Index>(alpha.size());
    Eigen::VectorXd diagonal(n), beside(n - 1);
    for (Eigen::Index k = 0; k < n; ++k) {
        diagonal[k] = 1 / alpha[k] + (k > 0 ? beta[k - 1] / alpha[k - 1] : 0);
        if (k + 1 < n) beside[k] = std::sqrt(beta[k]) / alpha[k];
    }
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
    eigen.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
    return eigen.eigenvalues()[0];
}

/// z.r of the residual before, which vanishes where the preconditioner is linear; where not, it keeps the directions
/// conjugate (Notay 2000).
template <class Before, class Z>
double since(const Before& before, const Z& z) {
    return before.size() > 0 ? dot(before, z) : 0;
}

/// The X of least error in energy that is made of the columns of `similar`, and R = B - H X.
/// @return per column the square of X in energy: what is left adds to it, whatever it is.
Eigen::VectorXd start_among(const PrimoShell::Impl& shell, const Eigen::MatrixXd& B, const Eigen::MatrixXd& similar,
                            Eigen::MatrixXd& X, Eigen::MatrixXd& R) {
    const Eigen::MatrixXd HW = shell.products(similar);
    Eigen::MatrixXd G = similar.transpose() * HW;
    const Eigen::VectorXd size = G.diagonal().cwiseMax(0).cwiseSqrt();
    const Eigen::VectorXd scale = (size.array() > 0).select(size.cwiseInverse(), 0);
    G = (scale.asDiagonal() * G * scale.asDiagonal()).eval();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (G + G.transpose()));
    const Eigen::VectorXd& value = eigen.eigenvalues();
    // Columns that are nearly alike would only add up round-off.
    const Eigen::VectorXd inverse = (value.array() > alike * value.maxCoeff()).select(value.cwiseInverse(), 0);
    const Eigen::MatrixXd WB = scale.asDiagonal() * (similar.transpose() * B);
    const Eigen::MatrixXd C =
        scale.asDiagonal() * (eigen.eigenvectors() * inverse.asDiagonal() * (eigen.eigenvectors().transpose() * WB));
    X.noalias() = similar * C;
    R.noalias() -= HW * C;
    return X.cwiseProduct(B).colwise().sum().transpose().cwiseMax(0);
}

}  // namespace

CgResult conjugate_gradients(PrimoShell::Impl& shell, const Eigen::VectorXd& b, const CgOptions& given) {
    CgOptions options = given;
    CgResult result;
    result.x = Eigen::VectorXd::Zero(b.size());
    result.reduction = b.squaredNorm() > 0 ? 1 : 0;
    double rz = 0, first = 0;
    Eigen::VectorXd r = b, z, p, Hp, before;
    while (result.reduction > options.tolerance && result.iterations < options.max_iterations) {
        z = shell.precondition_column(r);
        const double next = dot(r, z);
        if (!(next > 0) || !std::isfinite(next)) break;  // nothing is left but round-off
        if (result.iterations++ == 0) {
            first = next;
            result.size = std::sqrt(next);
            if (options.adapt) options.adapt(result.size, options);
            result.rate = options.expected_rate;
            p = z;
        } else {
            result.rate = std::min(1.0, std::sqrt(next / rz));
            scale_and_add(p, (next - since(before, z)) / rz, z);
        }
        rz = next;
        Hp = shell.product(p);
        const double curvature = dot(p, Hp);
        if (!(curvature > 0)) {
            result.is_positive = false;
            return result;
        }
        const double length = dot(p, r) / curvature;
        if (!shell.kept.is_exact()) before = r;
        add_multiple(result.x, length, p);
        add_multiple(r, -length, Hp);
        // Measuring what this has left would take a substitution: it reduces as the last one did.
        result.reduction = result.rate * std::sqrt(rz / first);
        if (result.iterations >= few_iterations) {
            const double mean_rate = std::pow(result.reduction, 1.0 / result.iterations);
            if (std::pow(mean_rate, options.max_iterations) > options.tolerance) break;
        }
    }
    result.is_reached = result.reduction <= options.tolerance;
    return result;
}

Eigen::MatrixXd solve_columns(PrimoShell::Impl& shell, const Eigen::MatrixXd& B, double tolerance,
                              const Eigen::MatrixXd& similar) {
    Eigen::MatrixXd X = Eigen::MatrixXd::Zero(B.rows(), B.cols()), R = B, P(B.rows(), B.cols()), before;
    if (!shell.kept.is_exact()) before = Eigen::MatrixXd::Zero(B.rows(), B.cols());
    Eigen::VectorXd rz = Eigen::VectorXd::Zero(B.cols()), first = rz, rate = rz;
    if (similar.cols() > 0) first = start_among(shell, B, similar, X, R);
    const double price = 1 + static_cast<double>(B.cols()) / 8;  // of a block, in single columns
    std::vector<Eigen::Index> open;
    for (Eigen::Index c = 0; c < B.cols(); ++c)
        if (B.col(c).squaredNorm() > 0) open.push_back(c);
    for (int k = 0; !open.empty() && k < most_iterations; ++k) {
        if (k >= usual) shell.spent += price;
        const Eigen::MatrixXd Z = shell.precondition(R(Eigen::all, open));
        std::vector<Eigen::Index> ahead, left;
        for (std::size_t q = 0; q < open.size(); ++q) {
            const Eigen::Index c = open[q];
            const auto z = Z.col(static_cast<Eigen::Index>(q));
            const double next = dot(R.col(c), z);
            if (!(next > 0) || !std::isfinite(next)) continue;
            rate[c] = k == 0 ? 1 : std::min(1.0, std::sqrt(next / rz[c]));
            if (k == 0)
                first[c] += next, P.col(c) = z;
            else
                scale_and_add(P.col(c), (next - (before.size() > 0 ? dot(before.col(c), z) : 0)) / rz[c], z);
            rz[c] = next;
            ahead.push_back(c);
        }
        const Eigen::MatrixXd HP = shell.products(P(Eigen::all, ahead));
        for (std::size_t q = 0; q < ahead.size(); ++q) {
            const Eigen::Index c = ahead[q];
            const auto Hp = HP.col(static_cast<Eigen::Index>(q));
            const double curvature = dot(P.col(c), Hp);
            if (!(curvature > 0)) throw SolverError("shell: the exact Hessian is not positive definite at these poses");
            const double length = dot(P.col(c), R.col(c)) / curvature;
            if (before.size() > 0) before.col(c) = R.col(c);
            add_multiple(X.col(c), length, P.col(c));
            add_multiple(R.col(c), -length, Hp);
            if (rate[c] * std::sqrt(rz[c] / first[c]) > tolerance) left.push_back(c);
        }
        open = left;
    }
    return X;
}

Definiteness probe_definiteness(PrimoShell::Impl& shell, double least_stiffness, int most_inexact_probes) {
    const RestState& rest = shell.rest;
    Eigen::VectorXd r(6L * rest.num_free()), z, p, Hp;
    for (Eigen::Index i = 0; i < r.size(); ++i) {
        const double arm = i % 6 < 3 ? rest.prism_height[rest.free_prisms[i / 6]] : 1;
        r[i] = arm * noise(static_cast<std::uint64_t>(i));
    }
    std::vector<double> alpha, beta;
    double rz = 0, least = std::numeric_limits<double>::infinity();
    const bool is_exact = shell.kept.is_exact();
    for (int k = 0; k < (is_exact ? most_probes : most_inexact_probes); ++k) {
        z = shell.precondition_column(r);
        const double next = dot(r, z);
        if (!(next > 0) || !std::isfinite(next)) return Definiteness::doubtful;
        if (k > 0) beta.push_back(next / rz);
        if (k > 0)
            scale_and_add(p, beta.back(), z);
        else
            p = z;
        rz = next;
        Hp = shell.product(p);
        const double curvature = dot(p, Hp);
        if (!(curvature > 0)) return Definiteness::no;
        alpha.push_back(rz / curvature);
        add_multiple(r, -alpha.back(), Hp);
        const double before = std::exchange(least, least_ritz(alpha, beta));
        if (!is_exact) {  // softer than its preconditioner everywhere: only the sign and a standstill mean something
            if (!(least > 0)) return Definiteness::doubtful;
            if (k >= least_inexact_probes && least > settled_inexactly * before) return Definiteness::yes;
            continue;
        }
        if (least < least_stiffness) return Definiteness::doubtful;
        if (k > 0 && least > settled * before) return Definiteness::yes;
    }
    return Definiteness::doubtful;
}

}  // namespace strake
