#include "optimize/nlp/surrogate/gaussian_process.hpp"

#include "core/error.hpp"
#include "optimize/nlp/surrogate/likelihood.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double points_per_term = 2;
constexpr double round_off = 1e-13;  ///< of the values: what the trend leaves of them is nothing

constexpr double beyond_rounding = 1e-7;  ///< its square is near that of a double

/// The weights of a trend's terms, by L of their normal equations.
bool are_told_apart(const Eigen::LLT<MatrixXd>& normal, double than) {
    const auto diagonal = normal.matrixLLT().diagonal();
    return normal.info() == Eigen::Success && diagonal.minCoeff() > than * diagonal.maxCoeff();
}

Eigen::Index terms_of(Trend trend, Eigen::Index d) {
    return trend == Trend::constant ? 1 : trend == Trend::linear ? 1 + d : 1 + d + d * (d + 1) / 2;
}

}  // namespace

GaussianProcess::GaussianProcess(MatrixXd points, VectorXd values, const GaussianProcessOptions& options,
                                 const Kernel* start)
    : points_(std::move(points)),
      values_(std::move(values)),
      trend_(options.trend),
      square_about_(options.square_about),
      form_(options.square_about.size() > 0 ? options.square_form : MatrixXd()) {
    std::vector<int> group = options.group;
    if (group.empty())
        for (Eigen::Index j = 0; j < points_.cols(); ++j) group.push_back(static_cast<int>(j));
    check(group);
    if (has_form() && (form_.rows() != points_.cols() || form_.cols() != points_.cols() || !form_.allFinite()))
        throw InvalidInput(text("Gaussian process: square_form is ", form_.rows(), " x ", form_.cols(), " for ",
                                points_.cols(), " coordinates, or not finite"));
    if (!(options.min_nugget > 0 && options.min_nugget < 1))
        throw InvalidInput(text("min_nugget = ", options.min_nugget, " must be in (0, 1)"));
    if (!(options.min_length >= 0 && options.min_length <= Likelihood::usual_length))
        throw InvalidInput(
            text("min_length = ", options.min_length, " must be in [0, ", Likelihood::usual_length, "]"));
    choose_trend();
    const Likelihood likelihood(points_, values_, H_, group, options);
    kernel_ = likelihood.kernel(likelihood.usual());
    fit();
    if (std_ == 0 || points_.rows() - H_.cols() < 2) return;  // nothing tells one kernel from another
    kernel_ = likelihood.best(start);
    fit();
}

GaussianProcess GaussianProcess::with_points(MatrixXd points, VectorXd values) const {
    GaussianProcess other = *this;
    other.points_ = std::move(points);
    other.values_ = std::move(values);
    other.check(std::vector<int>(static_cast<std::size_t>(points_.cols()), 0));
    other.evaluate_terms();
    other.fit();
    return other;
}

void GaussianProcess::check(const std::vector<int>& group) const {
    if (points_.rows() < 1 || points_.cols() < 1 || values_.size() != points_.rows())
        throw InvalidInput(text("Gaussian process: ", values_.size(), " values for ", points_.rows(), " points of ",
                                points_.cols(), " coordinates"));
    if (!points_.allFinite() || !values_.allFinite())
        throw InvalidInput("Gaussian process: a coordinate or a value is not finite");
    if (group.size() != static_cast<std::size_t>(points_.cols()))
        throw InvalidInput(text("Gaussian process: ", group.size(), " groups for ", points_.cols(), " coordinates"));
    for (int g = 0; g <= *std::max_element(group.begin(), group.end()); ++g)
        if (std::find(group.begin(), group.end(), g) == group.end())
            throw InvalidInput(text("Gaussian process: group ", g, " has no coordinate"));
}

void GaussianProcess::choose_trend() {
    const Eigen::Index n = points_.rows(), d = points_.cols();
    const auto can_tell = [&](Eigen::Index terms) {
        return static_cast<double>(n) >= points_per_term * static_cast<double>(terms);
    };
    while (trend_ != Trend::constant && !can_tell(terms_of(trend_, d) + has_square()))
        trend_ = trend_ == Trend::quadratic ? Trend::linear : Trend::constant;
    if (trend_ == Trend::quadratic || !can_tell(terms_of(trend_, d) + 1)) square_about_.resize(0);
    if (!has_square() || !can_tell(terms_of(trend_, d) + 2)) form_.resize(0, 0);
    centre_ = points_.colwise().mean();
    unit_ = (points_.rowwise() - centre_.transpose()).cwiseAbs().colwise().maxCoeff();
    for (double& u : unit_)
        if (!(u > 0)) u = 1;
    if (has_square()) square_unit_ = (points_.rowwise() - square_about_.transpose()).rowwise().norm().maxCoeff();
    if (!(square_unit_ > 0)) {
        square_about_.resize(0);
        form_.resize(0, 0);
    }
    H_.resize(n, terms_of(trend_, d) + num_squares());
    evaluate_terms();
    // Terms that these points cannot tell apart have no weights of their own.
    if (are_told_apart(Eigen::LLT<MatrixXd>(H_.transpose() * H_), 1e-6)) return;
    if (has_form()) {
        leave_out_form();
        if (are_told_apart(Eigen::LLT<MatrixXd>(H_.transpose() * H_), 1e-6)) return;
    }
    keep_constant_trend();
}

