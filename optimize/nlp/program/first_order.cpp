#include "optimize/nlp/program/first_order.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double nearly_active = 0.02;  ///< in the metric: steps of 1 are the largest reasonable ones
constexpr int bound_passes = 5;         ///< to find the active bounds
constexpr double at_bound_rel = 1e-9;   ///< of the range: rounding must not decide

/// L^-1 b with metric = L L^T.
class Whitening {
public:
    explicit Whitening(const MatrixXd& metric) : is_identity_(metric.size() == 0 || metric.isIdentity(0)) {
        if (!is_identity_) llt_.compute(metric);
    }
    VectorXd of(const VectorXd& b) const { return is_identity_ ? b : VectorXd(llt_.matrixL().solve(b)); }
    MatrixXd of_columns(const MatrixXd& b) const { return is_identity_ ? b : MatrixXd(llt_.matrixL().solve(b)); }

private:
    bool is_identity_;
    Eigen::LLT<MatrixXd> llt_;
};
MatrixXd whitened(const MatrixXd& metric, const MatrixXd& b) { return Whitening(metric).of_columns(b); }

constexpr double dependent = 1e-8;  ///< of a row's length: what is not done by the others is rounding

/// m that minimizes |g + normals m|, m >= 0 where `is_inequality`: an active-set method (Lawson & Hanson 1974, chapter
/// 23), which takes rows that depend on each other one by one and never has multipliers that only cancel.
class NonnegativeLeastSquares {
public:
    NonnegativeLeastSquares(const MatrixXd& normals, const VectorXd& g, const std::vector<char>& is_inequality)
        : normals_(normals), g_(g), is_inequality_(is_inequality), m_(VectorXd::Zero(normals.cols())) {}

    VectorXd operator()() {
        for (Eigen::Index i = 0; i < normals_.cols(); ++i)
            if (!is_inequality_[static_cast<std::size_t>(i)] && is_independent(i)) used_.push_back(i);
        if (!used_.empty()) m_ = solution();
        std::vector<char> is_refused(is_inequality_.size(), 0);
        for (Eigen::Index tried = 0; tried < 3 * normals_.cols() + 10; ++tried) {
            const Eigen::Index next = steepest(is_refused);
            if (next < 0) break;
            used_.push_back(next);
            descend();
            const bool has_entered = std::find(used_.begin(), used_.end(), next) != used_.end();
            if (has_entered)
                std::fill(is_refused.begin(), is_refused.end(), 0);
            else
                is_refused[static_cast<std::size_t>(next)] = 1;  // by rounding alone
        }
        return m_;
    }

private:
    VectorXd solution() const {
        VectorXd all = VectorXd::Zero(normals_.cols());
        all(used_) = MatrixXd(normals_(Eigen::all, used_)).colPivHouseholderQr().solve(-g_);
        return all;
    }
    bool is_independent(Eigen::Index row) const {
        const VectorXd n = normals_.col(row);
        if (used_.empty()) return n.norm() > 0;
        const MatrixXd others = normals_(Eigen::all, used_);
        return (n - others * others.colPivHouseholderQr().solve(n)).norm() > dependent * n.norm();
    }
    /// The inequality outside the set by which the length falls most; -1: none.
    Eigen::Index steepest(const std::vector<char>& is_refused) const {
        const VectorXd left = -g_ - normals_ * m_;
        Eigen::Index best = -1;
        double most = dependent * g_.norm();
        for (Eigen::Index i = 0; i < normals_.cols(); ++i) {
            const bool is_out = is_inequality_[static_cast<std::size_t>(i)] &&
                                !is_refused[static_cast<std::size_t>(i)] &&
                                std::find(used_.begin(), used_.end(), i) == used_.end();
            const double length = normals_.col(i).norm();
            if (!is_out || !(length > 0)) continue;
            const double falls = normals_.col(i).dot(left) / length;
            if (falls > most && is_independent(i)) most = falls, best = i;
        }
        return best;
    }
    /// To the least squares of the set; inequalities that would become negative on the way leave it.
    void descend() {
        while (!used_.empty()) {
            const VectorXd wanted = solution();
            double share = 1;
            Eigen::Index first = -1;
            for (const Eigen::Index i : used_) {
                if (!is_inequality_[static_cast<std::size_t>(i)] || wanted[i] > 0) continue;
                const double there = m_[i] > 0 ? m_[i] / (m_[i] - wanted[i]) : 0;
                if (first < 0 || there < share) share = there, first = i;
            }
            m_ += share * (wanted - m_);
            if (first < 0) break;
            m_[first] = 0;
            std::erase_if(used_, [&](Eigen::Index i) {
                const bool leaves = is_inequality_[static_cast<std::size_t>(i)] && !(m_[i] > 0);
                if (leaves) m_[i] = 0;
                return leaves;
            });
        }
    }

