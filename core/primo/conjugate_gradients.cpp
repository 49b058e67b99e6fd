#include "core/primo/conjugate_gradients.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/error.hpp"
#include "core/primo/linear/vectors.hpp"

namespace strake {
namespace {

constexpr double alike = 1e-6;        // share of a Gram matrix's largest eigenvalue that counts as zero
constexpr int few_iterations = 6;     // after which the rate is meaningful
constexpr int usual_iterations = 3;   // iterations on the matrix's own factor
constexpr int max_iterations = 120;   // of a solve to full accuracy
constexpr double round_off = 1e-12;   // of the right-hand side's norm: less is no residual
constexpr double tolerable = 1e-4;    // reduction below which a solution that can be no better is still used
constexpr int factor_limit = 300000;  // prisms whose factor takes 2 GB

/// z.r of the previous residual, zero for a linear preconditioner; otherwise it keeps the directions conjugate (Notay
/// 2000).
template <class Before, class Z>
double since(const Before& before, const Z& z) {
    return before.size() > 0 ? dot(before, z) : 0;
}

/// Applies the preconditioner to r, and to the next residual of an open probe.
Eigen::VectorXd preconditioned(PrimoShell::Impl& shell, const Eigen::VectorXd& r, DefinitenessProbe* beside) {
    if (!beside || !beside->is_open()) return shell.precondition(r);
    Eigen::MatrixXd both(r.size(), 2);
    both << r, beside->residual();
    both = shell.precondition(both);
    beside->advance(shell, both.col(1));
    return both.col(0);
}

/// The X of least energy error in the span of `similar`, and R = B - H X. @return per column the squared energy norm of
/// X; later steps add to it
Eigen::VectorXd start_among(const PrimoShell::Impl& shell, const Eigen::MatrixXd& B, const Eigen::MatrixXd& similar,
                            Eigen::MatrixXd& X, Eigen::MatrixXd& R) {
    const Eigen::MatrixXd HW = shell.products(similar);
    Eigen::MatrixXd G = similar.transpose() * HW;
    const Eigen::VectorXd size = G.diagonal().cwiseMax(0).cwiseSqrt();
    const Eigen::VectorXd scale = (size.array() > 0).select(size.cwiseInverse(), 0);
    G = (scale.asDiagonal() * G * scale.asDiagonal()).eval();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (G + G.transpose()));
    const Eigen::VectorXd& value = eigen.eigenvalues();
    // Nearly equal columns would only amplify round-off.
    const Eigen::VectorXd inverse = (value.array() > alike * value.maxCoeff()).select(value.cwiseInverse(), 0);
    const Eigen::MatrixXd WB = scale.asDiagonal() * (similar.transpose() * B);
    const Eigen::MatrixXd C =
        scale.asDiagonal() * (eigen.eigenvectors() * inverse.asDiagonal() * (eigen.eigenvectors().transpose() * WB));
    X.noalias() = similar * C;
    R.noalias() -= HW * C;
    return X.cwiseProduct(B).colwise().sum().transpose().cwiseMax(0);
}

using Columns = std::vector<Eigen::Index>;

/// Conjugate gradients on several right-hand sides at once.
struct ColumnIteration {
    Eigen::MatrixXd X, R, P;
    Eigen::MatrixXd before;  ///< residuals of the iteration before, for an inexact preconditioner; else empty
    Eigen::VectorXd rz, first, rate;
    Eigen::VectorXd size, reduction;  ///< of the right-hand sides; of their residuals, as measured last

    ColumnIteration(const Eigen::MatrixXd& B, bool is_inexact)
        : X(Eigen::MatrixXd::Zero(B.rows(), B.cols())),
          R(B),
          P(B.rows(), B.cols()),
          rz(Eigen::VectorXd::Zero(B.cols())),
          first(rz),
          rate(rz),
          size(B.colwise().norm().transpose()),
          reduction(Eigen::VectorXd::Ones(B.cols())) {
        if (is_inexact) before = Eigen::MatrixXd::Zero(B.rows(), B.cols());
    }

    /// Directions of the open columns from their preconditioned residuals Z. @param lost gets those without one, though
    /// more than round-off is left of them @return those that have one
    Columns find_directions(const Eigen::MatrixXd& Z, const Columns& open, bool is_first, double tolerance,
                            Columns& lost) {
        Columns ahead;
        for (std::size_t q = 0; q < open.size(); ++q) {
            const Eigen::Index c = open[q];
            const auto z = Z.col(static_cast<Eigen::Index>(q));
            const double next = dot(R.col(c), z);
            if (!(next > 0) || !std::isfinite(next)) {
                const double left = std::sqrt(std::abs(next) / first[c]);
                if (!(left <= tolerance) && !(R.col(c).norm() <= round_off * size[c])) lost.push_back(c);
                continue;
            }
            rate[c] = is_first ? 1 : std::min(1.0, std::sqrt(next / rz[c]));
            if (is_first)
                first[c] += next, P.col(c) = z;
            else
                scale_and_add(P.col(c), (next - (before.size() > 0 ? dot(before.col(c), z) : 0)) / rz[c], z);
            rz[c] = next;
            ahead.push_back(c);
        }
        return ahead;
    }

