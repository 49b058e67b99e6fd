#include "optimize/nlp/minimizer.hpp"

#include "core/error.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>

using namespace strake;
using Eigen::VectorXd;

namespace {

/// Rosenbrock's function in n variables, optionally inside the disc |x|^2 <= radius^2.
struct Rosenbrock {
    double radius = 0;
    int evaluations = 0, differentiations = 0;
    std::function<void(const VectorXd&, Evaluation&)> spoil;

    NonlinearProgram program(const VectorXd& start) {
        NonlinearProgram p;
        p.start = start;
        p.lower = VectorXd::Constant(start.size(), -2);
        p.upper = VectorXd::Constant(start.size(), 2);
        p.num_inequalities = radius > 0 ? 1 : 0;
        p.evaluate = [this](const VectorXd& x) {
            ++evaluations;
            Evaluation s;
            s.objective = 0;
            for (Eigen::Index i = 0; i + 1 < x.size(); ++i)
                s.objective += 100 * std::pow(x[i + 1] - x[i] * x[i], 2) + std::pow(1 - x[i], 2);
            s.constraints.resize(radius > 0 ? 1 : 0);
            if (radius > 0) s.constraints[0] = x.squaredNorm() / (radius * radius) - 1;
            if (spoil) spoil(x, s);
            return s;
        };
        p.differentiate = [this](const VectorXd& x, Evaluation& s) {
            ++differentiations;
            s.gradient = VectorXd::Zero(x.size());
            for (Eigen::Index i = 0; i + 1 < x.size(); ++i) {
                s.gradient[i] += -400 * x[i] * (x[i + 1] - x[i] * x[i]) - 2 * (1 - x[i]);
                s.gradient[i + 1] += 200 * (x[i + 1] - x[i] * x[i]);
            }
            s.jacobian.resize(radius > 0 ? 1 : 0, x.size());
            if (radius > 0) s.jacobian.row(0) = 2 * x.transpose() / (radius * radius);
        };
        return p;
    }
};

MinimizeOptions tight(Method method = Method::sqp) {
    MinimizeOptions o;
    o.method = method;
    o.max_evaluations = 2000;
    o.objective_tolerance = 1e-12;
    o.step_tolerance = 1e-9;
    return o;
}

}  // namespace

TEST(Minimizer, EveryMethodFindsTheValley) {
    for (const Method method : {Method::sqp, Method::mma, Method::lbfgs, Method::cobyla}) {
        Rosenbrock f;
        MinimizeOptions options = tight(method);
        options.max_evaluations = 20000;
        const MinimizeResult r = minimize(f.program(vec({-1.2, 1})), options);
        EXPECT_LT((r.x - vec({1, 1})).norm(), method == Method::sqp || method == Method::lbfgs ? 1e-5 : 0.1)
            << static_cast<int>(method) << " " << r.reason;
        EXPECT_EQ(r.evaluations, f.evaluations);
    }
}

TEST(Minimizer, ConstraintIsActiveAndMet) {
    Rosenbrock f;
    f.radius = 1;
    const MinimizeResult r = minimize(f.program(vec({-0.5, 0.5})), tight());
    EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
    EXPECT_TRUE(r.is_feasible);
    EXPECT_LE(r.violation, 1e-6);
    EXPECT_LT((r.x - vec({0.786415, 0.617698})).norm(), 1e-4);  // published: Rosenbrock on the unit disc
}

/// Valleys much narrower than the first steps are long: what rejected steps tell of the curvature leads to their ends.
TEST(Minimizer, RejectedStepsTeachTheModel) {
    const KnownProgram known = rastrigin();
    for (const double offset : {0.0, 0.13, 0.31, 0.47}) {
        NonlinearProgram program = known.program;
        program.start.array() += offset;
        const MinimizeResult r = minimize(program, tight());
        EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
        EXPECT_LE(r.evaluations, 50);
        Evaluation end = r.best;
        program.differentiate(r.x, end);
        EXPECT_LT(end.gradient.norm(), 1e-4) << "curvature 20 pi^2: a minimum to 1e-6";
    }
}

