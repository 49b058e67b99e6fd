#include "derivatives.hpp"
#include "optimize/nlp/low_fidelity/low_fidelity_search.hpp"
#include "optimize/nlp/program/first_order.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

/// Searches with a cheap program beside the expensive one.
namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Like the wave drag of a body: a quadratic form about its best shape, that bends upward far from it.
struct DragModel {
    MatrixXd stiffness;
    VectorXd best;

    DragModel(int n, unsigned seed) {
        const VectorXd entries = random_vector(n * n, seed);
        const MatrixXd across =
            Eigen::HouseholderQR<MatrixXd>(Eigen::Map<const MatrixXd>(entries.data(), n, n)).householderQ();
        VectorXd stiff(n);
        for (int j = 0; j < n; ++j) stiff[j] = std::pow(30, double(j) / (n - 1));
        stiffness = across * stiff.asDiagonal() * across.transpose();
        best = 0.8 * random_vector(n, seed + 100).normalized();
    }
    double drag(const VectorXd& x) const {
        const double q = 0.5 * (x - best).dot(stiffness * (x - best));
        return 1 + q + 0.02 * q * q;
    }
    VectorXd slope(const VectorXd& x) const {
        const VectorXd g = stiffness * (x - best);
        return (1 + 0.02 * (x - best).dot(g)) * g;
    }
};

/// What a solver says of the same body: another scale, and what the cheap model does not see.
struct Solver {
    DragModel body;
    VectorXd tilt;
    double scale = 0.7, size;  ///< of the residual

    Solver(int n, unsigned seed, double residual)
        : body(n, seed), tilt(random_vector(n, seed + 200).normalized()), size(residual) {}
    double drag(const VectorXd& x) const {
        return scale * body.drag(x) + size * (tilt.dot(x) + 0.3 * x.squaredNorm() + 0.2 * std::sin(3 * x[0]));
    }
};

double volume(const VectorXd& x) { return 0.1 * x.sum() + 0.2 * x.squaredNorm(); }

enum class Cheap { none, good, flipped, constant, another };

struct Case {
    Solver solver;
    DragModel another;
    bool is_constrained;
    int evaluations = 0, cheap_evaluations = 0;
    std::vector<double> feasible;  ///< lowest so far, per evaluation
    std::function<bool(const VectorXd&)> fails, cheap_fails;
    int failures = 0;
    std::vector<std::string> events;

    Case(int n, unsigned seed, double residual, bool constrained)
        : solver(n, seed, residual), another(n, seed + 1000), is_constrained(constrained) {}

    NonlinearProgram of(const Values& values, const Slopes& slopes) const {
        const auto n = solver.body.best.size();
        return program_of(VectorXd::Zero(n), VectorXd::Constant(n, -2), VectorXd::Constant(n, 2), 0,
                          is_constrained ? 1 : 0, values, slopes);
    }
    VectorXd with_volume(double drag, const VectorXd& x) const {
        return is_constrained ? vec({drag, volume(x)}) : vec({drag});
    }
    static void fail_where(NonlinearProgram& p, const std::function<bool(const VectorXd&)>& there) {
        p.evaluate = [there, inner = p.evaluate](const VectorXd& x) {
            if (!there(x)) return inner(x);
            Evaluation none;
            none.failure = "no steady flow";
            return none;
        };
    }
    NonlinearProgram program(Cheap cheap) {
        NonlinearProgram p = of(
            [this](const VectorXd& x) {
                ++evaluations;
                const double f = solver.drag(x);
                const double before = feasible.empty() ? 1e300 : feasible.back();
                const bool is_met = !is_constrained || std::abs(volume(x)) < 1e-4;
                feasible.push_back(is_met ? std::min(f, before) : before);
                return with_volume(f, x);
            },
            [this](const VectorXd& x) { return slopes(VectorXd::Zero(x.size()), x); });
        Differences differences;
        differences.step = 1e-3;
        if (is_constrained) differences.rows = {0};
        p.differences = differences;
        if (fails) fail_where(p, [this](const VectorXd& x) { return fails(x) && ++failures > 0; });
        if (cheap != Cheap::none) p.low_fidelity = low_fidelity(cheap);
        return p;
    }
    LowFidelity low_fidelity(Cheap cheap) {
        LowFidelity low;
        low.values = {LowFidelityValue::approximate};
        if (is_constrained) low.values.push_back(LowFidelityValue::same);
        const auto drag = [this, cheap](const VectorXd& x) {
            return cheap == Cheap::good       ? solver.body.drag(x)
                   : cheap == Cheap::flipped  ? -solver.body.drag(x)
                   : cheap == Cheap::constant ? 1.0
                                              : another.drag(x);
        };
        const auto slope = [this, cheap](const VectorXd& x) -> VectorXd {
            return cheap == Cheap::good       ? solver.body.slope(x)
                   : cheap == Cheap::flipped  ? VectorXd(-solver.body.slope(x))
                   : cheap == Cheap::constant ? VectorXd::Zero(x.size())
                                              : another.slope(x);
        };
        NonlinearProgram modelled = of(
            [this, drag](const VectorXd& x) {
                ++cheap_evaluations;
                return with_volume(drag(x), x);
            },
            [this, slope](const VectorXd& x) { return slopes(slope(x), x); });
        if (cheap_fails) fail_where(modelled, cheap_fails);
        low.program = std::make_shared<const NonlinearProgram>(std::move(modelled));
        return low;
    }
    MatrixXd slopes(const VectorXd& drag, const VectorXd& x) const {
        MatrixXd all(is_constrained ? 2 : 1, x.size());
        all.row(0) = drag.transpose();
        if (is_constrained) all.row(1) = (VectorXd::Constant(x.size(), 0.1) + 0.4 * x).transpose();
        return all;
    }
    MinimizeResult run(Cheap cheap, int max_evaluations) {
        evaluations = cheap_evaluations = failures = 0;
        feasible.clear();
        events.clear();
        MinimizeOptions how;
        how.max_evaluations = max_evaluations;
        how.constraint_tolerance = 1e-4;
        how.objective_tolerance = 1e-3;
        how.on_event = [this](const std::string& words) { events.push_back(words); };
        return minimize(program(cheap), how);
    }
    /// Evaluations until this share of the decrease from the start to `lowest` is there.
    int until(double share, double lowest) const {
        for (std::size_t k = 0; k < feasible.size(); ++k)
            if (feasible[k] <= feasible[0] - share * (feasible[0] - lowest)) return static_cast<int>(k) + 1;
        return 10000;
    }
};