    /// A step along the directions P. @param HP their products with H @return columns above the tolerance
    Columns step(const Eigen::MatrixXd& HP, const Columns& ahead, double tolerance) {
        Columns left;
        for (std::size_t q = 0; q < ahead.size(); ++q) {
            const Eigen::Index c = ahead[q];
            const auto Hp = HP.col(static_cast<Eigen::Index>(q));
            const double curvature = dot(P.col(c), Hp);
            if (!(curvature > 0)) throw SolverError("shell: the exact Hessian is not positive definite at these poses");
            const double length = dot(P.col(c), R.col(c)) / curvature;
            if (before.size() > 0) before.col(c) = R.col(c);
            add_multiple(X.col(c), length, P.col(c));
            add_multiple(R.col(c), -length, Hp);
            reduction[c] = rate[c] * std::sqrt(rz[c] / first[c]);
            if (!(reduction[c] <= tolerance)) left.push_back(c);
        }
        return left;
    }

    /// Iterates on the open columns. @return those that are not solved to the tolerance
    Columns run(PrimoShell::Impl& shell, Columns open, double tolerance) {
        const double price = 1 + static_cast<double>(X.cols()) / 8;  // of a block, in single columns
        Columns lost;
        for (int k = 0; !open.empty() && k < max_iterations; ++k) {
            if (k >= usual_iterations) shell.spent += price;
            const Columns ahead =
                find_directions(shell.precondition(R(Eigen::all, open)), open, k == 0, tolerance, lost);
            open = step(shell.products(P(Eigen::all, ahead)), ahead, tolerance);
        }
        open.insert(open.end(), lost.begin(), lost.end());
        return open;
    }

    /// Measures the residuals of these columns anew; what they have reached stays.
    void begin_again(const PrimoShell::Impl& shell, const Eigen::MatrixXd& B, const Columns& open, bool is_inexact) {
        for (const Eigen::Index c : open)
            if (!X.col(c).allFinite()) X.col(c).setZero();
        const Eigen::MatrixXd HX = shell.products(X(Eigen::all, open));
        for (std::size_t q = 0; q < open.size(); ++q) {
            const Eigen::Index c = open[q];
            R.col(c) = B.col(c) - HX.col(static_cast<Eigen::Index>(q));
            first[c] =
                std::max(0.0, dot(X.col(c), HX.col(static_cast<Eigen::Index>(q))));  // find_directions adds to it
            reduction[c] = 1;
        }
        before = is_inexact ? Eigen::MatrixXd::Zero(B.rows(), B.cols()) : Eigen::MatrixXd();
    }
};

/// A preconditioner of the assembled matrix itself; a factor, where it is not too large, since cycles were not enough.
void renew_preconditioner(PrimoShell::Impl& shell) {
    if (!shell.kept.is_exact() && shell.rest.num_free() < factor_limit) {
        shell.kept.use(LinearSolver::direct, 0);
        shell.kept.analyze(shell.H);
    }
    if (!shell.factorize()) throw SolverError("shell: the exact Hessian is not positive definite at these poses");
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
        // Measuring the residual would take a substitution: assume the last rate.
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
    ColumnIteration all(B, !shell.kept.is_exact());
    if (similar.cols() > 0) all.first = start_among(shell, B, similar, all.X, all.R);
    Columns open;
    for (Eigen::Index c = 0; c < B.cols(); ++c) {
        if (!B.col(c).allFinite()) throw SolverError(text("shell: right-hand side ", c, " is not finite"));
        if (B.col(c).squaredNorm() > 0) open.push_back(c);
    }
    open = all.run(shell, open, tolerance);
    if (open.empty()) return all.X;
    renew_preconditioner(shell);
    all.begin_again(shell, B, open, !shell.kept.is_exact());
    open = all.run(shell, open, tolerance);
    for (const Eigen::Index c : open)
        if (!(all.reduction[c] <= tolerable))
            throw SolverError(text("shell: ", open.size(), " of ", B.cols(), " linear systems are not solved after ",
                                   2 * max_iterations, " iterations (residual ", all.reduction[c], ", wanted ",
                                   tolerance, "); thicker prisms help"));
    return all.X;
}

}  // namespace strake
