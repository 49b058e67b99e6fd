#include "optimize/nlp/surrogate/model_search.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"
#include "optimize/nlp/surrogate/allowed_minimum.hpp"
#include "optimize/nlp/surrogate/first_directions.hpp"
#include "optimize/nlp/surrogate/mirror_directions.hpp"
#include "optimize/nlp/surrogate/pace.hpp"
#include "optimize/nlp/surrogate/proposals.hpp"
#include "optimize/nlp/surrogate/restored_design.hpp"
#include "optimize/nlp/surrogate/untried.hpp"

#include <cmath>
#include <memory>
#include <optional>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double exploring_radius = 0.5;  ///< of the others, in radii: nearer points say more of the slopes
constexpr double first_length = 0.3;      ///< of the first batch, in radii
constexpr double few_first_length = 0.6;  ///< the same where it `begins_with_few`
constexpr double new_share = 0.5;         ///< of a step that looks around, beyond all directions that were tried
constexpr double confidence = 2;          ///< standard deviations of the lower confidence bound
constexpr double max_radius = 4;          ///< times the first
constexpr double min_radius = 1e-4;       ///< times the first: below it no model helps
constexpr double min_distance = 1e-6;     ///< radii between two points
constexpr double same_point = 1e-9;       ///< in z: round-off of inherited designs
constexpr double next_to = 1e-2;          ///< radii
constexpr double penalty_over_multiplier = 2;
constexpr int idle_steps = 2, max_forgotten_borders = 3;
constexpr double kept_length = 0.5;       ///< of a step that exact limits shorten: less is tried the other way
constexpr double min_length_left = 0.1;   ///< what they leave less of goes on as it was: there is nothing to learn
constexpr double visible_noise = 1e-3;    ///< of the model's scale: with more, means tell where the best point is
constexpr int restoration_period = 8;     ///< evaluations of which one leads back to limits
constexpr int last_restorations = 2;      ///< at the end: each leaves some percent of what is missed
constexpr double visible_deviations = 2;  ///< of a model's noise: what misses an equation by less may be noise

class ModelSearch {
public:
    explicit ModelSearch(Guard& guard)
        : guard_(guard),
          points_(guard),
          radius_(guard.options.first_step),
          untried_(radius_),
          allowed_(guard),
          minimum_(guard, points_, allowed_, region_, [this](const VectorXd& values) { return merit(values); }) {
        region_.margin = VectorXd::Zero(guard.program.num_inequalities);
        region_.offset = VectorXd::Zero(guard.program.num_inequalities + guard.program.num_equalities);
        region_.is_in_variables = guard.options.minima_in_variables;
        restores_limits_ = !guard.options.leaves_limits && !allowed_.has_turns() && !known().rows().empty();
        restores_equations_ = !guard.options.leaves_equations && has_equations_to_learn();
    }

    ModelEnd run() {
        points_.add(guard_.best_x, guard_.best);
        add_known();
        look_for_symmetry();
        directions_ = first_directions(guard_, points_, !guard_.options.limits_by_models && !known().rows().empty());
        while (!has_ended_) step();
        end_.radius = radius_;
        if (without_shape_ > 0)
            guard_.report_event(text(without_shape_, " proposed designs had no valid shape and were not evaluated"));
        if (models_) end_.noise = (*models_)[0].noise();
        if (models_ && centre().values.allFinite()) tell_slopes();
        return end_;
    }

private:
    const NonlinearProgram& program() const { return guard_.program; }
    const KnownConstraints& known() const { return allowed_.known(); }
    /// Constraints that need no model.
    std::vector<Eigen::Index> exact_rows() const {
        return guard_.options.limits_by_models ? std::vector<Eigen::Index>{} : known().rows();
    }
    const SampledPoints::Point& centre() const { return points_[centre_]; }

    void add_known() {
        if (!program().known) return;
        for (const KnownPoint& known : program().known()) {
            const bool failed = !known.evaluation.failure.empty();
            if (failed) guard_.border.add_failed(known.x);
            if (!failed && !values_of(known.evaluation).allFinite()) continue;
            // Points of differences say nothing more.
            const double nearest = guard_.options.tries_in_order ? next_to * radius_ : same_point;
            if (!points_.knows(points_.whitened(known.x), nearest)) points_.add(known.x, known.evaluation);
        }
    }

