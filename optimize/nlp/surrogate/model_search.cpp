#include "optimize/nlp/surrogate/model_search.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"
#include "optimize/nlp/sqp/sqp.hpp"
#include "optimize/nlp/surrogate/local_models.hpp"
#include "optimize/nlp/surrogate/spread.hpp"

#include <Eigen/QR>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double exploiting_share = 0.375;  ///< of a batch: minima of the means within 1, 2 and 1/2 radii
/// Radii, of the lower confidence bounds: nearer points say more of the slope and less of the curvature.
constexpr double exploring_radius = 0.3;
constexpr double confidence = 2;         ///< standard deviations of the lower confidence bound
constexpr double max_radius = 4;         ///< times the first
constexpr double min_radius = 1e-4;      ///< times the first: below it no model helps
constexpr double least_distance = 1e-6;  ///< radii between two points
constexpr int inner_evaluations = 80;    ///< of the models, for one point
constexpr double penalty_over_multiplier = 2;
constexpr int steps_without_promise = 2;
constexpr double inward = 1e-3;  ///< share of the way back from the limit that points are moved inside of

/// A point of a batch and what the models expect there.
struct Proposal {
    VectorXd x, z;
    double radius = 0;
    VectorXd expected;  ///< values
};

class ModelSearch {
public:
    explicit ModelSearch(Guard& guard)
        : guard_(guard),
          points_(guard),
          radius_(guard.options.first_step),
          margin_(VectorXd::Zero(guard.best.constraints.size())) {}

    SearchEnd run() {
        points_.add(guard_.best_x, guard_.best);
        add_known();
        directions_ = spread_directions();
        while (!has_ended_) step();
        return end_;
    }

private:
    const NonlinearProgram& program() const { return guard_.program; }

    void add_known() {
        if (!program().known) return;
        for (const KnownPoint& known : program().known()) {
            if (!known.evaluation.failure.empty())
                guard_.border.add_failed(known.x);
            else if (values_of(known.evaluation).allFinite() && !points_.knows(points_.whitened(known.x), 0))
                points_.add(known.x, known.evaluation);
        }
    }

    /// Orthogonal directions, and others when these are used up.
    MatrixXd spread_directions() const {
        const Eigen::Index d = points_.dimensions();
        const MatrixXd cloud =
            latin_hypercube(static_cast<int>(d), static_cast<int>(d), guard_.options.seed).array() - 0.5;
        return Eigen::HouseholderQR<MatrixXd>(cloud).householderQ();
    }

    double merit(const VectorXd& values) const {
        Evaluation at;
        at.constraints = values.tail(values.size() - 1);
        return values[0] + penalty_ * total_violation(program(), at.constraints);
    }

    int centre() const {
        int best = 0;
        for (int i = 1; i < points_.size(); ++i)
            if (merit(points_[i].values) < merit(points_[best].values)) best = i;
        return best;
    }

    void step() {
        centre_ = centre();
        if (points_.size() > 1) {
            models_ = std::make_unique<LocalModels>(points_, points_[centre_].z, radius_, models_.get());
            raise_penalty();
            centre_ = centre();
        }
        cut_ = border_cut();
        const std::vector<Proposal> batch = points_.size() > 1 ? propose() : first_batch();
        if (has_no_promise(batch)) return;
        evaluate(batch);
    }

    /// By multipliers of the models' gradients.
    void raise_penalty() {
        const Eigen::Index rows = models_->size() - 1;
        if (rows == 0) return;
        const SampledPoints::Point& c = points_[centre_];
        Evaluation at;
        at.objective = c.values[0];
        at.constraints = c.values.tail(rows);
        at.gradient = unwhitened((*models_)[0].gradient(c.z));
        at.jacobian.resize(rows, c.x.size());
        for (Eigen::Index i = 0; i < rows; ++i)
            at.jacobian.row(i) = unwhitened((*models_)[i + 1].gradient(c.z)).transpose();
        const VectorXd found = multipliers(program(), c.x, at);
        if (found.allFinite()) penalty_ = std::max(penalty_, penalty_over_multiplier * found.lpNorm<Eigen::Infinity>());
        if (penalty_ == 0) penalty_ = at.gradient.norm();
        guard_.penalty = penalty_;
    }