/// A wall beyond the optimum is met by the first steps; it must not pass for the curvature of what lies before it.
TEST(Minimizer, AWallIsNoCurvature) {
    struct Wall {
        const char* name;
        std::function<double(double)> value, slope;  ///< of the first variable, beside the bowl
        double best;
    };
    const double inf = 1e300;
    std::vector<Wall> walls;
    for (const double height : {20.0, 1e3, 1e6, 1e10, inf})
        walls.push_back({"step", [=](double a) { return a > 0.3 ? height : (a - 0.28) * (a - 0.28); },
                         [](double a) { return 2 * (a - 0.28); }, 10});
    walls.push_back({"barrier", [](double a) { return a < 0.3 ? 1e-3 / (0.3 - a) - a : 1e6; },
                     [](double a) { return a < 0.3 ? 1e-3 / ((0.3 - a) * (0.3 - a)) - 1 : -1; }, 9.7632456});
    walls.push_back({"steep", [](double a) { return 1e-3 * std::exp(std::min(100 * (a - 0.3), 600.0)) - a; },
                     [](double a) { return 0.1 * std::exp(std::min(100 * (a - 0.3), 600.0)) - 1; }, 9.6869741});
    for (const Wall& wall : walls) {
        SCOPED_TRACE(wall.name);
        const NonlinearProgram program = program_of(
            vec({0, 0}), vec({-1, -1}), vec({1, 1}), 0, 0,
            [&](const VectorXd& x) { return vec({10 + wall.value(x[0]) + 0.5 * (x[1] - x[0]) * (x[1] - x[0])}); },
            [&](const VectorXd& x) {
                Eigen::MatrixXd g(1, 2);
                g << wall.slope(x[0]) - (x[1] - x[0]), x[1] - x[0];
                return g;
            });
        MinimizeOptions options;
        options.max_evaluations = 60;
        options.confirm = true;
        const MinimizeResult r = minimize(program, options);
        EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
        EXPECT_NEAR(r.best.objective, wall.best, 2e-5) << r.evaluations;
    }
}

TEST(Minimizer, EqualityIsMetByMethodsThatTakeNone) {
    Rosenbrock f;
    f.radius = 1;
    NonlinearProgram p = f.program(vec({0.5, 0.5}));
    std::swap(p.num_inequalities, p.num_equalities);
    for (const Method method : {Method::sqp, Method::mma, Method::lbfgs, Method::cobyla}) {
        const MinimizeResult r = minimize(p, tight(method));
        EXPECT_LE(r.violation, 1e-6) << r.reason;
        EXPECT_NEAR(r.x.norm(), 1, 1e-6);
        EXPECT_LT((r.x - vec({0.786415, 0.617698})).norm(), 1e-2) << static_cast<int>(method) << " " << r.reason;
    }
}

TEST(Minimizer, NotANumberNeverReachesTheResult) {
    for (const Method method : {Method::sqp, Method::mma, Method::lbfgs, Method::cobyla}) {
        Rosenbrock f;
        f.spoil = [](const VectorXd& x, Evaluation& s) {
            if (x[0] > 0.5) s.objective = std::numeric_limits<double>::quiet_NaN();
        };
        const MinimizeResult r = minimize(f.program(vec({-1.2, 1})), tight(method));
        EXPECT_TRUE(r.x.allFinite());
        EXPECT_TRUE(std::isfinite(r.best.objective));
        EXPECT_LE(r.x[0], 0.5);
        EXPECT_LT(r.best.objective, 24.2) << static_cast<int>(method);  // better than the start
        EXPECT_LE(r.evaluations, 2000);
    }
}

