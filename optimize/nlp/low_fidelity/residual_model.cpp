#include "optimize/nlp/low_fidelity/residual_model.hpp"

#include "core/error.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace strake {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array ratios = {0.03, 0.1, 0.3, 1.0, 3.0, 10.0};  ///< of the residual's slope to that of the cheap one
constexpr double expected_ratio = 0.3;
constexpr double spread_of_ratio = 1.5;  ///< standard deviation of its natural logarithm
constexpr double slope_noise = 1e-3;     ///< of sigma: what differences are exact to
constexpr double third_order = 0.5;      ///< of sigma: what Q leaves of a slope at a distance of 1
constexpr double rounding = 1e-9;        ///< of the spread of values
constexpr Index max_data = 400;          ///< the nearest ones are used

}  // namespace

ResidualModel::ResidualModel(const MatrixXd& metric, std::vector<LowFidelityValue> kinds, VectorXd first_scale)
    : root_(Eigen::LLT<MatrixXd>(metric).matrixU()), kinds_(std::move(kinds)), first_scale_(std::move(first_scale)) {
    const auto values = static_cast<Index>(kinds_.size());
    if (first_scale_.size() != values)
        throw InvalidInput(text("residual model: ", first_scale_.size(), " scales for ", values, " values"));
    largest_low_slope_ = VectorXd::Zero(values);
    rho_ = first_scale_;
    deviation_ = share_ = VectorXd::Zero(values);
    slopes_ = MatrixXd::Zero(metric.rows(), values);
    hessians_.assign(kinds_.size(), MatrixXd::Zero(metric.rows(), metric.rows()));
    covariances_ = hessians_;
}

void ResidualModel::add_point(const VectorXd& x, const VectorXd& values, const VectorXd& low) {
    const VectorXd z = root_ * x;
    const auto is_same = [&](const Point& p) { return p.z == z; };
    if (std::none_of(points_.begin(), points_.end(), is_same)) points_.push_back({z, values, low});
}

void ResidualModel::add_slopes(const VectorXd& x, const MatrixXd& directions, const MatrixXd& slopes,
                               const MatrixXd& low_slopes) {
    slopes_known_.push_back({root_ * x, root_ * directions, slopes, low_slopes});
}

ResidualModel::Data ResidualModel::data_about(const VectorXd& z) const {
    struct Place {
        double reach;
        const Point* point;
        const Slopes* slopes;
        Index column;
    };
    std::vector<Place> places;
    const Point* here = nullptr;
    for (const Point& point : points_)
        if (const double reach = (point.z - z).norm(); reach > 0)
            places.push_back({reach, &point, nullptr, 0});
        else
            here = &point;
    if (!here) throw InvalidInput("residual model: fitted about a point that was not added");
    for (const Slopes& s : slopes_known_)
        for (Index k = 0; k < s.directions.cols(); ++k) places.push_back({(s.z - z).norm(), nullptr, &s, k});
    std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.reach < b.reach; });
    const Index count = std::min<Index>(static_cast<Index>(places.size()), max_data);
    Data data;
    data.a.resize(z.size(), count);
    data.p = data.v = data.a;
    data.high.resize(count, static_cast<Index>(kinds_.size()));
    data.low = data.high;
    data.reach.resize(count);
    data.unknown.resize(count);
    for (Index j = 0; j < count; ++j) {
        const Place& place = places[static_cast<std::size_t>(j)];
        data.reach[j] = place.reach;
        data.unknown[j] = third_order * place.reach * place.reach * (place.point ? 0.5 : 1);
        if (place.point) {
            const VectorXd d = place.point->z - z;
            data.a.col(j) = d / place.reach;
            data.p.col(j) = d;
            data.v.col(j) = data.a.col(j) / 2;
            data.high.row(j) = (place.point->values - here->values).transpose() / place.reach;
            data.low.row(j) = (place.point->low - here->low).transpose() / place.reach;
        } else {
            data.a.col(j) = place.slopes->directions.col(place.column);
            data.p.col(j) = place.slopes->z - z;
            data.v.col(j) = data.a.col(j);
            data.high.row(j) = place.slopes->slopes.row(place.column);
            data.low.row(j) = place.slopes->low.row(place.column);
        }
    }
    return data;
}