    /// A gradient by z as one by x.
    VectorXd unwhitened(const VectorXd& gradient) const {
        VectorXd g = VectorXd::Zero(program().start.size());
        g(points_.free()) = points_.U().transpose() * gradient;
        return g;
    }

    std::optional<FailureCut> border_cut() const {
        const VectorXd& x = points_[centre_].x;
        const auto classifier = guard_.border.classifier(x, metric_of(program()));
        if (!classifier) return {};
        return classifier->cut(x, 0);
    }

    /// Nothing is known but the start: points around it.
    std::vector<Proposal> first_batch() {
        std::vector<Proposal> batch;
        for (int k = 0; k < places(); ++k) {
            const double sign = k / points_.dimensions() % 2 == 0 ? 1 : -1;
            add(batch, points_[centre_].z + sign * exploring_radius * radius_ * next_direction(),
                exploring_radius * radius_);
        }
        return batch;
    }

    VectorXd next_direction() { return directions_.col(used_directions_++ % directions_.cols()); }

    int places() const { return std::min(guard_.options.batch, guard_.limit - guard_.evaluations); }

    std::vector<Proposal> propose() {
        LocalModels models = *models_;
        std::vector<Proposal> batch;
        const int exploiting = std::max(1, static_cast<int>(std::lround(exploiting_share * guard_.options.batch)));
        const double radii[] = {1, 2, 0.5};
        for (int k = 0; k < places(); ++k) {
            const bool exploits = k < exploiting;
            const double radius = radius_ * (exploits ? radii[k % 3] : exploring_radius);
            const VectorXd z = minimum(models, exploits ? 0 : confidence, radius);
            const std::size_t before = batch.size();
            add(batch, z, radius);
            if (batch.size() == before)
                add(batch, points_[centre_].z + exploring_radius * radius_ * next_direction(), radius);
            if (batch.size() > before) models.believe(batch.back().z);
        }
        return batch;
    }

    /// Where it is evaluated, unless that is known.
    void add(std::vector<Proposal>& batch, const VectorXd& z, double radius) {
        const VectorXd& c = points_[centre_].x;
        const VectorXd asked = points_.variables(z);
        VectorXd x = guard_.inside(asked);
        if (guard_.cause != StopCause::none) return;
        if (x != asked) x = c + (1 - inward) * (x - c);
        Proposal p{x, points_.whitened(x), radius, {}};
        const double least = least_distance * radius_;
        if (points_.knows(p.z, least)) return;
        if (std::ranges::any_of(batch, [&](const Proposal& q) { return (q.z - p.z).norm() <= least; })) return;
        if (models_) {
            p.expected.resize(models_->size());
            for (Eigen::Index i = 0; i < p.expected.size(); ++i) p.expected[i] = (*models_)[i].mean(p.z);
        }
        batch.push_back(std::move(p));
    }