TEST(Minimizer, FailureShrinksTheBoxAndGoesOnToTheOptimum) {
    Rosenbrock f;  // no step longer than 0.3 from the best point succeeds
    VectorXd best = vec({-1.2, 1});
    double lowest = std::numeric_limits<double>::infinity();
    f.spoil = [&](const VectorXd& x, Evaluation& s) {
        if ((x - best).norm() > 0.3)
            s.failure = "triangle 3 is inverted";
        else if (s.objective < lowest)
            lowest = s.objective, best = x;
    };
    std::vector<std::string> events;
    MinimizeOptions options = tight();
    options.on_event = [&](const std::string& e) { events.push_back(e); };
    const MinimizeResult r = minimize(f.program(vec({-1.2, 1})), options);
    EXPECT_GT(r.shrinks, 0);
    EXPECT_LT((r.x - vec({1, 1})).norm(), 1e-4) << r.reason;
    ASSERT_FALSE(events.empty());
    EXPECT_NE(events[0].find("the largest step is cut to"), std::string::npos) << events[0];
}

TEST(Minimizer, FailureEverywhereElseIsBlocked) {
    Rosenbrock f;
    const VectorXd start = vec({-1.2, 1});
    f.spoil = [&](const VectorXd& x, Evaluation& s) {
        if (x != start) s.failure = "no";
    };
    const MinimizeResult r = minimize(f.program(start), tight());
    EXPECT_EQ(r.stop, MinimizeStop::no_valid_step);
    EXPECT_EQ(r.x, start);
    EXPECT_LE(r.evaluations, 20);
    f.spoil = [](const VectorXd&, Evaluation& s) { s.failure = "never"; };
    EXPECT_EQ(minimize(f.program(start), tight()).stop, MinimizeStop::failed);
}

TEST(Minimizer, TheOriginalExceptionComesOut) {
    Rosenbrock f;
    f.spoil = [&](const VectorXd&, Evaluation&) {
        if (f.evaluations == 3) throw SolverError("the factor has a pivot at row 7");
    };
    try {
        minimize(f.program(vec({-1.2, 1})), tight());
        FAIL();
    } catch (const SolverError& e) {
        EXPECT_STREQ(e.what(), "the factor has a pivot at row 7");
    }
}

TEST(Minimizer, LimitsHoldAndTheBestPointIsOurs) {
    for (const Method method : {Method::sqp, Method::mma, Method::lbfgs, Method::cobyla}) {
        Rosenbrock f;
        f.radius = method == Method::lbfgs ? 0 : 1;
        MinimizeOptions options = tight(method);
        options.max_evaluations = 12;
        double best = std::numeric_limits<double>::infinity();
        options.on_step = [&](const MinimizeStep& s) {
            if (s.is_feasible) best = std::min(best, s.evaluation.objective);
            return true;
        };
        const MinimizeResult r = minimize(f.program(vec({-0.5, 0.5})), options);
        EXPECT_LE(f.evaluations, 12);
        EXPECT_EQ(r.stop, MinimizeStop::evaluations) << static_cast<int>(method) << " " << r.reason;
        EXPECT_EQ(r.best.objective, best);
    }
}

TEST(Minimizer, FixedVariablesAreRemoved) {
    Rosenbrock f;
    NonlinearProgram p = f.program(vec({0.5, 0.5}));
    p.lower[0] = p.upper[0] = 0.5;
    const MinimizeResult r = minimize(p, tight());
    EXPECT_EQ(r.x[0], 0.5);
    EXPECT_NEAR(r.x[1], 0.25, 1e-6);
    p.lower[1] = p.upper[1] = 0.5;
    EXPECT_EQ(minimize(p, tight()).evaluations, 1);
}

TEST(Minimizer, FlatObjectiveSaysSo) {
    NonlinearProgram p;
    p.start = p.lower = VectorXd::Zero(2);
    p.upper = VectorXd::Ones(2);
    p.evaluate = [](const VectorXd&) {
        Evaluation evaluation;
        evaluation.objective = 3.0;
        return evaluation;
    };
    p.differentiate = [](const VectorXd& x, Evaluation& s) {
        s.gradient = VectorXd::Zero(x.size());
        s.jacobian.resize(0, x.size());
    };
    const MinimizeResult r = minimize(p, {});
    EXPECT_NE(r.reason.find("does not change"), std::string::npos);
}

