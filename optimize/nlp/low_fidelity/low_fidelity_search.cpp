#include "optimize/nlp/low_fidelity/low_fidelity_search.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double first_radius = 1;   ///< in the metric: the largest reasonable step
constexpr double min_radius = 1e-3;  ///< below, nothing is left that a cheap program could say
constexpr double max_radius = 2;     ///< a little more than reasonable, because the metric is an estimate
constexpr double growth = 2;         ///< after a good step to the border
constexpr double failure_cut = 0.5;  ///< after a step without a value, which says nothing of the cheap program
constexpr int max_failures = 5;      ///< in a row; also rounds of designs next to the present one without any value
constexpr double min_cut = 0.1, max_cut = 0.5;  ///< towards the minimum of the parabola through the values
constexpr double acceptable = 1e-4;             ///< actual over predicted decrease: less is none
constexpr double poor = 0.25, good = 0.7;
constexpr double first_trust = 0.5;      ///< share of a prediction that is expected to come
constexpr double memory_of_trust = 0.5;  ///< the rest is the last step's
constexpr double min_trust = 0.05;
constexpr int max_misled = 2;      ///< bad steps in a row, and in all more than good ones
constexpr double min_share = 0.4;  ///< of the slope that the cheap program tells: with less, and a bad step, it is left
constexpr double probe_length = 0.05;  ///< of a design next to the present one, in the metric
constexpr double penalty_factor = 2;   ///< times the largest multiplier
constexpr double penalty_share = 0.7;  ///< of the violation's decrease that may pay for a rising objective
constexpr double nearly_active = 1e-3;

std::string rounded(double value) {
    const double digits = value == 0 ? 1 : std::pow(10, 2 - std::floor(std::log10(std::abs(value))));
    return text(std::round(value * digits) / digits);
}

/// An orthonormal basis of what is orthogonal to all columns.
MatrixXd across(const MatrixXd& columns) {
    const Index n = columns.rows();
    MatrixXd all = MatrixXd::Identity(n, n);
    if (columns.cols() == 0) return all;
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
    all.applyOnTheLeft(qr.householderQ());
    return all.rightCols(n - qr.rank());
}

class LowFidelitySearch {
public:
    explicit LowFidelitySearch(Guard& guard)
        : guard_(guard),
          program_(guard.program),
          low_(*guard.program.low_fidelity),
          metric_(metric_of(guard.program)),
          model_(metric_, low_.values, first_scale()),
          has_own_gradients_(!learns_from_values(guard.program)) {}

    LowFidelityEnd run() {
        if (begin())
            while (step()) {
            }
        return finish();
    }

private:
    VectorXd first_scale() const {
        VectorXd scale = low_.first_scale ? low_.first_scale() : VectorXd();
        if (scale.size() == 0) scale = VectorXd::Ones(static_cast<Index>(low_.values.size()));
        return scale;
    }

    bool begin() {
        if (!move_to(guard_.best_x, guard_.best)) return leave("it has no value at the start");
        model_.fit(now_.x, now_.low_gradients);
        for (std::size_t i = 0; i < low_.values.size(); ++i)
            if (model_.is_blind(static_cast<Index>(i)) && !has_own_gradients_)
                return leave(i == 0 ? "it does not change with any variable"
                                    : text("nothing is known of constraint ", i - 1, " beside its value"));
        return true;
    }

    /// The cheap program at a point of the expensive one. False: it has no value there.
    bool measure(const VectorXd& x, bool gradient, Evaluation& cheap) {
        NonlinearProgram p = *low_.program;
        p.start = x;
        p.within = {};  // just there
        MinimizeOptions options;
        options.exceptions_are_failures = guard_.options.exceptions_are_failures;
        options.max_evaluations = 2 + 2 * static_cast<int>(x.size());
        Guard one(p, options);
        const bool has_value = one.try_at(x, gradient, cheap);
        if (one.exception) std::rethrow_exception(one.exception);
        return has_value && one.best_x == x;
    }