    const MatrixXd& normals_;
    const VectorXd& g_;
    const std::vector<char>& is_inequality_;
    VectorXd m_;
    std::vector<Eigen::Index> used_;
};

}  // namespace

MatrixXd metric_of(const NonlinearProgram& p) {
    return p.metric.size() > 0 ? p.metric : MatrixXd(MatrixXd::Identity(p.start.size(), p.start.size()));
}

VectorXd values_of(const Evaluation& s) {
    VectorXd all(1 + s.constraints.size());
    all << s.objective, s.constraints;
    return all;
}

VectorXd least_squares_multipliers(const MatrixXd& metric, const VectorXd& gradient, const MatrixXd& jacobian,
                                   int num_inequalities, const ActiveSet& set) {
    VectorXd result = VectorXd::Zero(jacobian.rows());
    std::vector<Eigen::Index> active = set.rows;
    if (active.empty() || set.variables.empty()) return result;
    const Whitening whitening(metric(set.variables, set.variables));
    const VectorXd g = whitening.of(gradient(set.variables));
    const MatrixXd normals = whitening.of_columns(jacobian(Eigen::all, set.variables).transpose());
    bool is_clear = false;
    for (int pass = 0; pass < 2 && !active.empty(); ++pass) {
        Eigen::ColPivHouseholderQR<MatrixXd> qr(MatrixXd(normals(Eigen::all, active)));
        qr.setThreshold(dependent);
        if (qr.rank() < static_cast<Eigen::Index>(active.size())) break;  // multipliers that only cancel say nothing
        const VectorXd found = qr.solve(-g);
        std::vector<Eigen::Index> kept;
        result.setZero();
        for (std::size_t i = 0; i < active.size(); ++i)
            if (active[i] >= num_inequalities || found[static_cast<Eigen::Index>(i)] > 0) {
                kept.push_back(active[i]);
                result[active[i]] = found[static_cast<Eigen::Index>(i)];
            }
        is_clear = kept.size() == active.size() || kept.empty();
        if (is_clear) break;
        active = kept;
    }
    if (is_clear) return result;
    std::vector<char> is_inequality;
    for (const Eigen::Index row : set.rows) is_inequality.push_back(row < num_inequalities);
    const MatrixXd of_set = normals(Eigen::all, set.rows);
    result.setZero();
    result(set.rows) = NonnegativeLeastSquares(of_set, g, is_inequality)();
    return result;
}

Multipliers all_multipliers(const MatrixXd& metric, const Evaluation& s, int num_inequalities, const ActiveSet& set) {
    const Eigen::Index limits = s.limits.values.size();
    if (limits == 0)
        return {least_squares_multipliers(metric, s.gradient, s.jacobian, num_inequalities, set), VectorXd()};
    const Eigen::Index first = num_inequalities, rows = s.constraints.size();
    MatrixXd all(rows + limits, s.gradient.size());
    all.topRows(first) = s.jacobian.topRows(first);
    all.middleRows(first, limits) = s.limits.slopes;
    all.bottomRows(rows - first) = s.jacobian.bottomRows(rows - first);
    ActiveSet active{{}, set.variables};
    for (const Eigen::Index row : set.rows) active.rows.push_back(row < first ? row : row + limits);
    const MatrixXd normals = whitened(metric, s.limits.slopes.transpose());
    for (Eigen::Index i = 0; i < limits; ++i)
        if (s.limits.values[i] >= -nearly_active * normals.col(i).norm()) active.rows.push_back(first + i);
    const VectorXd found =
        least_squares_multipliers(metric, s.gradient, all, num_inequalities + static_cast<int>(limits), active);
    Multipliers result{VectorXd(rows), found.segment(first, limits)};
    result.constraints << found.head(first), found.tail(rows - first);
    return result;
}

