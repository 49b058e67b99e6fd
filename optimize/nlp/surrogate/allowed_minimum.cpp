#include "optimize/nlp/surrogate/allowed_minimum.hpp"

#include "optimize/nlp/model/quadratic_model.hpp"

#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double held_limit = 1e-6;  ///< a model's constraint that is nearer to its limit holds the minimum
constexpr int exact_rounds = 4;      ///< towards what is known exactly
constexpr int limit_rounds = 3;      ///< of these, that learn more of the limit of motion, as those of sqp

}  // namespace

VectorXd AllowedMinimum::of(const LocalModels& models, double deviations, const VectorXd& from) {
    region_.offset.setZero();
    region_.tilt.resize(0, 0);
    const VectorXd x = points_.variables(corrected(models, deviations, from));
    const bool explores = deviations > 0;
    if (explores || !allowed_.knows_slopes() || guard_.cause != StopCause::none) return x;
    const VectorXd by_models = projected(x);
    align(models);
    const VectorXd by_slopes = projected(points_.variables(corrected(models, deviations, from)));
    if (guard_.cause != StopCause::none) return by_models;
    return promise(models, by_slopes) < promise(models, by_models) ? by_slopes : by_models;
}

/// What is known exactly has its value and slope at the centre.
void AllowedMinimum::align(const LocalModels& models) {
    region_.offset.setZero();
    region_.tilt.setZero(region_.offset.size(), points_.dimensions());
    for (const Eigen::Index i : known().rows()) {
        const GaussianProcess& model = models[i + 1];
        region_.offset[i] = allowed_.here()->constraints[i] - model.mean(region_.centre);
        const VectorXd slope = points_.gradient_by_z(allowed_.here()->jacobian.row(i));
        region_.tilt.row(i) = (slope - model.gradient(region_.centre)).transpose();
    }
}

/// The least of the models, corrected until it meets what is known exactly.
VectorXd AllowedMinimum::corrected(const LocalModels& models, double deviations, const VectorXd& from) {
    region_.limits = {};
    VectorXd z = model_minimum(program(), points_, models, region_, deviations, from);
    for (int round = 0; round < exact_rounds; ++round) {
        // What looks around meets the motion limit as it may: for learning.
        const bool is_beyond = deviations == 0 && round < limit_rounds && limit_step_to(z);
        if (!has_corrected(models, z) && !is_beyond) break;
        z = model_minimum(program(), points_, models, region_, deviations, z);
    }
    return z;
}

/// Makes the offsets such that the models tell what is known exactly at z. False: there it is met, or not known.
bool AllowedMinimum::has_corrected(const LocalModels& models, const VectorXd& z) {
    if (known().rows().empty() || guard_.cause != StopCause::none) return false;
    const VectorXd x = guard_.inside(points_.variables(z)), there = points_.whitened(x);
    if (guard_.cause != StopCause::none) return false;
    const auto found = known().at(x, false);
    if (!found) return false;
    double missed = 0;
    for (const Eigen::Index i : known().rows()) {
        const double c = found->constraints[i];
        const double expected = models[i + 1].mean(there) + region_.correction(i, there);
        // What the models hold back from a limit that is farther is missed, too.
        const bool has_room = i < program().num_inequalities && c < 0 &&
                              (guard_.options.learns_as_before || expected + region_.margin[i] < -held_limit);
        missed = std::max(missed, has_room ? 0.0 : std::abs(c));
        region_.offset[i] += c - expected;
    }
    return missed > known().tolerance();
}

/// Conditions on the step to z, which leads beyond the limit of motion: what is moved back from there by the metric
/// alone has lost more.
bool AllowedMinimum::limit_step_to(const VectorXd& z) {
    StepLimits more;
    if (allowed_.has_turns() || !allowed_.limit_step_to(points_.variables(z), more)) return false;
    MatrixXd slopes(more.slopes.rows(), points_.dimensions());
    for (Eigen::Index i = 0; i < slopes.rows(); ++i)
        slopes.row(i) = points_.gradient_by_z(more.slopes.row(i)).transpose();
    append(region_.limits, {more.values, slopes});
    return true;
}

/// The design next to x that is allowed, where it would be evaluated; x where that leads out of the region or
/// beyond the border of failures.
VectorXd AllowedMinimum::projected(const VectorXd& asked) {
    const VectorXd there = guard_.inside(asked);
    const VectorXd x = allowed_.has_turns() ? allowed_.nearest_by_turns(asked) : allowed_.nearest(asked);
    const double length = (points_.whitened(x) - region_.centre).norm();
    return length > ProposalRegion::reach * region_.radius || region_.is_beyond_border(x) ? there : x;
}

/// With what inequalities keep that only models tell.
double AllowedMinimum::promise(const LocalModels& models, const VectorXd& x) const {
    VectorXd values = expected(models, x);
    for (Eigen::Index i = 0; i < region_.margin.size(); ++i)
        if (!known().has(i)) values[i + 1] += region_.margin[i];
    return merit_(values);
}

VectorXd AllowedMinimum::expected(const LocalModels& models, const VectorXd& x) const {
    VectorXd values = models.means(points_.whitened(x));
    if (guard_.options.limits_by_models) return values;
    if (const auto found = known().at(x, false))
        for (const Eigen::Index i : known().rows()) values[i + 1] = found->constraints[i];
    return values;
}

}  // namespace strake