bool holds(const std::vector<std::string>& events, const std::string& words) {
    return std::any_of(events.begin(), events.end(),
                       [&](const std::string& e) { return e.find(words) != std::string::npos; });
}

}  // namespace

TEST(ResidualModel, FindsScaleAndResidualAndTheirGradient) {
    const int n = 5;
    const DragModel body(n, 3);
    const VectorXd tilt = random_vector(n, 4);
    const auto f = [&](const VectorXd& x) { return -2.5 * body.drag(x) + 0.1 * tilt.dot(x); };
    const MatrixXd metric = MatrixXd::Identity(n, n) + 0.3 * MatrixXd::Ones(n, n);
    ResidualModel model(metric, {LowFidelityValue::approximate}, vec({1}));
    std::vector<VectorXd> at{VectorXd::Zero(n)};
    for (unsigned k = 0; k < 12; ++k) at.push_back(0.2 * random_vector(n, 50 + k));
    for (const VectorXd& x : at) model.add_point(x, vec({f(x)}), vec({body.drag(x)}));
    model.fit(at[0], body.slope(at[0]));
    EXPECT_NEAR(model.rho()[0], -2.5, 0.02);
    EXPECT_LT((model.slopes().col(0) - 0.1 * tilt).norm(), 0.05 * tilt.norm());
    const VectorXd way = random_vector(n, 9);
    EXPECT_LT(std::abs((model.gradients().col(0) + 2.5 * body.slope(at[0]) - 0.1 * tilt).dot(way)),
              0.02 * model.gradients().norm());
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<MatrixXd>(model.covariance(vec({1}))).eigenvalues().minCoeff(), -1e-12);
}

TEST(ResidualModel, KnownSlopesAreItsSlopes) {
    const int n = 4;
    const Solver solver(n, 5, 0.5);
    const VectorXd x = 0.1 * random_vector(n, 6), y = x + 0.3 * random_vector(n, 7);
    ResidualModel model(MatrixXd::Identity(n, n), {LowFidelityValue::approximate}, vec({1}));
    const auto slope = [&](const VectorXd& at) {
        VectorXd g(n);
        for (int j = 0; j < n; ++j)
            g[j] =
                (solver.drag(at + 1e-5 * VectorXd::Unit(n, j)) - solver.drag(at - 1e-5 * VectorXd::Unit(n, j))) / 2e-5;
        return g;
    };
    for (const VectorXd& at : {x, y}) {
        model.add_point(at, vec({solver.drag(at)}), vec({solver.body.drag(at)}));
        model.add_slopes(at, MatrixXd::Identity(n, n), slope(at), solver.body.slope(at));
    }
    model.fit(y, solver.body.slope(y));
    EXPECT_LT((model.gradients().col(0) - slope(y)).norm(), 1e-3 * slope(y).norm());
    EXPECT_NEAR(model.rho()[0], solver.scale, 0.1);
}

