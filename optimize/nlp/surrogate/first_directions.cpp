#include "optimize/nlp/surrogate/first_directions.hpp"

#include "optimize/nlp/surrogate/spread.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double same_point = 1e-9;  ///< in z: round-off of inherited designs
constexpr double next_to = 1e-2;     ///< of the first step: what exact limits move along other axes

bool has_moved(const SampledPoints& points, int axis, double least) {
    for (int i = 1; i < points.size(); ++i)
        if (std::abs(points[i].z[axis] - points[0].z[axis]) > least) return true;
    return false;
}

/// The axes of z are the variables, each without what those before it can do: whitening is by a triangular matrix.
/// What points that are known have not moved yet comes first.
MatrixXd directions_in_order(const SampledPoints& points, double least) {
    const auto d = static_cast<int>(points.dimensions());
    const MatrixXd axes = MatrixXd::Identity(d, d);
    std::vector<int> order;
    for (const bool is_known : {false, true})
        for (int k = 0; k < d; ++k)
            if (has_moved(points, k, least) == is_known) order.push_back(k);
    return axes(Eigen::all, order);
}

/// Of `first_alone`, to where bounds leave more room.
MatrixXd directions_alone(const Guard& guard, const SampledPoints& points) {
    const NonlinearProgram& p = guard.program;
    MatrixXd all(points.dimensions(), 0);
    if (points.size() > 1) return all;  // known designs have moved them
    for (const int j : guard.options.first_alone) {
        const auto at = std::ranges::find(guard.free, j);
        const bool is_enough = 2 * all.cols() >= guard.options.batch || all.cols() == points.dimensions();
        if (at == guard.free.end() || is_enough) continue;
        const double sign = p.upper[j] - p.start[j] < p.start[j] - p.lower[j] ? -1 : 1;
        all.conservativeResize(Eigen::NoChange, all.cols() + 1);
        all.rightCols(1) = sign * points.by_variables().col(at - guard.free.begin());
    }
    return all;
}

}  // namespace

MatrixXd first_directions(const Guard& guard, const SampledPoints& points, bool has_exact_limits) {
    const auto d = static_cast<int>(points.dimensions());
    if (guard.options.tries_in_order)
        return directions_in_order(points, has_exact_limits ? next_to * guard.options.first_step : same_point);
    MatrixXd cloud = latin_hypercube(d, d, guard.options.seed).array() - 0.5;
    const MatrixXd alone = directions_alone(guard, points);
    cloud.leftCols(alone.cols()) = alone;
    MatrixXd directions = Eigen::HouseholderQR<MatrixXd>(cloud).householderQ();
    for (Eigen::Index k = 0; k < alone.cols(); ++k)
        if (directions.col(k).dot(alone.col(k)) < 0) directions.col(k) *= -1;
    return directions;
}

}  // namespace strake