void GaussianProcess::evaluate_terms() {
    H_.resize(points_.rows(), H_.cols());
    for (Eigen::Index i = 0; i < points_.rows(); ++i) H_.row(i) = terms(points_.row(i));
}

void GaussianProcess::leave_out_form() {
    form_.resize(0, 0);
    H_.conservativeResize(Eigen::NoChange, H_.cols() - 1);
}

void GaussianProcess::keep_constant_trend() {
    trend_ = Trend::constant;
    square_about_.resize(0);
    form_.resize(0, 0);
    H_ = VectorXd::Ones(points_.rows());
}

VectorXd GaussianProcess::terms(const VectorXd& x) const {
    const Eigen::Index d = x.size();
    VectorXd h(terms_of(trend_, d) + num_squares());
    h[0] = 1;
    const Eigen::Index first = h.size() - num_squares();
    const double unit = square_unit_ * square_unit_;
    if (has_square()) h[first] = (x - square_about_).squaredNorm() / unit;
    if (has_form()) h[first + 1] = (x - square_about_).dot(form_ * (x - square_about_)) / unit;
    if (trend_ == Trend::constant) return h;
    const VectorXd z = (x - centre_).cwiseQuotient(unit_);
    h.segment(1, d) = z;
    Eigen::Index t = 1 + d;
    for (Eigen::Index j = 0; j < d && trend_ == Trend::quadratic; ++j)
        for (Eigen::Index k = j; k < d; ++k) h[t++] = z[j] * z[k];
    return h;
}

MatrixXd GaussianProcess::term_slopes(const VectorXd& x) const {
    const Eigen::Index d = x.size();
    MatrixXd slopes = MatrixXd::Zero(H_.cols(), d);
    const double twice = 2 / (square_unit_ * square_unit_);
    if (has_square()) slopes.row(first_square()) = twice * (x - square_about_).transpose();
    if (has_form()) slopes.row(first_square() + 1) = twice * (form_ * (x - square_about_)).transpose();
    if (trend_ == Trend::constant) return slopes;
    const VectorXd z = (x - centre_).cwiseQuotient(unit_);
    slopes.middleRows(1, d) = unit_.cwiseInverse().asDiagonal();
    Eigen::Index t = 1 + d;
    for (Eigen::Index j = 0; j < d && trend_ == Trend::quadratic; ++j)
        for (Eigen::Index k = j; k < d; ++k, ++t) {
            slopes(t, j) += z[k] / unit_[j];
            slopes(t, k) += z[j] / unit_[k];
        }
    return slopes;
}

void GaussianProcess::fit() {
    const Eigen::Index n = points_.rows(), p = H_.cols();
    MatrixXd C = correlations(points_, kernel_);
    for (C_.compute(C); C_.info() != Eigen::Success; C_.compute(C)) {  // round-off beyond the smallest nugget
        C.diagonal().array() += 9 * kernel_.nugget;
        kernel_.nugget *= 10;
    }
    CH_ = C_.solve(H_);
    HCH_.compute(H_.transpose() * CH_);
    beta_ = HCH_.solve(CH_.transpose() * values_);
    // Points next to one another leave nothing of the trend but rounding: a constant is what they tell.
    if (has_form() && !are_told_apart(HCH_, beyond_rounding)) {
        leave_out_form();
        return fit();
    }
    if (trend_ != Trend::constant && !are_told_apart(HCH_, beyond_rounding)) {
        keep_constant_trend();
        return fit();
    }
    const VectorXd rest = values_ - H_ * beta_;
    alpha_ = C_.solve(rest);
    const double size = values_.lpNorm<Eigen::Infinity>();
    std_ = 0;
    if (rest.lpNorm<Eigen::Infinity>() <= round_off * size || n <= p)
        alpha_.setZero();
    else
        std_ = std::sqrt(std::max(0.0, rest.dot(alpha_)) / static_cast<double>(n - p));
}

double GaussianProcess::noise() const { return std_ * std::sqrt(kernel_.nugget); }

VectorXd GaussianProcess::kernel_to(const VectorXd& x) const {
    const MatrixXd off = (points_.rowwise() - x.transpose()) * kernel_.length.cwiseInverse().asDiagonal();
    return (-0.5 * off.rowwise().squaredNorm()).array().exp();
}

double GaussianProcess::mean(const VectorXd& x) const { return terms(x).dot(beta_) + kernel_to(x).dot(alpha_); }