TEST(ResidualModel, AWrongCheapModelLosesItsWeight) {
    const int n = 5;
    const DragModel body(n, 3), another(n, 77);
    const auto weight = [&](const DragModel& cheap) {
        ResidualModel model(MatrixXd::Identity(n, n), {LowFidelityValue::approximate}, vec({1}));
        std::vector<VectorXd> at{VectorXd::Zero(n)};
        for (unsigned k = 0; k < 15; ++k) at.push_back(0.3 * random_vector(n, 50 + k));
        for (const VectorXd& x : at) model.add_point(x, vec({body.drag(x)}), vec({cheap.drag(x)}));
        model.fit(at[0], cheap.slope(at[0]));
        return std::array{model.rho()[0], model.share(0)};
    };
    EXPECT_NEAR(weight(body)[0], 1, 1e-3);
    EXPECT_GT(weight(body)[1], 0.9);
    EXPECT_LT(weight(another)[0], 0.7);
    EXPECT_LT(weight(another)[1], 0.4);
}

TEST(CorrectedProgram, HasTheGradientOfItsValues) {
    Case c(6, 4, 0.4, true);
    const NonlinearProgram p = c.program(Cheap::good);
    ResidualModel model(metric_of(p), p.low_fidelity->values, vec({1, 1}));
    const auto low_at = [&](const VectorXd& x, bool gradient) {
        Evaluation s = p.low_fidelity->program->evaluate(x);
        if (gradient) p.low_fidelity->program->differentiate(x, s);
        return s;
    };
    for (unsigned k = 0; k < 5; ++k) {
        const VectorXd x = 0.4 * random_vector(6, 30 + k);
        model.add_point(x, values_of(p.evaluate(x)), values_of(low_at(x, false)));
    }
    const VectorXd x0 = 0.4 * random_vector(6, 30);
    const Evaluation low = low_at(x0, true);
    LowFidelityPoint from{x0, values_of(p.evaluate(x0)), values_of(low), MatrixXd(6, 2), {}};
    from.low_gradients.col(0) = low.gradient;
    from.low_gradients.col(1) = low.jacobian.transpose();
    model.fit(x0, from.low_gradients);
    const NonlinearProgram corrected = corrected_program(*p.low_fidelity, model, from, metric_of(p), 0.7);
    EXPECT_EQ(corrected.num_inequalities, 1);
    const VectorXd x = x0 + 0.2 * random_vector(6, 8), way = random_vector(6, 9);
    Evaluation at = corrected.evaluate(x);
    corrected.differentiate(x, at);
    for (int row = -1; row < 2; ++row) {
        const auto value = [&](const VectorXd& there) {
            const Evaluation s = corrected.evaluate(there);
            return row < 0 ? s.objective : s.constraints[row];
        };
        const VectorXd g = row < 0 ? at.gradient : VectorXd(at.jacobian.row(row).transpose());
        EXPECT_NEAR(taylor_order(value, x, g, way), 2, 0.1) << row;
        EXPECT_LT(taylor_order(value, x, 1.1 * g, way, 1e-3), 1.3) << row;
    }
    EXPECT_NEAR(corrected.evaluate(x0).objective, from.values[0], 1e-12);
    EXPECT_NEAR(corrected.evaluate(x0).constraints[0], -1, 1e-12) << "the trust region, before the equality";
}

class WithACheapModel : public testing::TestWithParam<std::tuple<int, bool, unsigned>> {
protected:
    Case make(double residual) const {
        const auto [n, constrained, seed] = GetParam();
        return {n, seed, residual, constrained};
    }
};

TEST_P(WithACheapModel, AGoodOneSavesEvaluations) {
    Case c = make(0.3);
    const double lowest = c.run(Cheap::none, 3000).best.objective;
    c.run(Cheap::none, 400);
    const int without = c.until(0.95, lowest);
    c.run(Cheap::good, 400);
    EXPECT_LE(2.5 * c.until(0.95, lowest), without);
    EXPECT_LT(c.until(0.999, lowest), 10000) << "and it gets there";
}

TEST_P(WithACheapModel, AWrongOneCostsNoMoreThanAFifth) {
    Case c = make(0.3);
    const double lowest = c.run(Cheap::none, 3000).best.objective;
    for (const double share : {0.9, 0.99}) {
        c.run(Cheap::none, 400);
        const int without = c.until(share, lowest);
        for (const Cheap cheap : {Cheap::flipped, Cheap::constant, Cheap::another}) {
            c.run(cheap, 400);
            EXPECT_LE(c.until(share, lowest), 1.2 * without) << static_cast<int>(cheap) << " " << share;
        }
    }
}

