#include "optimize/run/sample_designs.hpp"

#include "core/error.hpp"
#include "optimize/nlp/surrogate/spread.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace strake {
namespace {

constexpr int points_at_a_time = 256;
constexpr double ball_dimensions = 3;
constexpr double same_place = 1e-6;  ///< of the cube's side: nobody pays for such a difference
constexpr double reach = 2;          ///< in the metric, where nothing limits it before: far beyond, shells buckle
constexpr double slack = 1e-6;       ///< of the motion limit: more than what separates two solutions of one equilibrium

/// x with Phi(x) = share, by Newton's method on the normal distribution.
double normal_quantile(double share) {
    double x = 0;
    for (int i = 0; i < 60; ++i) {
        const double off = 0.5 * std::erfc(-x / M_SQRT2) - share;
        const double step = off * std::sqrt(2 * M_PI) * std::exp(0.5 * x * x);
        x -= std::clamp(step, -0.5, 0.5);
        if (std::abs(step) < 1e-14) break;
    }
    return x;
}

/// levels^dimensions, or `limit` where it is more.
double power_up_to(int levels, Eigen::Index dimensions, double limit) {
    return std::min(limit, std::pow(static_cast<double>(levels), static_cast<double>(dimensions)));
}

}  // namespace

SampleDesigns::SampleDesigns(const Problem& problem, const DesignSpace& space, const Eigen::VectorXd& start, int most,
                             std::function<bool()> stop_wanted)
    : problem_(problem),
      space_(space),
      start_(start),
      stop_wanted_(std::move(stop_wanted)),
      shape_(space.num_shape()),
      parameters_(space.num_parameters()),
      max_designs_(most) {
    if (shape_ > 0) {
        U_ = space.metric.topLeftCorner(shape_, shape_).llt().matrixU();
        limit_ = motion_limit(problem, space.rest, stop_wanted_, datum_);
    }
    if (problem.sample == Spread::levels)
        choose_levels();
    else
        count_ = problem.sample == Spread::lhs ? most : std::numeric_limits<int>::max();
}

/// As many levels as the budget holds.
void SampleDesigns::choose_levels() {
    const Eigen::Index dimensions = shape_ + parameters_;
    const double room = static_cast<double>(max_designs_) + 1;
    // One below the root always fits: counting from one level on takes hours for a variable and a million designs.
    levels_ = std::max(0, static_cast<int>(std::pow(max_designs_, 1 / static_cast<double>(dimensions))) - 1);
    while (power_up_to(levels_ + 1, dimensions, room) < room && 1 + combinations(levels_ + 1, nullptr) <= max_designs_)
        ++levels_;
    if (levels_ < 2) {
        const double least = power_up_to(2, dimensions, 1e9) + 1;
        throw InvalidInput(text("two levels of each of ", dimensions, " variables are ",
                                least < 1e9 ? "" : "more than ", static_cast<long>(least), " designs, and there are ",
                                max_designs_,
                                "; take method sobol or lhs, or fewer variables (patches_per_level, variables)",
                                least < 1e6 ? ", or that many designs" : ""));
    }
    count_ = 1 + combinations(levels_, &places_);
}

/// All places but that of the start, in the unit cube, the last variable fastest.
int SampleDesigns::combinations(int levels, std::vector<Eigen::VectorXd>* places) const {
    const Eigen::Index dimensions = shape_ + parameters_;
    const Eigen::VectorXd at_start = place_of_start();
    std::vector<int> level(static_cast<std::size_t>(dimensions), 0);
    int count = 0;
    for (bool goes_on = true; goes_on;) {
        Eigen::VectorXd place(dimensions);
        for (Eigen::Index j = 0; j < dimensions; ++j)
            place[j] = levels > 1 ? static_cast<double>(level[static_cast<std::size_t>(j)]) / (levels - 1) : 0.5;
        if ((place - at_start).lpNorm<Eigen::Infinity>() > 1e-12) {
            ++count;
            if (places) places->push_back(place);
        }
        std::size_t j = level.size();
        while (j > 0 && ++level[j - 1] == levels) level[--j] = 0;
        goes_on = j > 0;
    }
    return count;
}