    /// Where values are the same for mirror images, slopes across the symmetry are zero: what is symmetric is searched.
    void look_for_symmetry() {
        const MirrorLook look(program(), points_);
        const bool is_new = guard_.options.evaluations_before == 0;  // else the search before has looked
        const MatrixXd even = look.even(is_new && look.is_worth(left()) ? compared(look) : std::vector<char>{});
        if (has_ended_ || even.cols() == points_.dimensions()) return;
        guard_.report_event(look.words(even.cols()));
        if (guard_.options.limit_follows_variables)
            guard_.limit = guard_.evaluations + look.evaluations_for(even.cols(), left(), guard_.options.batch);
        points_.restrict_to(even);
        if (allowed_.here()) find_nearest();  // in the coordinates that are left
    }

    std::vector<char> compared(const MirrorLook& look) {
        region_.centre = centre().z, look_at_limits();
        const std::vector<VectorXd> steps = look.steps(first_length * radius_, guard_.options.seed);
        const int known = points_.size();
        std::vector<char> holds;
        for (std::size_t k = 1; k < steps.size() && (k == 1 || holds[0]); ++k) {
            std::vector<Proposal> batch;
            if (!((k > 1 || add_step(batch, steps[0])) && add_step(batch, steps[k]))) break;  // limits move it
            evaluate(batch);
            if (has_ended_) return holds;
            if (points_.size() != known + static_cast<int>(k) + 1) break;  // failures tell nothing
            const double blur = guard_.options.images_are_exact ? 0 : look.blur(k - 1, steps[0]);
            holds.push_back(look.is_same(points_[0], points_[known], points_[points_.size() - 1], blur));
        }
        points_.forget_from(known);  // first steps are better taken in order
        return holds;
    }

    bool add_step(std::vector<Proposal>& batch, const VectorXd& step) {
        const std::size_t before = batch.size();
        add(batch, points_.variables(centre().z + step), step.norm());
        return batch.size() > before && (batch.back().z - centre().z - step).norm() <= next_to * step.norm();
    }

    double merit(const VectorXd& values) const {
        VectorXd constraints = values.tail(values.size() - 1);
        for (const Eigen::Index i : exact_rows())  // rounding next to exact limits tells no designs apart
            if (std::abs(constraints[i]) <= 0.5 * guard_.options.constraint_tolerance) constraints[i] = 0;
        return values[0] + penalty_ * total_violation(program(), constraints);
    }

    bool is_noisy() const { return models_ && (*models_)[0].noise() > visible_noise * (*models_)[0].scale(); }
    /// Where the search stands: the best point; where there is noise, by the means of the models.
    int best_point() const {
        int best = 0;
        if (is_noisy()) {
            double lowest = std::numeric_limits<double>::infinity();
            for (const int i : models_->used())
                if (const double m = merit(without_noise(points_[i])); m < lowest) lowest = m, best = i;
            return best;
        }
        for (int i = 1; i < points_.size(); ++i)
            if (merit(points_[i].values) < merit(points_[best].values)) best = i;
        return best;
    }

    VectorXd without_noise(const SampledPoints::Point& point) const {
        VectorXd values = models_->means(point.z);
        for (const Eigen::Index i : exact_rows()) values[i + 1] = point.values[i + 1];
        return values;
    }

    void step() {
        centre_ = best_point();
        if (points_.size() > 1) {
            models_ = std::make_unique<LocalModels>(points_, centre().z, radius_, !guard_.options.learns_as_before,
                                                    models_.get());
            look_at_limits();
            raise_penalty();
            centre_ = best_point();
        }
        region_.centre = centre().z;
        region_.cut = border_cut();
        look_at_limits();
        refused_ = 0;
        go_on_while_gaining();
        const std::vector<Proposal> batch = models_ ? propose() : first_batch();
        if (!ends_here(batch)) evaluate(batch);
    }

