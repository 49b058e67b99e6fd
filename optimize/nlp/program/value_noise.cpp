#include "optimize/nlp/program/value_noise.hpp"

#include <cmath>
#include <limits>

namespace strake {
namespace {

constexpr double max_length = 0.01;    ///< of a line
constexpr double min_distance = 0.05;  ///< of two points, as a share of the farther one's t: nearer ones are one point
constexpr std::size_t max_points = 5, min_points = 4;
constexpr std::size_t max_samples = 3;
constexpr double consistent =
    4;  ///< factor between differences of two orders: those of a smooth function differ by more

double noise_of(const std::vector<double>& t, const std::vector<double>& values) {
    const auto count = static_cast<Eigen::Index>(t.size());
    return noise_on_line(Eigen::Map<const Eigen::VectorXd>(t.data(), count),
                         Eigen::Map<const Eigen::VectorXd>(values.data(), count));
}

}  // namespace

double noise_on_line(const Eigen::VectorXd& t, const Eigen::VectorXd& values) {
    double difference = 0, squares = 0;
    for (Eigen::Index i = 0; i < t.size(); ++i) {
        double w = 1;
        for (Eigen::Index j = 0; j < t.size(); ++j)
            if (j != i) w /= t[i] - t[j];
        difference += w * (values[i] - values[0]);  // the same, and less rounding
        squares += w * w;
    }
    return std::abs(difference) / std::sqrt(squares);
}

double resolution(double value, double measured) {
    return std::max(10 * std::numeric_limits<double>::epsilon() * std::abs(value), measured);
}

double best_difference_step(double noise, double curvature) { return 2 * std::sqrt(noise / curvature); }

void ValueNoise::begin(double value_here) {
    t_ = {0};
    values_ = {value_here};
}

void ValueNoise::add(double t, double value) {
    if (t_.empty() || !(t > 0) || t > max_length || !std::isfinite(value)) return;
    for (const double known : t_)
        if (std::abs(t - known) < min_distance * std::max(t, known)) return;
    t_.push_back(t);
    values_.push_back(value);
    if (t_.size() > max_points) t_.erase(t_.begin() + 1), values_.erase(values_.begin() + 1);
    if (t_.size() < min_points) return;
    const std::size_t last = t_.size() - 1;
    const double all = noise_of(t_, values_);
    const double second = noise_of({t_[0], t_[last - 1], t_[last]}, {values_[0], values_[last - 1], values_[last]});
    if (!(all <= consistent * second && second <= consistent * all)) return;
    samples_.push_back(all);
    if (samples_.size() > max_samples) samples_.erase(samples_.begin());
}

double ValueNoise::level() const {
    double squares = 0;
    for (const double sample : samples_) squares += sample * sample;
    return samples_.empty() ? 0 : std::sqrt(squares / static_cast<double>(samples_.size()));
}

}  // namespace strake