TEST_P(WithACheapModel, SaysWhatItIsWorthAndGivesTheSameBitsTwice) {
    Case c = make(0.3);
    const MinimizeResult first = c.run(Cheap::good, 20);
    EXPECT_TRUE(holds(c.events, "cheap model: rho "));
    EXPECT_LE(c.evaluations, 20);
    const std::vector<double> seen = c.feasible;
    const MinimizeResult second = c.run(Cheap::good, 20);
    EXPECT_EQ(seen, c.feasible);
    EXPECT_EQ(first.x, second.x);
    EXPECT_NEAR(first.low_fidelity_scale[0], c.solver.scale, 0.3);
    c.run(Cheap::constant, 20);
    EXPECT_TRUE(holds(c.events, "it does not change with any variable"));
}

/// The optimum of the cheap model is beyond a border that the solver does not cross: the search goes along it instead
/// of spending its trust region on failures.
TEST_P(WithACheapModel, GoesAlongABorderOfFailures) {
    Case c = make(0.1);
    const VectorXd normal = c.solver.body.best.normalized();
    c.fails = [&](const VectorXd& x) { return normal.dot(x) > 0.3; };
    const double lowest = c.run(Cheap::none, 3000).best.objective;
    c.run(Cheap::good, 20);
    EXPECT_LT(c.feasible.back() - lowest, 0.1 * (c.feasible[0] - lowest)) << c.failures << " failures";
    EXPECT_LE(c.failures, 14);
}

/// A solver that fails now and then, whatever it is asked.
TEST_P(WithACheapModel, ChanceFailuresDoNotEndIt) {
    Case c = make(0.3);
    const double lowest = c.run(Cheap::none, 3000).best.objective;
    int calls = 0;
    c.fails = [&](const VectorXd& x) { return x.norm() > 0 && ++calls % 3 == 1; };
    c.run(Cheap::good, 40);
    EXPECT_FALSE(holds(c.events, "evaluations fail where it leads"));
    EXPECT_GE(c.failures, 1);
    EXPECT_LT(c.feasible.back() - lowest, 0.05 * (c.feasible[0] - lowest)) << c.failures << " failures";
}

/// Of the designs that one event says are asked for next to the present one.
struct FirstProbes {
    const Case& of;
    int left = -1;
    bool is_one() {
        const std::string begin = "cheap model: ", end = "next to the present one tell";
        if (left < 0 && !of.events.empty() && of.events.back().find(end) != std::string::npos)
            left = std::stoi(of.events.back().substr(begin.size()));
        return left > 0 && left-- > 0;
    }
};

/// All designs of the first round next to the present one fail: the other side is asked, and the model is not left.
TEST_P(WithACheapModel, FailingDesignsBesideThePresentOneDoNotEndIt) {
    Case c = make(0.3);
    const double lowest = c.run(Cheap::none, 3000).best.objective;
    FirstProbes probes{c};
    c.fails = [&](const VectorXd&) { return probes.is_one(); };
    c.run(Cheap::good, 40);
    ASSERT_GE(c.failures, 1) << "there was such a round";
    EXPECT_FALSE(holds(c.events, "the search goes on without it"));
    EXPECT_LT(c.feasible.back() - lowest, 0.05 * (c.feasible[0] - lowest)) << c.failures << " failures";
}

/// The solver has values there, but the cheap model does not.
TEST_P(WithACheapModel, ACheapModelWithoutValueBesideThePresentDesignIsNotLeft) {
    Case c = make(0.3);
    const double lowest = c.run(Cheap::none, 3000).best.objective;
    std::vector<VectorXd> missed;
    FirstProbes probes{c};
    c.fails = [&](const VectorXd& x) {
        if (probes.is_one()) missed.push_back(x);
        return false;
    };
    c.cheap_fails = [&](const VectorXd& x) { return std::find(missed.begin(), missed.end(), x) != missed.end(); };
    c.run(Cheap::good, 40);
    ASSERT_GE(missed.size(), 1u);
    EXPECT_FALSE(holds(c.events, "it has no value next to the present design"));
    EXPECT_LT(c.feasible.back() - lowest, 0.05 * (c.feasible[0] - lowest));
}

INSTANTIATE_TEST_SUITE_P(Sizes, WithACheapModel,
                         testing::Combine(testing::Values(8, 16), testing::Bool(), testing::Values(1u, 2u, 3u)));

}  // namespace strake
