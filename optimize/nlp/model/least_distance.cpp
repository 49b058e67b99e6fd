#include "optimize/nlp/model/least_distance.hpp"

#include <Eigen/Householder>
#include <Eigen/Jacobi>
#include <limits>
#include <optional>
#include <vector>

namespace strake {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rounding = 1e-11;
constexpr double dependent = 1e-10;  ///< of the length of a row: what is left of it across the active ones is rounding
constexpr int passes = 10;           ///< over all rows: more would be a circle by rounding

/// A row in the sense a.w >= c.
struct Row {
    VectorXd a;
    double c;
};

/// The state of the method: w minimizes under the active rows alone, with multipliers that are not negative.
class DualMethod {
public:
    explicit DualMethod(const LeastDistance& problem)
        : p_(problem), w_(-problem.q), J_(MatrixXd::Identity(w_.size(), w_.size())), R_(w_.size(), w_.size()) {}

    VectorXd run() {
        const Index rows = p_.inequality_limits.size() + p_.equality_limits.size();
        steps_left_ = passes * static_cast<int>(rows + w_.size());
        for (Index i = 0; i < p_.equality_limits.size(); ++i)
            if (!meet_equality(i)) return {};
        while (const std::optional<Index> worst = worst_violated())
            if (!meet(inequality(*worst), *worst)) return {};
        return w_;
    }

private:
    Index active() const { return static_cast<Index>(active_.size()); }
    Row inequality(Index i) const { return {-p_.inequality_rows.row(i).transpose(), -p_.inequality_limits[i]}; }
    double tolerance(double limit) const {
        return rounding * std::max({1.0, std::abs(limit), w_.lpNorm<Eigen::Infinity>()});
    }

    bool meet_equality(Index i) {
        const double sense = p_.equality_rows.row(i).dot(w_) > p_.equality_limits[i] ? -1 : 1;
        const Row row{sense * p_.equality_rows.row(i).transpose(), sense * p_.equality_limits[i]};
        const VectorXd across = J_.rightCols(w_.size() - active()).transpose() * row.a;
        if (across.norm() <= dependent * row.a.norm())  // the equalities before it decide
            return std::abs(row.a.dot(w_) - row.c) <= tolerance(row.c);
        return meet(row, equality);
    }

    std::optional<Index> worst_violated() const {
        if (p_.inequality_limits.size() == 0) return {};
        VectorXd excess = p_.inequality_rows * w_ - p_.inequality_limits;
        for (Index i = 0; i < excess.size(); ++i) excess[i] -= tolerance(p_.inequality_limits[i]);
        for (const Index i : active_)
            if (i != equality) excess[i] = 0;
        Index worst = 0;
        if (!(excess.maxCoeff(&worst) > 0)) return {};
        return worst;
    }

    /// Steps until the row is met and active; other rows leave the set where their multiplier would become negative.
    bool meet(const Row& row, Index number) {
        double multiplier = 0;
        while (steps_left_-- > 0) {
            const Index q = active(), n = w_.size();
            const VectorXd d = J_.transpose() * row.a;
            const VectorXd along = J_.rightCols(n - q) * d.tail(n - q);
            const VectorXd r = R_.topLeftCorner(q, q).triangularView<Eigen::Upper>().solve(d.head(q));
            constexpr double none = std::numeric_limits<double>::infinity();
            double partial = none;
            Index leaving = -1;
            for (Index k = 0; k < q; ++k)
                if (active_[static_cast<std::size_t>(k)] != equality && r[k] > 0 && multiplier_[k] / r[k] < partial)
                    partial = multiplier_[k] / r[k], leaving = k;
            const bool is_free = d.tail(n - q).norm() > dependent * row.a.norm();
            const double full = is_free ? std::max(0.0, row.c - row.a.dot(w_)) / d.tail(n - q).squaredNorm() : none;
            const double step = std::min(partial, full);
            if (!(step < none)) return false;  // no point meets the row and the active ones
            if (is_free) w_ += step * along;
            multiplier_.head(q) -= step * r;
            multiplier += step;
            if (full <= partial) {
                add(d, multiplier, number);
                return true;
            }
            drop(leaving);
        }
        return false;
    }

    void add(const VectorXd& d, double multiplier, Index number) {
        const Index q = active(), n = w_.size();
        VectorXd essential(n - q - 1);
        double factor = 0, length = 0;
        d.tail(n - q).makeHouseholder(essential, factor, length);
        VectorXd workspace(n);
        J_.rightCols(n - q).applyHouseholderOnTheRight(essential, factor, workspace.data());
        R_.col(q).head(q) = d.head(q);
        R_(q, q) = length;
        active_.push_back(number);
        multiplier_.conservativeResize(q + 1);
        multiplier_[q] = multiplier;
    }

    void drop(Index k) {
        const Index last = active() - 1;
        for (Index c = k; c < last; ++c) {
            R_.col(c).head(c + 2) = R_.col(c + 1).head(c + 2);
            multiplier_[c] = multiplier_[c + 1];
        }
        for (Index c = k; c < last; ++c) {
            Eigen::JacobiRotation<double> turn;
            turn.makeGivens(R_(c, c), R_(c + 1, c));
            R_.topLeftCorner(last + 1, last).rightCols(last - c).applyOnTheLeft(c, c + 1, turn.adjoint());
            J_.applyOnTheRight(c, c + 1, turn);
        }
        active_.erase(active_.begin() + k);
        multiplier_.conservativeResize(last);
    }

    static constexpr Index equality = -1;  ///< in place of the number of an inequality

    const LeastDistance& p_;
    VectorXd w_;
    MatrixXd J_;  ///< orthogonal; the q active rows are a_k = J_.leftCols(q) R_.col(k)
    MatrixXd R_;  ///< upper triangular, of the size of the active set
    std::vector<Index> active_;
    VectorXd multiplier_;  ///< of the active rows
    int steps_left_ = 0;
};

}  // namespace

VectorXd nearest_point(const LeastDistance& problem) {
    VectorXd w = DualMethod(problem).run();
    return w.allFinite() ? w : VectorXd();
}

}  // namespace strake