    /// What exact limits are where the search stands.
    void look_at_limits() {
        if (!guard_.options.limits_by_models && allowed_.look_from(centre().x)) find_nearest();
    }
    void find_nearest() {
        nearest_ = knows_slopes() ? points_.whitened(known().nearest(centre().x, *allowed_.here())) : centre().z;
    }

    /// At the centre, with gradients by the models.
    Evaluation differentiated() const {
        const Eigen::Index rows = models_->size() - 1;
        const SampledPoints::Point& c = centre();
        Evaluation at;
        at.objective = c.values[0];
        at.constraints = c.values.tail(rows);
        at.gradient = points_.unwhitened((*models_)[0].gradient(c.z));
        at.jacobian.resize(rows, c.x.size());
        for (Eigen::Index i = 0; i < rows; ++i)
            at.jacobian.row(i) = points_.unwhitened((*models_)[i + 1].gradient(c.z)).transpose();
        // Where all points lie on a limit, what its model has in place of a slope is rounding.
        if (knows_slopes() && allowed_.here()->x == c.x)
            for (const Eigen::Index i : known().rows()) at.jacobian.row(i) = allowed_.here()->jacobian.row(i);
        return at;
    }

    /// What a search by gradients begins with after this one.
    void tell_slopes() {
        centre_ = best_point();
        look_at_limits();
        end_.x = centre().x;
        end_.at = differentiated();
        const VectorXd lambda = multipliers(program(), end_.x, end_.at);
        MatrixXd H = (*models_)[0].hessian(centre().z);
        if (lambda.allFinite())
            for (Eigen::Index i = 0; i < lambda.size(); ++i)
                if (lambda[i] != 0) H += lambda[i] * (*models_)[i + 1].hessian(centre().z);
        end_.hessian = points_.positive_hessian(H);
    }

    /// By multipliers of the models' gradients.
    void raise_penalty() {
        if (models_->size() == 1) return;
        const SampledPoints::Point& c = centre();
        const Evaluation at = differentiated();
        const VectorXd found = multipliers(program(), c.x, at);
        if (found.allFinite()) penalty_ = std::max(penalty_, penalty_over_multiplier * found.lpNorm<Eigen::Infinity>());
        if (penalty_ == 0) penalty_ = at.gradient.norm();
        guard_.penalty = penalty_;
    }

    std::optional<FailureCut> border_cut() const {
        const auto classifier = guard_.border.classifier(centre().x, metric_of(program()));
        if (!classifier) return {};
        return classifier->cut(centre().x, 0);
    }

    int left() const { return guard_.limit - guard_.evaluations; }
    int left_for_batches() const {
        const bool restores = restores_equations_ || (restores_limits_ && allowed_.is_beside(centre().x));
        return restores && left() > last_restorations ? left() - last_restorations : left();
    }
    int places() const { return std::max(0, std::min(guard_.options.batch, left_for_batches())); }
    /// The last batch has nothing to learn for.
    bool is_last_batch() const { return left_for_batches() <= guard_.options.batch; }
    /// A limit that may grow does so before what would be the last batch, which is another one.
    void go_on_while_gaining() {
        pace_.note(guard_.evaluations, centre().values);
        const int most = guard_.options.limit_while_gaining - guard_.limit, batch = guard_.options.batch;
        if (most < batch || !is_last_batch()) return;
        const double noise = models_ ? (*models_)[0].noise() : 0, share = guard_.options.gaining_share;
        const auto by_merit = [this](const VectorXd& values) { return merit(values); };
        if (!pace_.holds(share, by_merit, visible_deviations * noise)) return;
        const int more = std::min(most, std::max(batch, pace_.part()));
        guard_.limit += more;
        guard_.report_event(text("the limit of evaluations", guard_.options.scope, " grows by ", more,
                                 ": the last quarter of them has gained ", 100 * share, " % of all or more"));
    }
    VectorXd next_direction() { return directions_.col(used_directions_++ % directions_.cols()); }

