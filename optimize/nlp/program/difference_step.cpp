#include "optimize/nlp/program/difference_step.hpp"

#include "optimize/nlp/program/first_order.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace strake {
namespace {

using Eigen::VectorXd;

constexpr double sound_share = 0.5;  ///< of a slope that values may miss
constexpr int line_points = 5;       ///< the given one among them
constexpr int first_order = 3;       ///< of the differences that count: lower ones see the function
constexpr double seen = 10;          ///< times the noise: a second difference that says something
constexpr double worthwhile = 2;     ///< times the step

/// A line from x, t its length in the metric.
class Line {
public:
    Line(const NonlinearProgram& program, const VectorXd& x, const VectorXd& direction,
         const std::function<Evaluation(const VectorXd&)>& evaluate)
        : p_(program), x_(x), d_(direction), evaluate_(evaluate) {}

    /// Values at t; empty where there are none, or where a bound cuts the line.
    VectorXd at(double t) const {
        const VectorXd there = x_ + t * d_, inside = there.cwiseMax(p_.lower).cwiseMin(p_.upper);
        if ((inside - there).norm() > 0.1 * std::abs(t) * d_.norm()) return {};
        const Evaluation s = evaluate_(inside);
        return s.failure.empty() ? values_of(s) : VectorXd();
    }

private:
    const NonlinearProgram& p_;
    const VectorXd &x_, &d_;
    const std::function<Evaluation(const VectorXd&)>& evaluate_;
};

/// Second derivative of the value along the line, from points that are far enough apart to see it; at least what would
/// just not be seen at the farthest.
std::optional<double> curvature(const Line& line, const VectorXd& here, Eigen::Index value, double noise,
                                double max_step) {
    double least = 0;
    for (const double t : {0.1, 0.3, 1.0}) {
        const double far = std::min(t, max_step);
        const VectorXd up = line.at(far), down = line.at(-far);
        if (up.size() == 0 || down.size() == 0) break;
        const double second = std::abs(up[value] - 2 * here[value] + down[value]);
        if (second > seen * noise) return second / (far * far);
        least = seen * noise / (far * far);
        if (far == max_step) break;
    }
    return least > 0 ? std::optional<double>(least) : std::nullopt;
}

}  // namespace

double noise_on_even_line(const VectorXd& values) {
    VectorXd difference = values;
    double squares = 0, factor = 1;  // of the variance of a difference: (2 k)! / (k!)^2
    int count = 0;
    for (int k = 1; k < values.size(); ++k) {
        difference = (difference.tail(difference.size() - 1) - difference.head(difference.size() - 1)).eval();
        factor *= 2.0 * (2 * k - 1) / k;
        if (k < first_order) continue;
        squares += difference.squaredNorm() / factor;
        count += static_cast<int>(difference.size());
    }
    return count > 0 ? std::sqrt(squares / count) : 0;
}

std::optional<StepChoice> step_above_noise(const NonlinearProgram& program, const VectorXd& x,
                                           const Evaluation& evaluation, double max_step,
                                           const std::function<Evaluation(const VectorXd&)>& evaluate) {
    const Differences& how = *program.differences;
    const Eigen::LLT<Eigen::MatrixXd> metric(metric_of(program));
    VectorXd direction = -metric.solve(evaluation.gradient);
    const double slope = std::sqrt(std::max(0.0, -evaluation.gradient.dot(direction)));
    if (!(slope > 0) || !std::isfinite(slope)) return {};
    direction /= slope;  // of length 1 in the metric
    const Line line(program, x, direction, evaluate);
    const VectorXd here = values_of(evaluation), next = line.at(how.step);
    if (next.size() == 0) return {};
    std::vector<Eigen::Index> suspicious;
    for (Eigen::Index i = 0; i < here.size(); ++i) {
        const bool by_differences =
            i == 0 ? how.objective : how.rows.empty() || how.rows[static_cast<std::size_t>(i - 1)];
        const VectorXd g = i == 0 ? evaluation.gradient : VectorXd(evaluation.jacobian.row(i - 1).transpose());
        const double largest = std::sqrt(std::max(0.0, g.dot(metric.solve(g))));
        const double missed = std::abs(next[i] - here[i] - how.step * g.dot(direction));
        if (by_differences && missed > sound_share * how.step * largest) suspicious.push_back(i);
    }
    if (suspicious.empty()) return {};
    Eigen::MatrixXd values(here.size(), line_points);
    values.col(0) = here;
    values.col(1) = next;
    for (int k = 2; k < line_points; ++k) {
        const VectorXd further = line.at(k * how.step);
        if (further.size() == 0) return {};
        values.col(k) = further;
    }
    StepChoice choice;
    for (const Eigen::Index i : suspicious) {
        const double noise = noise_on_even_line(values.row(i).transpose());
        const std::optional<double> second =
            noise > 0 ? curvature(line, here, i, noise, std::max(max_step, how.step)) : std::nullopt;
        if (!second) continue;
        const double step = std::min(2 * std::sqrt(noise / *second), max_step);
        if (step > worthwhile * how.step && step > choice.step) choice = {step, noise, static_cast<int>(i)};
    }
    return choice.step > 0 ? std::optional<StepChoice>(choice) : std::nullopt;
}

}  // namespace strake
