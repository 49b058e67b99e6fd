#include "core/primo/conjugate_gradients.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/error.hpp"
#include "core/primo/vectors.hpp"

namespace strake {
namespace {

constexpr double alike = 1e-6;        // share of the largest eigenvalue of a Gram matrix that counts as none
constexpr int few_iterations = 6;     // after which the rate means something
constexpr int usual = 3;              // iterations on the matrix's own factor
constexpr int most_iterations = 120;  // of a solve to full accuracy

/// z.r of the residual before, which vanishes where the preconditioner is linear; where not, it keeps the directions
/// conjugate (Notay 2000).
template <class Before, class Z>
double since(const Before& before, const Z& z) {
    return before.size() > 0 ? dot(before, z) : 0;
}

/// What is kept applied to r, and to the next residual of a probe beside it while it is open.
Eigen::VectorXd preconditioned(PrimoShell::Impl& shell, const Eigen::VectorXd& r, DefinitenessProbe* beside) {
    if (!beside || !beside->is_open()) return shell.precondition(r);
    Eigen::MatrixXd both(r.size(), 2);
    both << r, beside->residual();
    both = shell.precondition(both);
    beside->advance(shell, both.col(1));
    return both.col(0);
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

CgResult conjugate_gradients(PrimoShell::Impl& shell, Eigen::VectorXd b, const CgOptions& given) {
    CgOptions options = given;
    CgResult result;
    result.x = Eigen::VectorXd::Zero(b.size());
    result.reduction = b.squaredNorm() > 0 ? 1 : 0;
    double rz = 0, first = 0;
    Eigen::VectorXd r = std::move(b), p, before;
    bool is_enough = false;
    while (!is_enough && result.reduction > options.tolerance && result.iterations < options.max_iterations) {
        const Eigen::VectorXd z = preconditioned(shell, r, options.beside);
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
        const Eigen::VectorXd Hp = shell.product(p);
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
        is_enough = options.is_enough && options.is_enough(result.x, result.reduction);
        if (result.iterations >= few_iterations) {
            const double mean_rate = std::pow(result.reduction, 1.0 / result.iterations);
            if (std::pow(mean_rate, options.max_iterations) > options.tolerance) break;
        }
    }
    result.is_reached = is_enough || result.reduction <= options.tolerance;
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

}  // namespace strake