Eigen::VectorXd SampleDesigns::place_of(int number) {
    const bool is_lhs = problem_.sample == Spread::lhs;
    const auto dimensions = static_cast<int>(shape_ + parameters_ + (shape_ > 0 ? 1 : 0));
    if (number < first_point_ || number >= first_point_ + points_.rows()) {
        first_point_ = is_lhs ? 0 : number / points_at_a_time * points_at_a_time;
        points_ = is_lhs ? latin_hypercube(std::max(1, max_designs_ - 1), dimensions, problem_.optimize.seed)
                         : sobol_points(1 + first_point_, points_at_a_time, dimensions);
    }
    const Eigen::VectorXd place = points_.row(number - first_point_);
    // The second point of the sequence is the middle, which may be the start; the first one is the corner below.
    if (!is_lhs && shape_ == 0 && (place - place_of_start()).lpNorm<Eigen::Infinity>() < same_place)
        return Eigen::VectorXd::Zero(dimensions);
    return place;
}

/// In the unit cube of shape and parameters.
Eigen::VectorXd SampleDesigns::place_of_start() const {
    Eigen::VectorXd place = Eigen::VectorXd::Constant(shape_ + parameters_, 0.5);
    for (Eigen::Index j = shape_; j < place.size(); ++j)
        place[j] = (start_[j] - space_.lower[j]) / (space_.upper[j] - space_.lower[j]);
    return place;
}

Eigen::VectorXd SampleDesigns::design(int number) {
    if (number == 0) return start_;
    const Eigen::VectorXd place = levels_ > 0 ? places_[static_cast<std::size_t>(number - 1)] : place_of(number - 1);
    Eigen::VectorXd x = start_;
    for (Eigen::Index j = shape_; j < shape_ + parameters_; ++j)
        x[j] = space_.lower[j] + place[j] * (space_.upper[j] - space_.lower[j]);
    if (shape_ == 0) return x;
    if (levels_ > 0) {
        const Eigen::VectorXd z = 2 * place.head(shape_).array() - 1;
        return shape_towards(x, z, z.lpNorm<Eigen::Infinity>());
    }
    Eigen::VectorXd z = place.head(shape_).unaryExpr(&normal_quantile);
    if (!(z.norm() > 0)) z = Eigen::VectorXd::Unit(shape_, 0);
    const double dimensions = std::min(ball_dimensions, static_cast<double>(shape_));
    return shape_towards(x, z, std::pow(place[place.size() - 1], 1 / dimensions));
}

/// @param z direction in the whitened coordinates; share of the way to the limit
Eigen::VectorXd SampleDesigns::shape_towards(const Eigen::VectorXd& about, const Eigen::VectorXd& z,
                                             double share) const {
    Eigen::VectorXd x = about;
    if (!(share > 0)) return x;
    const Eigen::VectorXd direction = U_.triangularView<Eigen::Upper>().solve(z / z.norm());
    x.head(shape_) += (limit_.is_none() ? 1 : reach) * direction;
    x = x.cwiseMax(space_.lower).cwiseMin(space_.upper);
    // A solver of its own: where others begin depends on what they have solved before.
    std::optional<ShapeSolver> solver;
    if (!limit_.is_none()) {
        solver.emplace(problem_, space_.rest);
        solver->set_stop(stop_wanted_);
        solver->enter(space_);
        solver->set_limit(limit_, datum_);
        x = moved_inside(*solver, x, start_, slack);
    }
    x.head(shape_) = about.head(shape_) + share * (x.head(shape_) - about.head(shape_));
    if (solver) x = moved_inside(*solver, x, start_, slack);  // displacements are not quite linear in the design
    x.tail(parameters_) = about.tail(parameters_);
    return x;
}

}  // namespace strake
