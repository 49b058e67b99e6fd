#include "optimize/nlp/sqp/parabola_misfit.hpp"

#include <algorithm>
#include <cmath>

namespace strake {

double parabola_misfit(const SqpIterate& now, const Evaluation& there, const Eigen::VectorXd& multipliers,
                       const Eigen::VectorXd& step) {
    const auto slope = [&](const Evaluation& at) {
        return (at.gradient + at.jacobian.transpose() * multipliers).dot(step);
    };
    const double change = there.objective - now.at.objective + multipliers.dot(there.constraints - now.at.constraints);
    const double first = slope(now.at), last = slope(there);
    const double larger = std::max(std::abs(first), std::abs(last));
    return larger > 0 ? std::abs(change - 0.5 * (first + last)) / larger : 0;
}

}  // namespace strake
