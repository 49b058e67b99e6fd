#include "optimize/nlp/program/partial_gradient.hpp"

#include "optimize/nlp/program/first_order.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <numeric>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Points next to x from which slopes are taken.
class Probes {
public:
    Probes(const NonlinearProgram& p, const VectorXd& x)
        : p_(p), x_(x), step_(p.differences->step), is_blocked_(static_cast<std::size_t>(x.size()), 0) {}

    void add(const VectorXd& direction) {
        const VectorXd up = step_ * direction;
        if (fits(up)) return deltas_.push_back(up);
        if (fits(-up)) return deltas_.push_back(-up);
        VectorXd cut = up;
        for (Eigen::Index j = 0; j < cut.size(); ++j)
            if (!fits_at(j, up[j])) cut[j] = 0, is_blocked_[static_cast<std::size_t>(j)] = 1;
        if (!cut.isZero(0)) deltas_.push_back(cut);
    }
    /// Adds one point for each variable that was cut out.
    void add_blocked() {
        for (Eigen::Index j = 0; j < x_.size(); ++j) {
            if (!is_blocked_[static_cast<std::size_t>(j)] || !(p_.lower[j] < p_.upper[j])) continue;
            const double above = p_.upper[j] - x_[j], below = x_[j] - p_.lower[j];
            VectorXd delta = VectorXd::Zero(x_.size());
            delta[j] = above >= below ? std::min(step_, above) : -std::min(step_, below);
            deltas_.push_back(delta);
        }
    }
    const std::vector<VectorXd>& deltas() const { return deltas_; }
    VectorXd point(std::size_t k) const { return (x_ + deltas_[k]).cwiseMax(p_.lower).cwiseMin(p_.upper); }
    bool turn(std::size_t k) {
        deltas_[k] *= -1;
        return fits(deltas_[k]);
    }

private:
    bool fits_at(Eigen::Index j, double delta) const {
        return x_[j] + delta >= p_.lower[j] && x_[j] + delta <= p_.upper[j];
    }
    bool fits(const VectorXd& delta) const {
        for (Eigen::Index j = 0; j < delta.size(); ++j)
            if (!fits_at(j, delta[j])) return false;
        return true;
    }

    const NonlinearProgram& p_;
    const VectorXd& x_;
    double step_;
    std::vector<char> is_blocked_;
    std::vector<VectorXd> deltas_;
};

}  // namespace

bool differentiate_along(const NonlinearProgram& program, const VectorXd& x, Evaluation& evaluation,
                         const GradientGuess& guess, const std::function<Evaluation(const VectorXd&)>& evaluate,
                         const std::function<void(const std::vector<VectorXd>&)>& expect) {
    Probes probes(program, x);
    for (Eigen::Index k = 0; k < guess.directions.cols(); ++k) probes.add(guess.directions.col(k));
    probes.add_blocked();
    const std::size_t count = probes.deltas().size();
    const VectorXd here = values_of(evaluation);
    const Eigen::Index rows = evaluation.constraints.size();
    MatrixXd values(static_cast<Eigen::Index>(count), 1 + rows);
    std::vector<std::size_t> wanted(count);
    std::iota(wanted.begin(), wanted.end(), 0);
    for (int side = 0; side < 2 && !wanted.empty(); ++side) {
        std::vector<VectorXd> points;
        for (const std::size_t k : wanted) {
            if (side == 1 && !probes.turn(k)) return false;
            points.push_back(probes.point(k));
        }
        if (expect) expect(points);
        std::vector<std::size_t> failed;
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const Evaluation s = evaluate(points[i]);
            if (s.failure.empty())
                values.row(static_cast<Eigen::Index>(wanted[i])) = (values_of(s) - here).transpose();
            else
                failed.push_back(wanted[i]);
        }
        wanted = failed;
    }
    if (!wanted.empty()) return false;
    MatrixXd D(x.size(), static_cast<Eigen::Index>(count)), known(x.size(), 1 + rows);
    for (std::size_t k = 0; k < count; ++k) D.col(static_cast<Eigen::Index>(k)) = probes.deltas()[k];
    known.col(0) = guess.gradient;
    known.rightCols(rows) = guess.jacobian.transpose();
    if (count > 0) {
        const Eigen::LLT<MatrixXd> metric(guess.metric);
        const MatrixXd A = metric.matrixU() * D / program.differences->step;
        const MatrixXd missing = (values - D.transpose() * known) / program.differences->step;
        const MatrixXd change = A.transpose().completeOrthogonalDecomposition().solve(missing);
        known += metric.matrixL() * change;
    }
    evaluation.gradient = known.col(0);
    const MatrixXd own = evaluation.jacobian;
    evaluation.jacobian = known.rightCols(rows).transpose();
    const std::vector<char>& by_differences = program.differences->rows;
    for (Eigen::Index i = 0; i < rows && own.rows() == rows; ++i)
        if (!by_differences.empty() && !by_differences[static_cast<std::size_t>(i)])
            evaluation.jacobian.row(i) = own.row(i);
    return true;
}

GradientError::GradientError(const MatrixXd& metric, const MatrixXd& at_start)
    : metric_(metric), squared_(VectorXd::Zero(metric.rows())) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(metric);
    const VectorXd root = eigen.eigenvalues().cwiseMax(1e-12 * eigen.eigenvalues().maxCoeff()).cwiseSqrt();
    modes_ = eigen.eigenvectors() * root.cwiseInverse().asDiagonal();
    duals_ = eigen.eigenvectors() * root.asDiagonal();
    if (at_start.cols() > 0) squared_ = (modes_.transpose() * at_start).rowwise().squaredNorm();
}

void GradientError::add_change(const VectorXd& change) { squared_ += (modes_.transpose() * change).cwiseAbs2(); }

std::vector<int> GradientError::largest(double share) const {
    std::vector<int> order(static_cast<std::size_t>(squared_.size()));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return squared_[a] > squared_[b]; });
    const double all = squared_.sum();
    double held = 0;
    std::size_t count = 0;
    while (count < order.size() && squared_[order[count]] > 0 && (share >= 1 || held < share * all))
        held += squared_[order[count++]];
    order.resize(count);
    return order;
}

MatrixXd GradientError::remaining() const { return duals_ * squared_.cwiseSqrt().asDiagonal(); }

std::optional<StartGradient> inherited_gradient(const Evaluation& parent, const MatrixXd& gradient_error,
                                                const MatrixXd& prolongation, const MatrixXd& metric) {
    const Eigen::Index n = prolongation.rows(), coarse = prolongation.cols();
    if (parent.gradient.size() != coarse || parent.jacobian.cols() != coarse || coarse > n) return {};
    const Eigen::LLT<MatrixXd> llt(metric);
    const MatrixXd MP = metric * prolongation;
    const MatrixXd W = (prolongation.transpose() * MP).llt().solve(MP.transpose()).transpose();
    if (!W.allFinite()) return {};  // the level lacks directions of its parent
    StartGradient start;
    start.gradient = W * parent.gradient;
    start.jacobian = parent.jacobian * W.transpose();
    if (gradient_error.rows() == coarse) start.gradient_error = W * gradient_error;
    const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(llt.matrixU() * prolongation).householderQ();
    start.unknown_directions = llt.matrixU().solve(Q.rightCols(n - coarse));
    return start;
}

}  // namespace strake