VectorXd GaussianProcess::gradient(const VectorXd& x) const {
    const VectorXd w = kernel_to(x).cwiseProduct(alpha_);
    const VectorXd pull = points_.transpose() * w - w.sum() * x;
    return term_slopes(x).transpose() * beta_ + pull.cwiseQuotient(kernel_.length.cwiseAbs2());
}

MatrixXd GaussianProcess::hessian(const VectorXd& x) const {
    const Eigen::Index d = x.size();
    const VectorXd w = kernel_to(x).cwiseProduct(alpha_), inverse = kernel_.length.cwiseAbs2().cwiseInverse();
    const MatrixXd off = (points_.rowwise() - x.transpose()) * inverse.asDiagonal();
    MatrixXd H = off.transpose() * w.asDiagonal() * off;
    H.diagonal() -= w.sum() * inverse;
    const double twice = 2 / (square_unit_ * square_unit_);
    if (has_square()) H.diagonal().array() += twice * beta_[first_square()];
    if (has_form()) H += twice * beta_[first_square() + 1] * form_;
    Eigen::Index t = 1 + d;
    for (Eigen::Index j = 0; j < d && trend_ == Trend::quadratic; ++j)
        for (Eigen::Index k = j; k < d; ++k, ++t) {
            H(j, k) += beta_[t] / (unit_[j] * unit_[k]);
            H(k, j) += beta_[t] / (unit_[j] * unit_[k]);
        }
    return H;
}

double GaussianProcess::variance(const VectorXd& x) const {
    const VectorXd k = kernel_to(x), u = terms(x) - CH_.transpose() * k;
    return std_ * std_ * std::max(0.0, 1 - k.dot(C_.solve(k)) + u.dot(HCH_.solve(u)));
}

VectorXd GaussianProcess::variance_gradient(const VectorXd& x) const {
    const VectorXd k = kernel_to(x), u = terms(x) - CH_.transpose() * k;
    const VectorXd Ck = C_.solve(k), b = HCH_.solve(u);
    // d(variance)/dk = -2 C^-1 k - 2 C^-1 H b, and by the terms 2 b.
    const VectorXd w = k.cwiseProduct(-2 * (Ck + CH_ * b));
    const VectorXd pull = (points_.transpose() * w - w.sum() * x).cwiseQuotient(kernel_.length.cwiseAbs2());
    return std_ * std_ * (pull + 2 * term_slopes(x).transpose() * b);
}

MatrixXd GaussianProcess::projected_inverse() const {
    const Eigen::Index n = points_.rows();
    return C_.solve(MatrixXd::Identity(n, n)) - CH_ * HCH_.solve(CH_.transpose());
}

GaussianProcess::LeaveOneOut GaussianProcess::leave_one_out() const {
    const MatrixXd P = projected_inverse();
    const VectorXd Py = P * values_;
    LeaveOneOut left{VectorXd::Zero(values_.size()), VectorXd::Zero(values_.size())};
    for (Eigen::Index i = 0; i < values_.size(); ++i) {
        if (!(P(i, i) > round_off * P.diagonal().maxCoeff())) continue;
        left.error[i] = Py[i] / P(i, i);
        left.deviation[i] = std_ / std::sqrt(P(i, i));
    }
    return left;
}

double GaussianProcess::predicted_share() const {
    const double all = (values_.array() - values_.mean()).matrix().squaredNorm();
    return all > 0 ? 1 - leave_one_out().error.squaredNorm() / all : 1;
}

void GaussianProcess::check_is_sum() const {
    if (has_form()) throw InvalidInput("Gaussian process: a square_form is no sum of products of single coordinates");
}

VectorXd GaussianProcess::weights() const {
    check_is_sum();
    const Eigen::Index terms = beta_.size() - has_square(), parts = square_about_.size();
    VectorXd w(terms + parts + alpha_.size());
    w << beta_.head(terms), VectorXd::Constant(parts, has_square() ? beta_[terms] : 0), alpha_;
    return w;
}

VectorXd GaussianProcess::factors(int coordinate, double x) const {
    check_is_sum();
    const Eigen::Index d = points_.cols(), c = coordinate;
    const Eigen::Index terms = beta_.size() - has_square();
    VectorXd f = VectorXd::Ones(terms + square_about_.size() + alpha_.size());
    if (has_square()) {
        const double off = (x - square_about_[c]) / square_unit_;
        f[terms + c] = off * off;
    }
    const double z = (x - centre_[c]) / unit_[c];
    if (trend_ != Trend::constant) f[1 + c] = z;
    Eigen::Index t = 1 + d;
    for (Eigen::Index j = 0; j < d && trend_ == Trend::quadratic; ++j)
        for (Eigen::Index k = j; k < d; ++k, ++t) f[t] = (j == c ? z : 1) * (k == c ? z : 1);
    f.tail(alpha_.size()) = (-0.5 * ((points_.col(c).array() - x) / kernel_.length[c]).square()).exp();
    return f;
}

}  // namespace strake