    bool move_to(const VectorXd& x, const Evaluation& at) {
        Evaluation cheap;
        if (!measure(x, true, cheap)) return false;
        now_.x = x;
        now_.values = values_of(at);
        now_.low = values_of(cheap);
        now_.low_gradients.resize(x.size(), now_.low.size());
        now_.low_gradients.col(0) = cheap.gradient;
        now_.low_gradients.rightCols(now_.low.size() - 1) = cheap.jacobian.transpose();
        now_.limits = cheap.limits;
        at_ = at;
        model_.add_point(x, now_.values, now_.low);
        if (has_own_gradients_ && at.gradient.size() == x.size()) {
            const Index n = x.size();
            MatrixXd all(n, now_.values.size());
            all.col(0) = at.gradient;
            all.rightCols(at.constraints.size()) = at.jacobian.transpose();
            const MatrixXd directions = model_.root().triangularView<Eigen::Upper>().solve(MatrixXd::Identity(n, n));
            model_.add_slopes(x, directions, directions.transpose() * all, directions.transpose() * now_.low_gradients);
        }
        return true;
    }

    /// One evaluation, or several next to the present design. False: the search is over.
    bool step() {
        model_.fit(now_.x, now_.low_gradients);
        if (bad_ > 0 && low_.values[0] == LowFidelityValue::approximate && model_.share(0) < min_share)
            return leave("it says too little of how the objective changes");
        raise_penalty();
        const NonlinearProgram corrected = corrected_program(low_, model_, now_, metric_, radius_, border_cut());
        const CorrectedOptimum next =
            minimize_corrected(corrected, low_.program->num_inequalities, guard_.options, hessian_, radius_);
        if (!next.is_found) return leave("its correction has no value here");
        hessian_ = next.hessian;
        const double predicted = decrease_to(next.values);
        const double tolerance =
            std::max(guard_.decrease_tolerance(now_.values[0]), std::numeric_limits<double>::min());
        const Probes probes = worthwhile_probes();
        if (predicted <= tolerance && probes.gain <= tolerance) {
            if (predicted < 0 && !is_feasible()) return leave("it sees no way to the constraints");
            return end_as(LowFidelityEnd::Why::exhausted);
        }
        if (guard_.options.on_model && hessian_.size() > 0 && is_feasible() &&
            !guard_.options.on_model(std::max(predicted, 0.0) + probes.gain, hessian_))
            return end_as(LowFidelityEnd::Why::outpaced);
        // Before its first step nothing says that the cheap program is worth it.
        const bool is_tried = good_ + bad_ > 0;
        if ((is_tried || predicted <= tolerance) && probes.gain_each > trust_ * predicted)
            return evaluate_probes(probes);
        return try_design(next, predicted);
    }

    bool try_design(const CorrectedOptimum& next, double predicted) {
        Evaluation trial;
        const VectorXd x = guard_.inside(next.x);
        const double length = metric_norm(program_, x - now_.x);
        if (!guard_.try_at(x, false, trial)) {
            if (guard_.cause != StopCause::failure) return end_as(LowFidelityEnd::Why::ended);
            guard_.cause = StopCause::none;
            failed_at(x, length);
            return ++failures_in_row_ < max_failures || leave("evaluations fail where it leads");
        }
        failures_in_row_ = 0;
        const double actual = merit(now_.values) - merit(values_of(trial)), ratio = actual / predicted;
        report(predicted, actual);
        end_.expected += predicted;
        end_.kept += actual;
        trust_ = std::max(min_trust, memory_of_trust * trust_ + (1 - memory_of_trust) * std::clamp(ratio, 0.0, 1.0));
        if (ratio < poor)
            radius_ = std::clamp(0.5 / (1 - std::min(ratio, 0.0)), min_cut, max_cut) * std::min(radius_, length);
        else if (ratio > good && next.is_limited)
            radius_ = std::min(growth * radius_, max_radius);
        const bool is_better = actual > 0 && ratio > acceptable;
        if (is_better) {
            if (has_own_gradients_ && !guard_.try_at(x, true, trial)) return gradient_failed();
            if (!move_to(x, trial)) return leave("it has no value at the new design");
            ++accepted_;
        } else if (!learn(x, trial)) {
            return leave("it has no value at a design that was tried");
        }
        return count(is_better && ratio > poor);
    }