    /// Nothing is known but the start: points around it.
    std::vector<Proposal> first_batch() {
        const bool is_few = guard_.options.begins_with_few && places() <= points_.dimensions();
        const int designs = is_few ? (places() + 1) / 2 : places();
        std::vector<Proposal> batch;
        for (int k = 0; k < designs; ++k) {
            const auto round = static_cast<int>(k / points_.dimensions());  // to both sides, then farther
            const double length = (1 + round / 2) * (is_few ? few_first_length : first_length) * radius_;
            const std::size_t before = batch.size();
            add(batch, along(round % 2 == 0 ? length : -length), length);
            // What went the other way is there already.
            if (batch.size() == before && knows_slopes()) add(batch, along(2 * length), length);
        }
        return batch;
    }

    /// From the centre along the next direction, or against it where exact limits leave more of that.
    VectorXd along(double length) { return along_step(length * next_direction(), std::abs(length)); }
    VectorXd along_step(const VectorXd& step, double length) {
        const VectorXd there = guard_.inside(points_.variables(centre().z + step));
        if (!knows_slopes() || guard_.cause != StopCause::none) return there;
        if ((nearest_ - centre().z).norm() > radius_) return there;  // limits are too far to be met here
        const VectorXd ahead = kept(there, length);
        if (left_of(ahead) > kept_length * length) return ahead;
        const VectorXd other = guard_.inside(points_.variables(centre().z - step));
        if (guard_.cause != StopCause::none) return there;
        const VectorXd back = kept(other, length);
        const VectorXd& longer = left_of(back) > left_of(ahead) ? back : ahead;
        return left_of(longer) > min_length_left * length ? longer : there;
    }
    /// x, or the design next to it that keeps exact limits.
    VectorXd kept(const VectorXd& x, double length) const {
        const VectorXd nearest = known().nearest(x, *allowed_.here());
        // Slopes that lead farther than the step say too little here.
        return left_of(nearest) <= ProposalRegion::reach * length && !region_.is_beyond_border(nearest) ? nearest : x;
    }
    /// Of a step, once exact limits are kept.
    double left_of(const VectorXd& x) const { return (points_.whitened(x) - nearest_).norm(); }
    bool knows_slopes() const { return allowed_.knows_slopes(); }

    int exploiting() const {
        if (is_last_batch()) return guard_.options.batch;
        if (guard_.options.batch == 1 && !guard_.options.stays_where_models_are_sure) return expects_gain_ ? 0 : 1;
        return minima_of_batch(guard_.options.batch, points_.size(), points_.dimensions());
    }

    /// Equations that only values tell.
    bool has_equations_to_learn() const {
        const Eigen::Index first = program().num_inequalities;
        for (Eigen::Index i = first; i < first + program().num_equalities; ++i)
            if (guard_.options.limits_by_models || !known().has(i)) return true;
        return false;
    }

    /// Where the search stands: equations by more than noise, unless nothing comes after, or exact limits.
    bool is_beside(bool counts_noise) const {
        if (restores_limits_ && allowed_.is_beside(centre().x)) return true;
        if (!restores_equations_) return false;
        const VectorXd& values = centre().values;
        for (Eigen::Index i = program().num_inequalities + 1; i < values.size(); ++i) {
            const double noise = counts_noise ? visible_deviations * (*models_)[i].noise() : 0;
            if (std::abs(values[i]) > std::max(guard_.options.constraint_tolerance, noise)) return true;
        }
        return false;
    }

    void add_restored(std::vector<Proposal>& batch) {
        const std::size_t before = batch.size();
        const VectorXd there = restored(program(), points_.free(), centre().x, differentiated(), radius_, allowed_);
        if (guard_.cause == StopCause::none && !region_.is_beyond_border(there)) add(batch, there, radius_);
        if (batch.size() > before) batch.back().restores = true;
    }

    /// The search would end: it leads back to what it is beside first.
    bool leads_back() {
        if (final_restorations_ >= last_restorations || left() <= 0 || !is_beside(false)) return false;
        ++final_restorations_;
        std::vector<Proposal> batch;
        add_restored(batch);
        if (batch.empty()) return false;
        evaluate(batch);
        return true;
    }