    /// Least lower confidence bound of the objective within the radius, under the means of the constraints.
    VectorXd minimum(const LocalModels& models, double deviations, double radius) {
        const SampledPoints::Point& c = points_[centre_];
        NonlinearProgram p;
        const auto& free = points_.free();
        p.start = c.x(free);
        p.lower = program().lower(free);
        p.upper = program().upper(free);
        p.metric = metric_of(program())(free, free);
        if (deviations > 0) p.start = points_.variables(c.z + 0.5 * radius * next_direction())(free);
        p.num_inequalities = program().num_inequalities + 1 + (cut_ ? 1 : 0);
        p.num_equalities = program().num_equalities;
        p.evaluate = [&](const VectorXd& y) { return modelled(models, full(y), deviations, radius); };
        p.differentiate = [&](const VectorXd& y, Evaluation& at) {
            differentiate(models, full(y), deviations, radius, at);
        };
        MinimizeOptions how;
        how.max_evaluations = inner_evaluations;
        how.confirm = false;
        how.first_step = 0.5 * radius;
        how.objective_tolerance = how.step_tolerance = 1e-5;
        how.objective_scale = models[0].scale();
        how.constraint_tolerance = 1e-6;
        how.clock = [] { return 0.0; };
        Guard inner(p, how);
        Evaluation at;
        if (inner.try_at(p.start, true, at)) minimize_by_sqp(inner);
        return points_.whitened(full(inner.best_x));
    }

    VectorXd full(const VectorXd& y) const {
        VectorXd x = program().start;
        x(points_.free()) = y;
        return x;
    }

    /// Rows: inequalities of the program, the radius, the border; then equalities.
    Evaluation modelled(const LocalModels& models, const VectorXd& x, double deviations, double radius) const {
        const VectorXd z = points_.whitened(x), step = z - points_[centre_].z;
        const int inequalities = program().num_inequalities, more = 1 + (cut_ ? 1 : 0);
        Evaluation at;
        at.objective = models[0].mean(z);
        if (deviations > 0) at.objective -= deviations * std::sqrt(models[0].variance(z) + floor(models));
        at.constraints.resize(models.size() - 1 + more);
        for (Eigen::Index i = 0; i + 1 < models.size(); ++i)
            at.constraints[i < inequalities ? i : i + more] = models[i + 1].mean(z) + margin_[i];
        at.constraints[inequalities] = 0.5 * (step.squaredNorm() / (radius * radius) - 1);
        if (cut_) at.constraints[inequalities + 1] = (cut_->normal.dot(x) - cut_->limit) / radius;
        return at;
    }

    static double floor(const LocalModels& models) { return 1e-12 * models[0].scale() * models[0].scale(); }

    void differentiate(const LocalModels& models, const VectorXd& x, double deviations, double radius,
                       Evaluation& at) const {
        const VectorXd z = points_.whitened(x), step = z - points_[centre_].z;
        const int inequalities = program().num_inequalities, more = 1 + (cut_ ? 1 : 0);
        const auto by_y = [&](const VectorXd& g) -> VectorXd { return points_.U().transpose() * g; };
        VectorXd g = models[0].gradient(z);
        if (deviations > 0)
            g -= deviations / (2 * std::sqrt(models[0].variance(z) + floor(models))) * models[0].variance_gradient(z);
        at.gradient = by_y(g);
        at.jacobian.resize(at.constraints.size(), g.size());
        for (Eigen::Index i = 0; i + 1 < models.size(); ++i)
            at.jacobian.row(i < inequalities ? i : i + more) = by_y(models[i + 1].gradient(z)).transpose();
        at.jacobian.row(inequalities) = by_y(step / (radius * radius)).transpose();
        if (cut_) at.jacobian.row(inequalities + 1) = cut_->normal(points_.free()).transpose() / radius;
    }

    /// The models expect nothing more, or there is nothing left to ask.
    bool has_no_promise(const std::vector<Proposal>& batch) {
        if (guard_.cause != StopCause::none) return end_by_guard();
        if (guard_.limit <= guard_.evaluations) {
            guard_.cause = StopCause::evaluations;
            return end_by_guard();
        }
        if (radius_ < min_radius * guard_.options.first_step)
            return end(failing_ > 0 ? MinimizeStop::no_valid_step : MinimizeStop::converged,
                       failing_ > 0 ? text("evaluations fail however short the step (", guard_.failure, ")")
                                    : "the radius of the trust region is below the tolerance");
        if (batch.empty()) {
            radius_ *= 0.5;
            return true;
        }
        if (!models_) return false;
        const SampledPoints::Point& c = points_[centre_];
        const double size = std::max(std::abs(c.values[0]), guard_.options.objective_scale);
        const double floor = guard_.options.objective_tolerance * size;
        const bool knows_enough = points_.size() > points_.dimensions() + 1;
        const bool has_promise = merit(c.values) - merit(batch[0].expected) > floor;
        idle_ = has_promise || !knows_enough ? 0 : idle_ + 1;
        if (idle_ <= steps_without_promise) return false;
        return end(MinimizeStop::converged, "the models expect a decrease below the tolerance");
    }