TEST(Minimizer, ScaleOfTheObjectiveDoesNotMatter) {
    for (const double factor : {1.0, 1e-20, 1e20}) {
        Rosenbrock f;
        NonlinearProgram p = f.program(vec({-1.2, 1}));
        const auto evaluate = p.evaluate;
        const auto differentiate = p.differentiate;
        p.evaluate = [=](const VectorXd& x) {
            Evaluation s = evaluate(x);
            s.objective *= factor;
            return s;
        };
        p.differentiate = [=](const VectorXd& x, Evaluation& s) {
            differentiate(x, s);
            s.gradient *= factor;
        };
        const MinimizeResult r = minimize(p, tight());
        EXPECT_LT((r.x - vec({1, 1})).norm(), 1e-5);
    }
}

TEST(Minimizer, RefusesAStartOutsideTheBounds) {
    Rosenbrock f;
    NonlinearProgram p = f.program(vec({3, 0}));
    EXPECT_THROW(minimize(p, {}), InvalidInput);
}

/// The objective is stationary at the start, the constraint is 3 away, and evaluations have values next to the last
/// one that had: only a step that is really cut gets on.
TEST(Minimizer, StepsToTheConstraintsAreCutWhereTheObjectiveIsStationary) {
    for (const double size : {1e-6, 1.0, 1e6}) {
        VectorXd last = vec({0, 0});
        std::vector<VectorXd> failed;  // since the last value
        NonlinearProgram program = program_of(
            last, vec({-10, -10}), vec({10, 10}), 1, 0,
            [=](const VectorXd& x) {
                return vec({size * x.squaredNorm(), 3 - x[0]});
            },
            [=](const VectorXd& x) {
                Eigen::MatrixXd g(2, 2);
                g << 2 * size * x.transpose(), -1, 0;
                return g;
            });
        const auto right = program.evaluate;
        program.evaluate = [&](const VectorXd& x) {
            for (const VectorXd& before : failed) EXPECT_NE(before, x) << size;
            Evaluation e = right(x);
            if ((x - last).norm() > 0.7)
                e.failure = "too far", failed.push_back(x);
            else
                last = x, failed.clear();
            return e;
        };
        const MinimizeResult r = minimize(program, {});
        EXPECT_TRUE(r.stop == MinimizeStop::converged && r.is_feasible) << size << " " << r.reason;
        EXPECT_NEAR(r.x[0], 3, 1e-5) << size;
        EXPECT_LT(r.evaluations, 30) << size;
    }
}

/// What lies beyond a limit is moved back to where the search stands: that is a step too long, and costs nothing.
TEST(Minimizer, AStepThatIsMovedBackToItsBeginIsCut) {
    NonlinearProgram p = program_of(
        vec({0, 0}), vec({-2, -2}), vec({2, 2}), 0, 0,
        [](const VectorXd& x) { return vec({std::pow(x[0] - 0.2, 2) + std::pow(x[1] + 0.1, 2)}); },
        [](const VectorXd& x) {
            return Eigen::MatrixXd(vec({2 * (x[0] - 0.2), 2 * (x[1] + 0.1)}).transpose());
        });
    int asked = 0;
    p.evaluate = [&asked, ask = p.evaluate](const VectorXd& x) {
        ++asked;
        return ask(x);
    };
    p.within = [](const VectorXd& x) { return x.norm() > 0.3 ? VectorXd(VectorXd::Zero(2)) : x; };
    MinimizeOptions options;
    options.first_step = 1;
    const MinimizeResult r = minimize(p, options);
    EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
    EXPECT_LT((r.x - vec({0.2, -0.1})).norm(), 1e-4);
    EXPECT_LE(asked, r.evaluations);
}