    std::vector<Proposal> propose() {
        std::vector<Proposal> batch;
        const bool is_at_end = left() <= last_restorations;
        const bool is_due = left() > 0 && is_beside(!is_at_end) &&
                            (is_at_end || guard_.evaluations - restored_at_ >= restoration_period);
        const int minima = !is_due ? places() : is_at_end ? 0 : places() - 1;
        if (minima > 0) propose_minima(batch, minima);
        if (!is_due) return batch;
        restored_at_ = guard_.evaluations;
        add_restored(batch);
        if (batch.empty() && minima == 0) propose_minima(batch, places());
        return batch;
    }

    void propose_minima(std::vector<Proposal>& batch, int places) {
        LocalModels models = *models_;
        const int minima = exploiting();
        const bool is_last = is_last_batch();
        const VectorXd margin = region_.margin;
        expects_gain_ = minima > 0;
        for (int k = 0; k < places && guard_.cause == StopCause::none; ++k) {
            const auto tried = is_last ? nullptr : tried_before_all(batch);
            const std::size_t before = batch.size();
            std::optional<Proposal> dropped;
            if (k < minima) dropped = add_minimum(batch, models, k, tried != nullptr);
            if (k == 0 && tried) expects_gain_ = minima > 0 && batch.size() > before;
            if (batch.size() == before && (k >= minima || tried)) look_around(batch, models, tried.get());
            if (batch.size() == before && dropped) {  // there is nothing to look at
                batch.push_back(*dropped);
                expects_gain_ |= k == 0;
            }
            if (batch.size() == before) add(batch, along(exploring_radius * radius_), region_.radius);
            if (batch.size() > before) models.believe(batch.back().z);
            if (is_last) keep_distance(batch);
        }
        region_.margin = margin;
    }

    /// Of the means. @param drops_little what gains less than one more slope promises is returned, not added
    std::optional<Proposal> add_minimum(std::vector<Proposal>& batch, const LocalModels& models, int k,
                                        bool drops_little) {
        region_.radius = radius_ * radius_of_minimum(k);
        const std::size_t before = batch.size();
        add(batch, minimum_.of(models, 0, region_.centre), region_.radius);
        if (!drops_little || batch.size() == before) return {};
        if (merit(centre().values) - merit(batch.back().expected) >= unknown_decrease()) return {};
        const Proposal dropped = batch.back();
        batch.pop_back();
        return dropped;
    }
    double unknown_decrease() const { return strake::unknown_decrease((*models_)[0], centre().z, untried_.radius()); }

    /// By the lower confidence bound; where the last batch has gained too little, only along what was not tried.
    /// @param tried null: all directions have been
    void look_around(std::vector<Proposal>& batch, const LocalModels& models, const TriedDirections* tried) {
        region_.radius = radius_ * exploring_radius;
        const VectorXd to = tried ? tried->first_beyond(directions_) : next_direction();
        const VectorXd from = region_.centre + 0.5 * region_.radius * to;
        const double factor = tried ? shortfall((*models_)[0], centre().z, untried_.radius()) : 1;
        const std::size_t before = batch.size();
        add(batch, minimum_.of(models, factor * confidence, from), region_.radius);
        if (!tried) return;
        const bool is_new = batch.size() > before && (gained_ >= unknown_decrease() ||
                                                      tried->share_beyond(batch.back().z - centre().z) >= new_share);
        if (is_new) return;
        if (batch.size() > before) batch.pop_back();
        add(batch, along_untried(untried_.length() * to), std::abs(untried_.length()));
        if (batch.size() == before) untried_.leave(to);
    }
    /// A step, or the same the other way where bounds leave more of that.
    VectorXd along_untried(const VectorXd& step) {
        const VectorXd ahead = along_step(step, step.norm());
        const auto left = [&](const VectorXd& x) { return (points_.whitened(x) - centre().z).norm(); };
        if (guard_.cause != StopCause::none || left(ahead) > kept_length * step.norm()) return ahead;
        const VectorXd back = along_step(-step, step.norm());
        return left(back) > left(ahead) ? back : ahead;
    }

