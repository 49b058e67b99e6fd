#include "optimize/nlp/program/difference_step.hpp"

#include "derivatives.hpp"
#include "optimize/nlp/minimizer.hpp"

#include <gtest/gtest.h>
#include <bit>

using namespace strake;
using Eigen::VectorXd;

namespace {

/// In [-1, 1], from the bits of x.
double hash_noise(const VectorXd& x) {
    std::uint64_t h = 0x9E3779B97F4A7C15ull;
    for (const double v : x) {
        h ^= std::bit_cast<std::uint64_t>(v);
        h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ull;
        h = (h ^ (h >> 27)) * 0x94D049BB133111EBull;
        h ^= h >> 31;
    }
    return double(h >> 11) / double(1ull << 52) - 1;
}

/// sum a_i (x_i - 1)^2 / 2, a_i from 1 to 3, plus noise of this deviation.
NonlinearProgram noisy_bowl(int n, double deviation, int& evaluations) {
    NonlinearProgram p;
    p.start = VectorXd::Zero(n);
    p.lower = VectorXd::Constant(n, -5);
    p.upper = VectorXd::Constant(n, 5);
    p.evaluate = [=, &evaluations](const VectorXd& x) {
        ++evaluations;
        Evaluation s;
        const VectorXd a = VectorXd::LinSpaced(n, 1, 3);
        s.objective = 0.5 * (a.array() * (x.array() - 1).square()).sum() + deviation * std::sqrt(3.0) * hash_noise(x);
        s.constraints.resize(0);
        return s;
    };
    p.differences = Differences();
    p.differences->max_step = 0.3;
    return p;
}

Evaluation differentiated(const NonlinearProgram& p, double step) {
    Evaluation at = p.evaluate(p.start);
    at.gradient.resize(p.start.size());
    at.jacobian.resize(0, p.start.size());
    for (Eigen::Index j = 0; j < p.start.size(); ++j)
        at.gradient[j] =
            (p.evaluate(p.start + step * VectorXd::Unit(p.start.size(), j)).objective - at.objective) / step;
    return at;
}

}  // namespace

TEST(DifferenceStep, NoiseOfAnEvenLineIsThatOfTheValues) {
    double squares = 0;
    constexpr int lines = 200;
    for (int k = 0; k < lines; ++k) {
        VectorXd values(5);
        for (int i = 0; i < 5; ++i) {
            const double t = 1e-3 * i;
            values[i] = std::exp(t) + 1e-6 * std::sqrt(3.0) * hash_noise(VectorXd::Constant(1, k + 0.1 * i));
        }
        squares += std::pow(noise_on_even_line(values), 2) / lines;
    }
    EXPECT_NEAR(std::sqrt(squares), 1e-6, 1e-7);  // 600 differences: 4 %, of which the smooth part adds little
    VectorXd smooth(5);
    for (int i = 0; i < 5; ++i) smooth[i] = std::exp(1e-3 * i);
    EXPECT_LT(noise_on_even_line(smooth), 1e-9);
}

TEST(DifferenceStep, SmoothProgramsPayOneEvaluation) {
    int evaluations = 0;
    const NonlinearProgram p = noisy_bowl(8, 0, evaluations);
    const Evaluation at = differentiated(p, 1e-4);
    const int before = evaluations;
    EXPECT_FALSE(step_above_noise(p, p.start, at, 0.3, p.evaluate));
    EXPECT_EQ(evaluations, before + 1);
}

/// The error of a forward difference is h |f''| / 2 + 2 noise / h at worst; the step found is near the best one, as far
/// as the noise of five values is known: to a factor of three, of which the step takes the root.
TEST(DifferenceStep, FollowsTheNoise) {
    for (const double noise : {1e-2, 1e-3}) {
        int evaluations = 0;
        const NonlinearProgram p = noisy_bowl(8, noise, evaluations);
        const std::optional<StepChoice> found = step_above_noise(p, p.start, differentiated(p, 1e-4), 1, p.evaluate);
        ASSERT_TRUE(found) << noise;
        const double best = 2 * std::sqrt(noise / 2);
        EXPECT_GT(found->step, best / 4) << noise;
        EXPECT_LT(found->step, 4 * best) << noise;
        EXPECT_EQ(found->value, 0);
    }
}

/// Without the measurement the gradient is noise, and the search gets nowhere.
TEST(DifferenceStep, SearchesGoOnInNoise) {
    const auto left = [](double max_step) {
        int evaluations = 0;
        NonlinearProgram p = noisy_bowl(12, 1e-3, evaluations);
        p.differences->max_step = max_step;
        MinimizeOptions options;
        options.max_evaluations = 100;
        return minimize(p, options).best.objective;
    };
    EXPECT_LT(left(0.3), 0.5);  // of 12 at the start
    EXPECT_GT(left(0), 5 * left(0.3));
}