    /// Where enough is known of a border of failures, the next step keeps to this side of it; else it is shorter.
    void failed_at(const VectorXd& x, double length) {
        hessian_.resize(0, 0);
        const std::optional<FailureCut> cut = border_cut();
        const bool is_beyond = cut && cut->normal.dot(x) > cut->limit;
        if (!is_beyond) radius_ = failure_cut * std::min(radius_, length);
        guard_.report_event(text("cheap model: no value where it leads (evaluation ", guard_.evaluations, "): ",
                                 is_beyond ? "steps keep to this side of the plane between what failed and what did not"
                                           : text("the largest step is cut to ", rounded(radius_))));
    }

    std::optional<FailureCut> border_cut() const {
        const std::optional<FailureClassifier> classifier = guard_.border.classifier(now_.x, metric_);
        if (!classifier) return {};
        return classifier->cut(now_.x, 0);
    }

    bool gradient_failed() {
        if (guard_.cause != StopCause::failure) return end_as(LowFidelityEnd::Why::ended);
        guard_.cause = StopCause::none;
        return leave("a gradient failed");
    }

    /// After a step whose decrease was as expected, or was not.
    bool count(bool is_good) {
        bad_in_row_ = is_good ? 0 : bad_in_row_ + 1;
        if (!is_good) hessian_.resize(0, 0);  // that of another model than the next
        is_good ? ++good_ : ++bad_;
        if (bad_in_row_ >= max_misled || bad_ > max_misled + good_ || radius_ < min_radius)
            return leave("the decreases it expects do not come");
        return true;
    }

    bool learn(const VectorXd& x, const Evaluation& at) {
        Evaluation cheap;
        if (!measure(x, false, cheap)) return false;
        model_.add_point(x, values_of(at), values_of(cheap));
        return true;
    }

    // What it would be worth to know more of the residual's slope.

    struct Probes {
        MatrixXd directions;   ///< of length 1 in the metric
        double gain = 0;       ///< expected
        double gain_each = 0;  ///< per evaluation, that of the step after them included
    };

    /// Normals of what holds the design at its place, whitened.
    MatrixXd held(const Evaluation& here) const {
        const VectorXd lambda = multipliers(program_, now_.x, here);
        std::vector<VectorXd> normals;
        for (Index i = 0; i < here.constraints.size(); ++i)
            if (i >= program_.num_inequalities || lambda[i] > 0) normals.push_back(here.jacobian.row(i).transpose());
        for (Index i = 0; i < here.limits.values.size(); ++i)
            if (here.limits.values[i] > -nearly_active) normals.push_back(here.limits.slopes.row(i).transpose());
        const VectorXd slope = here.gradient + here.jacobian.transpose() * lambda;
        for (Index j = 0; j < now_.x.size(); ++j)
            if (!(program_.lower[j] < program_.upper[j]) || leaves_bounds(program_, now_.x, j, -slope[j]))
                normals.push_back(VectorXd::Unit(now_.x.size(), j));
        MatrixXd all(now_.x.size(), static_cast<Index>(normals.size()));
        for (Index k = 0; k < all.cols(); ++k) all.col(k) = normals[static_cast<std::size_t>(k)];
        return model_.root().transpose().triangularView<Eigen::Lower>().solve(all);
    }