    /// Null: there is nothing left to try, or too much.
    std::unique_ptr<TriedDirections> tried_before_all(const std::vector<Proposal>& batch) {
        const bool can_try_all = points_.size() + left() > points_.dimensions();
        if (guard_.options.stays_where_models_are_sure || !can_try_all) return nullptr;
        std::vector<VectorXd> more;
        for (const Proposal& p : batch) more.push_back(p.z);
        return untried_.tried(points_, centre().z, more);
    }

    /// Nothing comes after this batch to go back from a constraint that is missed by a little: one point after another
    /// keeps farther from what only models tell.
    void keep_distance(const std::vector<Proposal>& batch) {
        if (batch.empty()) return;
        for (Eigen::Index i = 0; i < program().num_inequalities; ++i) {
            if (known().has(i)) continue;
            const double deviation = std::sqrt((*models_)[i + 1].variance(batch[0].z));
            region_.margin[i] += std::max(deviation, guard_.options.constraint_tolerance);
        }
    }

    /// Then it is a failure that costs nothing.
    bool has_no_shape(const AllowedDesigns::Shape& there) {
        if (!there.is_shortened || guard_.options.pays_without_shape || !guard_.is_refused(there.x)) return false;
        Evaluation at;
        at.failure = guard_.failure;
        points_.add(there.x, at);
        ++without_shape_, ++refused_;
        return true;
    }

    /// Where it is evaluated, unless that is known.
    void add(std::vector<Proposal>& batch, const VectorXd& wanted, double radius) {
        const AllowedDesigns::Shape there = allowed_.within(points_, wanted);
        if (guard_.cause != StopCause::none || has_no_shape(there)) return;
        Proposal p{there.x, points_.whitened(there.x), radius, {}};
        const double least = min_distance * radius_;
        if (points_.knows(p.z, least)) return;
        if (std::ranges::any_of(batch, [&](const Proposal& q) { return (q.z - p.z).norm() <= least; })) return;
        if (models_) p.expected = minimum_.expected(*models_, there.x);
        batch.push_back(std::move(p));
    }

    /// The models expect nothing more, or there is nothing left to ask.
    bool ends_here(const std::vector<Proposal>& batch) {
        if (guard_.cause != StopCause::none) return end_by_guard();
        if (left() <= 0) {
            guard_.cause = StopCause::evaluations;
            return end_by_guard();
        }
        if (radius_ < min_radius * guard_.options.first_step)
            return failing_ > 0 ? end(MinimizeStop::no_valid_step,
                                      text("evaluations fail however short the step (", guard_.failure, ")"))
                                : end(MinimizeStop::converged, "the radius of the trust region is below the tolerance");
        if (batch.empty()) {
            radius_ *= 0.5;
            if (refused_ > 0) failing_ = std::max(failing_, 1);
            return true;
        }
        if (!models_ || batch[0].restores || !expects_gain_) return false;
        const double expected = merit(centre().values) - merit(batch[0].expected);
        const double floor = std::max(guard_.decrease_tolerance(centre().values[0]), 0.1 * (*models_)[0].noise());
        const bool knows_enough = points_.size() > points_.dimensions() + 1;
        idle_ = expected > floor || !knows_enough ? 0 : idle_ + 1;
        if (idle_ <= idle_steps) return false;
        if (leads_back()) return true;
        if (region_.cut) return ends_at_border();
        return end(MinimizeStop::converged, "the models expect a decrease below the tolerance");
    }

    /// Nothing is expected on this side of the border. It may have been learned from bad luck.
    bool ends_at_border() {
        if (++forgotten_borders_ > max_forgotten_borders)
            return end(
                MinimizeStop::no_valid_step,
                text("evaluations fail beyond a border, and the models expect nothing before it; the last failure: ",
                     guard_.failure));
        guard_.report_event("nothing is expected on this side of the border of failures, which is learned anew");
        guard_.border = {};
        idle_ = 0;
        return true;
    }