Multipliers all_multipliers(const NonlinearProgram& p, const VectorXd& x, const Evaluation& evaluation) {
    if (evaluation.constraints.size() + evaluation.limits.values.size() == 0) return {};
    const MatrixXd metric = metric_of(p), normals = whitened(metric, evaluation.jacobian.transpose());
    ActiveSet set;
    for (Eigen::Index i = 0; i < evaluation.constraints.size(); ++i)
        if (i >= p.num_inequalities || evaluation.constraints[i] >= -nearly_active * normals.col(i).norm())
            set.rows.push_back(i);
    Multipliers result;
    VectorXd slope = VectorXd::Zero(x.size());
    for (int pass = 0; pass < bound_passes; ++pass) {
        std::vector<Eigen::Index> moving;
        for (Eigen::Index j = 0; j < x.size(); ++j)
            if (p.lower[j] < p.upper[j] && !leaves_bounds(p, x, j, -slope[j])) moving.push_back(j);
        if (pass > 0 && moving == set.variables) break;
        set.variables = moving;
        result = all_multipliers(metric, evaluation, p.num_inequalities, set);
        slope = evaluation.gradient + evaluation.jacobian.transpose() * result.constraints;
        if (result.limits.size() > 0) slope += evaluation.limits.slopes.transpose() * result.limits;
    }
    return result;
}

VectorXd multipliers(const NonlinearProgram& p, const VectorXd& x, const Evaluation& evaluation) {
    return all_multipliers(p, x, evaluation).constraints;
}

VectorXd lagrangian_gradient(const NonlinearProgram& p, const VectorXd& x, const Evaluation& evaluation) {
    const Multipliers found = all_multipliers(p, x, evaluation);
    VectorXd slope = evaluation.gradient;
    if (found.constraints.size() > 0) slope += evaluation.jacobian.transpose() * found.constraints;
    if (found.limits.size() > 0) slope += evaluation.limits.slopes.transpose() * found.limits;
    return slope;
}

bool leaves_bounds(const NonlinearProgram& p, const VectorXd& x, Eigen::Index j, double direction) {
    const double range = p.upper[j] - p.lower[j], hair = std::isfinite(range) ? at_bound_rel * range : 0;
    return (x[j] <= p.lower[j] + hair && direction < 0) || (x[j] >= p.upper[j] - hair && direction > 0);
}

VectorXd descent_direction(const NonlinearProgram& p, const VectorXd& x, const Evaluation& evaluation) {
    const VectorXd lagrangian = lagrangian_gradient(p, x, evaluation);
    VectorXd direction = p.metric.size() == 0 ? -lagrangian : VectorXd(-p.metric.llt().solve(lagrangian));
    for (Eigen::Index j = 0; j < direction.size(); ++j)
        if (leaves_bounds(p, x, j, direction[j])) direction[j] = 0;
    return direction;
}

double metric_norm(const NonlinearProgram& p, const VectorXd& d) {
    return p.metric.size() == 0 ? d.norm() : std::sqrt(std::max(0.0, d.dot(p.metric * d)));
}

double dual_norm(const NonlinearProgram& p, const VectorXd& g) { return whitened(p.metric, g).norm(); }

double total_violation(const NonlinearProgram& p, const VectorXd& c) {
    double sum = 0;
    for (Eigen::Index i = 0; i < c.size(); ++i) sum += i < p.num_inequalities ? std::max(0.0, c[i]) : std::abs(c[i]);
    return sum;
}

double largest_violation(const NonlinearProgram& p, const VectorXd& c) {
    double worst = 0;
    for (Eigen::Index i = 0; i < c.size(); ++i) worst = std::max(worst, i < p.num_inequalities ? c[i] : std::abs(c[i]));
    return worst;
}

}  // namespace strake