    void evaluate(const std::vector<Proposal>& batch) {
        std::vector<VectorXd> designs;
        for (const Proposal& p : batch) designs.push_back(p.x);
        if (program().expect) program().expect(designs);
        const double before = merit(points_[centre_].values);
        const VectorXd from = points_[centre_].z;
        double best = before, length = 0;
        int failed = 0;
        for (const Proposal& p : batch) {
            Evaluation at;
            if (guard_.try_at(p.x, false, at)) {
                points_.add(p.x, at);
                learn_margin(p, at);
                if (const double m = merit(values_of(at)); m < best) best = m, length = (p.z - from).norm();
            } else if (guard_.cause == StopCause::failure) {
                guard_.cause = StopCause::none;
                ++failed;
            } else {
                end_by_guard();
                return;
            }
        }
        failing_ = 2 * failed > static_cast<int>(batch.size()) && best == before ? failing_ + 1 : 0;
        adapt(before - best, before - (batch[0].expected.size() > 0 ? merit(batch[0].expected) : before), length);
        if (failing_ > guard_.options.max_shrinks)
            end(MinimizeStop::no_valid_step, text("evaluations fail however short the step (", guard_.failure, ")"));
    }

    /// Constraints that turn out larger than expected keep a distance that shrinks with what they err by.
    void learn_margin(const Proposal& p, const Evaluation& at) {
        if (p.expected.size() == 0 || p.radius > radius_) return;
        for (int i = 0; i < program().num_inequalities; ++i) {
            const double error = std::max(0.0, at.constraints[i] - p.expected[i + 1]);
            const double near = std::abs(p.expected[i + 1]) < 2 * error ? error : 0;
            margin_[i] = 0.7 * margin_[i] + 0.15 * near;
        }
    }

    void adapt(double gained, double promised, double length) {
        const double largest = max_radius * guard_.options.first_step;
        if (!models_ && points_.size() > 1) return;
        if (gained <= 0)
            radius_ *= 0.5;
        else if (length > 1.2 * radius_)
            radius_ = std::min(2 * radius_, largest);
        else if (length > 0.8 * radius_ && gained > 0.5 * promised)
            radius_ = std::min(1.4 * radius_, largest);
        else if (gained < 0.1 * promised)
            radius_ = std::max(0.5 * radius_, length);
        if (gained <= 0) ++end_.shrinks;
    }

    bool end_by_guard() {
        end_ = end_by_cause(guard_);
        has_ended_ = true;
        return true;
    }
    bool end(MinimizeStop stop, const std::string& reason) {
        end_.stop = stop;
        end_.reason = reason;
        end_.x = guard_.best_x;
        has_ended_ = true;
        return true;
    }

    Guard& guard_;
    SampledPoints points_;
    double radius_;  ///< in z
    VectorXd margin_;
    MatrixXd directions_;
    Eigen::Index used_directions_ = 0;
    std::unique_ptr<LocalModels> models_;
    std::optional<FailureCut> cut_;
    double penalty_ = 0;
    int centre_ = 0, idle_ = 0, failing_ = 0;
    SearchEnd end_;
    bool has_ended_ = false;
};

}  // namespace

SearchEnd minimize_by_model(Guard& guard) { return ModelSearch(guard).run(); }

}  // namespace strake