    void evaluate(const std::vector<Proposal>& batch) {
        std::vector<VectorXd> designs;
        for (const Proposal& p : batch) designs.push_back(p.x);
        guard_.expect(designs);
        const double before = merit(is_noisy() ? without_noise(centre()) : centre().values);
        double best = before, length = 0;
        int failed = 0;
        bool stops = false;  // a batch is evaluated whole
        for (const Proposal& p : batch) {
            Evaluation at;
            bool has_values = guard_.try_at(p.x, false, at);
            if (guard_.cause == StopCause::stopped) {
                stops = true;
                guard_.cause = StopCause::none;
                has_values = guard_.try_at(p.x, false, at);  // known by now
            }
            if (has_values) {
                points_.add(p.x, at);
                if (p.expected.size() > 0) learn_margin(p, at);
                if (const double m = merit(values_of(at)); m < best) best = m, length = (p.z - region_.centre).norm();
            } else if (guard_.cause == StopCause::failure) {
                at.failure = guard_.failure;
                points_.add(p.x, at);
                ++failed;
            } else {
                end_by_guard();
                return;
            }
            guard_.cause = StopCause::none;
        }
        if (stops) {
            guard_.cause = StopCause::stopped;
            end_by_guard();
            return;
        }
        failing_ = 2 * failed > static_cast<int>(batch.size()) && best == before ? failing_ + 1 : 0;
        untried_.learn(failing_ > 0, !expects_gain_);
        gained_ = before - best;
        if (models_ && !batch[0].restores) resize(before - best, before - merit(batch[0].expected), length);
        if (failing_ > guard_.options.max_shrinks)
            end(MinimizeStop::no_valid_step, text("evaluations fail however short the step (", guard_.failure, ")"));
    }

    /// Constraints that turn out larger than expected keep a distance that shrinks with what they err by.
    void learn_margin(const Proposal& p, const Evaluation& at) {
        if (p.radius > radius_) return;
        for (int i = 0; i < program().num_inequalities; ++i) {
            if (known().has(i) && !guard_.options.limits_by_models) continue;
            const double error = std::max(0.0, at.constraints[i] - p.expected[i + 1]);
            const double near = std::abs(p.expected[i + 1]) < 2 * error ? error : 0;
            region_.margin[i] = 0.7 * region_.margin[i] + 0.15 * near;
        }
    }

    void resize(double gained, double expected, double length) {
        const double largest = max_radius * guard_.options.first_step;
        const bool has_looked = !expects_gain_ && failing_ == 0;  // only slopes were asked for
        if (gained <= 0)
            radius_ *= has_looked ? 1 : 0.5, ++end_.shrinks;  // waves are told by the batches that gain nothing
        else if (length > 1.2 * radius_)
            radius_ = std::min(2 * radius_, largest);
        else if (length > 0.8 * radius_ && gained > 0.5 * expected)
            radius_ = std::min(1.4 * radius_, largest);
        else if (gained < 0.1 * expected)
            radius_ = std::max(0.5 * radius_, length);
    }

    bool end_by_guard() {
        const GuardEnd found = guard_.end_by_cause();
        return end(found.stop, found.reason);
    }
    bool end(MinimizeStop stop, const std::string& reason) {
        end_.stop = stop, end_.reason = reason;
        return has_ended_ = true;
    }

    Guard& guard_;
    SampledPoints points_;
    double radius_, penalty_ = 0;  ///< the radius in z
    UntriedSteps untried_;
    double gained_ = 0;  ///< by the last batch
    ProposalRegion region_;
    AllowedDesigns allowed_;  ///< from where the search stands
    VectorXd nearest_;        ///< z next to that, within exact limits
    AllowedMinimum minimum_;
    Pace pace_;
    MatrixXd directions_;
    Eigen::Index used_directions_ = 0;
    bool expects_gain_ = true;  ///< the first of a batch is a minimum of the models' means
    std::unique_ptr<LocalModels> models_;
    int centre_ = 0, idle_ = 0, failing_ = 0, forgotten_borders_ = 0;
    bool restores_equations_ = false, restores_limits_ = false;  ///< leads back to them
    int restored_at_ = 0, final_restorations_ = 0, without_shape_ = 0, refused_ = 0;
    ModelEnd end_;
    bool has_ended_ = false;
};

}  // namespace

ModelEnd minimize_by_model(Guard& guard) { return ModelSearch(guard).run(); }

}  // namespace strake
