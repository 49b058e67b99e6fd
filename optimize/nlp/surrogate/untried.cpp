#include "optimize/nlp/surrogate/untried.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double same_line = 0.05;  ///< of a unit step, beside those before: it tells nothing of another slope
constexpr double enough = 0.5;      ///< of a direction
constexpr double first_share = 0.5, second_share = 0.25;  ///< of the radius: steps, and those where such ones failed
constexpr double beyond_rounding = 1.01;                  ///< and what limits move
constexpr double prior_slopes = 6;   ///< that a radius counts for: with two the first ones decide, by chance
constexpr double same_point = 1e-9;  ///< in z: round-off of inherited designs

double mean_curvature(const GaussianProcess& model, const VectorXd& z) {
    return std::max(0.0, model.hessian(z).trace() / static_cast<double>(z.size()));
}

double own_slope(const GaussianProcess& model) { return model.scale() / model.kernel().length[0]; }

}  // namespace

TriedDirections::TriedDirections(const SampledPoints& points, const VectorXd& centre, const std::vector<VectorXd>& more,
                                 double reach) {
    std::vector<VectorXd> steps = points.steps(centre, reach);
    for (const VectorXd& z : more) steps.push_back(z - points[0].z);
    MatrixXd all(points.dimensions(), static_cast<Eigen::Index>(steps.size()));
    Eigen::Index n = 0;
    for (const VectorXd& step : steps)
        if (const double length = step.norm(); length > same_point) all.col(n++) = step / length;
    basis_.resize(points.dimensions(), 0);
    if (n == 0) return;
    Eigen::ColPivHouseholderQR<MatrixXd> span(all.leftCols(n));
    span.setThreshold(same_line);
    basis_ = span.householderQ() * MatrixXd::Identity(all.rows(), span.rank());
}

MatrixXd TriedDirections::beyond(const MatrixXd& steps) const { return steps - basis_ * (basis_.transpose() * steps); }

double TriedDirections::share_beyond(const VectorXd& step) const {
    return step.norm() > 0 ? beyond(step).norm() / step.norm() : 0;
}

VectorXd TriedDirections::first_beyond(const MatrixXd& directions) const {
    const MatrixXd rest = beyond(directions);
    Eigen::Index best = 0;
    rest.colwise().norm().maxCoeff(&best);
    for (Eigen::Index k = 0; k < rest.cols(); ++k)
        if (rest.col(k).norm() >= enough) {
            best = k;
            break;
        }
    return rest.col(best).normalized();
}

std::unique_ptr<TriedDirections> UntriedSteps::tried(const SampledPoints& points, const VectorXd& centre,
                                                     const std::vector<VectorXd>& more) {
    std::vector<VectorXd> all = more;
    for (const VectorXd& direction : left_) all.push_back(points[0].z + direction);
    for (const double share : {first_share, -second_share}) {
        auto tried =
            std::make_unique<TriedDirections>(points, centre, all, beyond_rounding * std::abs(share) * radius_);
        share_ = share;
        if (!tried->are_all()) return tried;
    }
    return nullptr;
}

void UntriedSteps::learn(bool has_failed, bool has_looked) {
    if (has_failed)
        radius_ *= 0.5;
    else if (has_looked)
        radius_ = std::min(2 * radius_, first_radius_);
}

double unknown_slope(const GaussianProcess& model, const VectorXd& z, double radius) {
    const double d = static_cast<double>(z.size()), by_radius = mean_curvature(model, z) * radius / std::sqrt(d);
    if (!(by_radius > 0)) return 0;
    const double known = std::min(static_cast<double>(model.points().rows() - 1), d);
    const double own = std::min(1.0, own_slope(model) / by_radius);
    return by_radius * std::sqrt((prior_slopes + known * own * own) / (prior_slopes + known));
}

double unknown_decrease(const GaussianProcess& model, const VectorXd& z, double radius) {
    const double slope = unknown_slope(model, z, radius);
    return slope > 0 ? 0.5 * slope * slope / mean_curvature(model, z) : 0;
}

double shortfall(const GaussianProcess& model, const VectorXd& z, double radius) {
    if (model.scale() == 0) return 1;
    return std::max(1.0, unknown_slope(model, z, radius) / own_slope(model));
}

}  // namespace strake