void ResidualModel::fit(const VectorXd& x, const MatrixXd& low_gradients) {
    low_gradients_ = root_.transpose().triangularView<Eigen::Lower>().solve(low_gradients);
    const Data data = data_about(root_ * x);
    // Of s.a and <Q, p v^T + v p^T> / 2 where sigma is 1.
    const MatrixXd vv = data.v.transpose() * data.v, pp = data.p.transpose() * data.p, vp = data.v.transpose() * data.p;
    MatrixXd kernel = data.a.transpose() * data.a + vv.cwiseProduct(pp) + vp.cwiseProduct(MatrixXd(vp.transpose()));
    kernel.diagonal().array() += slope_noise * slope_noise + data.unknown.array().square();
    for (Index i = 0; i < static_cast<Index>(kinds_.size()); ++i) fit_value(i, data, kernel);
}

void ResidualModel::fit_value(Index i, const Data& data, const MatrixXd& kernel) {
    const auto at = static_cast<std::size_t>(i);
    const Index n = root_.rows(), count = data.reach.size();
    slopes_.col(i).setZero();
    hessians_[at].setZero();
    covariances_[at].setZero();
    rho_[i] = kinds_[at] == LowFidelityValue::same ? 1 : first_scale_[i];
    share_[i] = 1;
    if (kinds_[at] == LowFidelityValue::same) return;
    const bool has_low = kinds_[at] == LowFidelityValue::approximate;
    const VectorXd low_slope = has_low ? VectorXd(low_gradients_.col(i)) : VectorXd::Zero(n);
    largest_low_slope_[i] = std::max(largest_low_slope_[i], std::abs(first_scale_[i]) * low_slope.norm());
    double scale = largest_low_slope_[i];
    if (!(scale > 0) && count > 0) scale = std::sqrt(double(n) * data.high.col(i).squaredNorm() / double(count));
    deviation_[i] = scale;
    share_[i] = 0;
    if (!(scale > 0)) return;
    const double rho_deviation = has_low ? std::abs(first_scale_[i]) : 0;
    const VectorXd low = has_low ? VectorXd(data.low.col(i)) : VectorXd::Zero(count);
    const VectorXd y = data.high.col(i) - first_scale_[i] * low;
    double spread = 0;
    for (const Point& point : points_) spread = std::max(spread, std::abs(point.values[i] - points_[0].values[i]));
    double best = -std::numeric_limits<double>::infinity();
    Eigen::LLT<MatrixXd> chosen;
    VectorXd alpha;
    double sigma = expected_ratio * scale / std::sqrt(double(n));
    for (const double ratio : ratios) {
        const double trial = ratio * scale / std::sqrt(double(n));
        MatrixXd K = trial * trial * kernel + rho_deviation * rho_deviation * low * low.transpose();
        for (Index j = 0; j < count; ++j)
            if (data.reach[j] > 0) K(j, j) += std::pow(rounding * spread / data.reach[j], 2);
        const Eigen::LLT<MatrixXd> llt(K);
        if (llt.info() != Eigen::Success) continue;
        const VectorXd weights = llt.solve(y);
        const double log_ratio = std::log(ratio / expected_ratio) / spread_of_ratio;
        const double evidence = -0.5 * y.dot(weights) - MatrixXd(llt.matrixL()).diagonal().array().log().sum() -
                                0.5 * log_ratio * log_ratio;
        if (!(evidence > best)) continue;
        best = evidence, chosen = llt, alpha = weights, sigma = trial;
    }
    deviation_[i] = sigma;
    MatrixXd covariance =
        sigma * sigma * MatrixXd::Identity(n, n) + rho_deviation * rho_deviation * low_slope * low_slope.transpose();
    if (std::isfinite(best) && count > 0) {
        rho_[i] += rho_deviation * rho_deviation * low.dot(alpha);
        slopes_.col(i) = root_.transpose() * (sigma * sigma * (data.a * alpha));
        const MatrixXd pv = data.p * alpha.asDiagonal() * data.v.transpose();
        hessians_[at] = root_.transpose() * (sigma * sigma * (pv + pv.transpose())) * root_;
        const MatrixXd cross = sigma * sigma * data.a + rho_deviation * rho_deviation * low_slope * low.transpose();
        covariance -= cross * chosen.solve(cross.transpose());
    }
    covariances_[at] = 0.5 * (covariance + covariance.transpose());
    const double told = has_low ? std::abs(rho_[i] / first_scale_[i]) * largest_low_slope_[i] : 0;
    share_[i] = told / (told + sigma * std::sqrt(double(n)));
}

MatrixXd ResidualModel::gradients() const { return root_.transpose() * low_gradients_ * rho_.asDiagonal() + slopes_; }

MatrixXd ResidualModel::covariance(const VectorXd& weights) const {
    MatrixXd sum = MatrixXd::Zero(root_.rows(), root_.rows());
    for (Index i = 0; i < weights.size(); ++i)
        sum += weights[i] * weights[i] * covariances_[static_cast<std::size_t>(i)];
    return sum;
}

}  // namespace strake