    /// The expected decrease that an error e of the slope hides is e.H^-1 e / 2.
    Probes worthwhile_probes() const {
        Probes probes;
        const int affordable = guard_.limit - guard_.evaluations - 1;
        if (has_own_gradients_ || hessian_.size() == 0 || affordable < 1) return probes;
        const Evaluation here = composed();
        VectorXd weights(now_.values.size());
        weights << 1, multipliers(program_, now_.x, here);
        const MatrixXd normals = held(here);
        const Index n = now_.x.size();
        const MatrixXd Z = across(normals);
        if (Z.cols() == 0) return probes;
        const auto upper = model_.root().triangularView<Eigen::Upper>();
        const MatrixXd inverse = upper.solve(MatrixXd::Identity(n, n));
        const MatrixXd H = Z.transpose() * (inverse.transpose() * hessian_ * inverse) * Z;
        const MatrixXd C = Z.transpose() * model_.covariance(weights) * Z;
        const Eigen::LLT<MatrixXd> llt(H);
        if (llt.info() != Eigen::Success) return probes;
        const MatrixXd half = llt.matrixL().solve(C);
        const MatrixXd S = llt.matrixL().solve(half.transpose());
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (S + S.transpose()));
        MatrixXd directions = Z * llt.matrixU().solve(eigen.eigenvectors().rowwise().reverse());
        directions.colwise().normalize();
        const VectorXd gains = eigen.eigenvalues().reverse();
        double sum = 0;
        for (Index k = 0; k < std::min<Index>(gains.size(), affordable); ++k) {
            const VectorXd v = Z.transpose() * directions.col(k);
            // No further than the trust region.
            sum += std::min(0.5 * std::max(gains[k], 0.0), radius_ * std::sqrt(std::max(v.dot(C * v), 0.0)));
            if (sum / double(k + 2) <= probes.gain_each) break;
            probes.gain = sum;
            probes.gain_each = sum / double(k + 2);
            probes.directions = inverse * directions.leftCols(k + 1);
        }
        return probes;
    }

    /// Downhill of the present design; after a round without any value on the other side, then nearer. Fewer than asked
    /// for where limits leave no room; the search may have ended.
    std::vector<VectorXd> probe_points(const Probes& probes) {
        const double side = failed_probes_ % 2 == 0 ? 1 : -1, nearer = std::pow(failure_cut, failed_probes_ / 2);
        const VectorXd slope = side * composed().gradient;
        const double length =
            nearer * std::min(radius_, std::max(probe_length, program_.differences ? program_.differences->step : 0.0));
        std::vector<VectorXd> points;
        for (Index k = 0; k < probes.directions.cols() && guard_.cause == StopCause::none; ++k) {
            const VectorXd d = length * probes.directions.col(k);
            const VectorXd there = now_.x + (slope.dot(d) > 0 ? -d : d);
            const VectorXd point = guard_.inside(there.cwiseMax(program_.lower).cwiseMin(program_.upper));
            if (metric_norm(program_, point - now_.x) > 0.1 * length) points.push_back(point);
        }
        return points;
    }

    bool evaluate_probes(const Probes& probes) {
        const std::vector<VectorXd> points = probe_points(probes);
        if (guard_.cause != StopCause::none) return end_as(LowFidelityEnd::Why::ended);
        if (points.empty()) return end_as(LowFidelityEnd::Why::exhausted);
        guard_.report_event(text("cheap model: ", points.size(), points.size() == 1 ? " design" : " designs",
                                 " next to the present one tell what it does not know"));
        if (program_.expect) program_.expect(points);
        struct Found {
            VectorXd x;
            Evaluation at;
        };
        std::optional<Found> better;
        int values = 0;
        for (const VectorXd& x : points) {
            Evaluation at;
            if (!guard_.try_at(x, false, at)) {
                if (guard_.cause != StopCause::failure) return end_as(LowFidelityEnd::Why::ended);
                guard_.cause = StopCause::none;
                continue;
            }
            if (!learn(x, at)) continue;
            ++values;
            if (merit(values_of(at)) < (better ? merit(values_of(better->at)) : merit(now_.values)))
                better = Found{x, at};
        }
        if (values == 0)
            return ++failed_probes_ < max_failures || leave("designs next to the present one have no value");
        failed_probes_ = 0;
        if (better && !move_to(better->x, better->at)) return leave("it has no value at the new design");
        return true;
    }

    // What it stands for.

    Evaluation composed() const {
        Evaluation here = at_;
        const MatrixXd all = model_.gradients();
        here.gradient = all.col(0);
        here.jacobian = all.rightCols(all.cols() - 1).transpose();
        here.limits = now_.limits;
        return here;
    }
    double violation(const VectorXd& values) const { return total_violation(program_, values.tail(values.size() - 1)); }
    double merit(const VectorXd& values) const { return values[0] + penalty_ * violation(values); }
    bool is_feasible() const {
        return largest_violation(program_, now_.values.tail(now_.values.size() - 1)) <=
               guard_.options.constraint_tolerance;
    }
    void raise_penalty() {
        if (now_.values.size() == 1) return;
        const Evaluation here = composed();
        penalty_ = std::max(penalty_, penalty_factor * multipliers(program_, now_.x, here).lpNorm<Eigen::Infinity>());
    }
    double decrease_to(const VectorXd& values) {
        const double gain = now_.values[0] - values[0], relief = violation(now_.values) - violation(values);
        if (relief > 0 && relief > guard_.options.constraint_tolerance)
            penalty_ = std::max(penalty_, -gain / (penalty_share * relief));
        return gain + penalty_ * relief;
    }

    void report(double predicted, double actual) const {
        std::string scales;
        for (std::size_t i = 0; i < low_.values.size(); ++i)
            if (low_.values[i] == LowFidelityValue::approximate)
                scales += text(scales.empty() ? "" : ", ", rounded(model_.rho()[static_cast<Index>(i)]));
        guard_.report_event(text("cheap model: rho ", scales, ", decrease predicted ", rounded(predicted), ", actual ",
                                 rounded(actual), " (", rounded(actual / predicted), ")"));
    }

    bool end_as(LowFidelityEnd::Why why) {
        end_.why = why;
        return false;
    }
    bool leave(const std::string& why) {
        guard_.report_event(text("cheap model: ", why, "; the search goes on without it"));
        return end_as(LowFidelityEnd::Why::misled);
    }

    LowFidelityEnd finish() {
        end_.x = now_.x;
        end_.radius = radius_;
        end_.accepted = accepted_;
        end_.rho = model_.rho();
        if (now_.x.size() == 0) return end_;
        end_.at = composed();
        end_.hessian = hessian_;
        if (!has_own_gradients_) {
            VectorXd weights(now_.values.size());
            weights << 1, multipliers(program_, now_.x, end_.at);
            const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(model_.covariance(weights));
            end_.gradient_error = model_.root().transpose() * eigen.eigenvectors() *
                                  eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
        }
        return end_;
    }

    Guard& guard_;
    const NonlinearProgram& program_;
    const LowFidelity& low_;
    MatrixXd metric_;
    ResidualModel model_;
    const bool has_own_gradients_;
    LowFidelityPoint now_;
    Evaluation at_;
    MatrixXd hessian_;
    double penalty_ = 0;  ///< of a unit of violation
    double radius_ = first_radius, trust_ = first_trust;
    int good_ = 0, bad_ = 0, bad_in_row_ = 0, failures_in_row_ = 0, failed_probes_ = 0, accepted_ = 0;
    LowFidelityEnd end_;
};

}  // namespace

bool learns_from_values(const NonlinearProgram& p) {
    if (!p.differences || !p.low_fidelity) return false;
    const std::vector<LowFidelityValue>& kinds = p.low_fidelity->values;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        const bool is_different =
            i == 0 ? p.differences->objective : p.differences->rows.empty() || p.differences->rows[i - 1];
        if (!is_different && kinds[i] != LowFidelityValue::same) return false;
    }
    return true;
}

LowFidelityEnd minimize_by_low_fidelity(Guard& guard) { return LowFidelitySearch(guard).run(); }

}  // namespace strake
