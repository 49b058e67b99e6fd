#include "derivatives.hpp"
#include "optimize/nlp/program/guard.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>
#include <nlopt.hpp>

using namespace strake;
using Eigen::VectorXd;

namespace {

enum class Fault { not_a_number, infinite, throws, fails, constraint, gradient };
constexpr Fault all_faults[] = {Fault::not_a_number, Fault::infinite,   Fault::throws,
                                Fault::fails,        Fault::constraint, Fault::gradient};

/// Three calls of ten, the first never.
bool is_struck(int call) {
    auto h = static_cast<unsigned>(call) * 2654435761u;
    h ^= h >> 15;
    h *= 2246822519u;
    h ^= h >> 13;
    return call > 1 && h % 10 < 3;
}

struct Faulty {
    NonlinearProgram program;
    std::shared_ptr<int> calls = std::make_shared<int>(0), struck = std::make_shared<int>(0);
};

Faulty with_fault(const NonlinearProgram& sound, Fault fault) {
    Faulty f;
    f.program = sound;
    f.program.evaluate = [=, calls = f.calls, struck = f.struck](const VectorXd& x) {
        Evaluation s = sound.evaluate(x);
        if (fault == Fault::gradient || !is_struck(++*calls)) return s;
        ++*struck;
        if (fault == Fault::not_a_number) s.objective = std::numeric_limits<double>::quiet_NaN();
        if (fault == Fault::infinite) s.objective = -std::numeric_limits<double>::infinity();
        if (fault == Fault::throws) throw SolverError("pivot at row 7");
        if (fault == Fault::fails) s.failure = "triangle 3 is inverted";
        if (fault == Fault::constraint) {
            if (s.constraints.size() > 0)
                s.constraints[0] = std::numeric_limits<double>::quiet_NaN();
            else
                s.failure = "no constraint to spoil";
        }
        return s;
    };
    f.program.differentiate = [=, calls = f.calls, struck = f.struck](const VectorXd& x, Evaluation& s) {
        sound.differentiate(x, s);
        if (fault != Fault::gradient || !is_struck(++*calls)) return;
        ++*struck;
        s.gradient[0] = std::numeric_limits<double>::quiet_NaN();
    };
    return f;
}

class EveryMethodFaulty : public testing::TestWithParam<std::tuple<MethodFacts, Fault>> {};

std::string faulty_name(const testing::TestParamInfo<EveryMethodFaulty::ParamType>& info) {
    const char* names[] = {"NotANumber", "Infinite", "Throws", "Fails", "Constraint", "Gradient"};
    return std::string(std::get<0>(info.param).name) + names[static_cast<int>(std::get<1>(info.param))];
}

}  // namespace

/// The right optimum or a clear verdict, within the budget.
TEST_P(EveryMethodFaulty, RightOptimumOrAClearVerdict) {
    const auto& [method, fault] = GetParam();
    for (const KnownProgram& known : {bowl(), rosenbrock(), hock_schittkowski_71(), rastrigin(), corner()}) {
        if (known.program.start.size() == 2 && std::string(known.name) == "rastrigin" && !method.is_global) continue;
        SCOPED_TRACE(known.name);
        const Faulty f = with_fault(known.program, fault);
        MinimizeOptions o = tight_options(method.method, 1500);
        o.exceptions_are_failures = true;
        const MinimizeResult r = minimize(f.program, o);
        EXPECT_LE(r.evaluations, 1500);
        EXPECT_TRUE(r.x.allFinite());
        EXPECT_TRUE(std::isfinite(r.best.objective));
        EXPECT_EQ(r.failures, *f.struck);
        const bool best_of_all = std::abs(r.best.objective - known.value) < 3e-3 * known.value;
        // Where the best valley was struck out of a global search, the bottom of another is what can be had.
        NonlinearProgram from_there = known.program;
        from_there.start = r.x;
        const bool is_bottom = method.is_global &&
                               r.best.objective - minimize(from_there, tight_options(Method::sqp, 200)).best.objective <
                                   1e-4 * std::abs(r.best.objective);
        const bool right = r.is_feasible && (best_of_all || is_bottom);
        const bool says_failing = r.stop == MinimizeStop::no_valid_step || r.stop == MinimizeStop::failed ||
                                  r.reason.find("evaluations failed") != std::string::npos;
        EXPECT_TRUE(says_failing || *f.struck == 0) << r.reason;
        EXPECT_TRUE(right || r.stop != MinimizeStop::converged) << r.best.objective << " " << r.reason;
        if (std::getenv("STRAKE_TELL"))
            std::cout << "TELL " << method.name << " " << known.name << " " << right << " "
                      << r.best.objective - known.value << " after " << r.evaluations << ": " << r.reason << "\n";
    }
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethodFaulty,
                         testing::Combine(testing::ValuesIn(all_methods()), testing::ValuesIn(all_faults)),
                         faulty_name);

TEST(Faults, DifferencesUnderFaultsToo) {
    for (const MethodFacts& method : all_methods())
        for (const KnownProgram& known : {bowl(), rosenbrock(), hock_schittkowski_71(), corner()}) {
            SCOPED_TRACE(std::string(method.name) + " " + known.name);
            Faulty f = with_fault(known.program, Fault::fails);
            f.program.differentiate = nullptr;
            const MinimizeResult r = minimize(f.program, tight_options(method.method, 1000));
            EXPECT_LE(*f.calls, 1000);
            EXPECT_EQ(r.evaluations, *f.calls);
            EXPECT_EQ(r.failures, *f.struck);
            const bool right = r.is_feasible && std::abs(r.best.objective - known.value) < 3e-3 * known.value;
            EXPECT_TRUE(right || r.stop != MinimizeStop::converged) << r.reason;
            EXPECT_FALSE(r.gradient_inconsistent);
        }
}

/// Values come everywhere, gradients on one side of a plane only: the lowest value stands, and the run has not failed.
TEST(Faults, WhereOnlyGradientsFailTheBestPointStands) {
    for (const MethodFacts& method : all_methods()) {
        if (!method.needs_gradients && !method.is_global) continue;
        SCOPED_TRACE(method.name);
        NonlinearProgram p = bowl().program;
        p.differentiate = [sound = p.differentiate](const VectorXd& x, Evaluation& s) {
            sound(x, s);
            if (x[0] > 0) s.failure = "the adjoint diverges";
        };
        const MinimizeResult r = minimize(p, tight_options(method.method, 400));
        EXPECT_EQ(r.stop, MinimizeStop::no_valid_step) << r.reason;
        EXPECT_NE(r.reason.find("the adjoint diverges"), std::string::npos) << r.reason;
        EXPECT_LT(r.best.objective, p.evaluate(p.start).objective);
    }
}

/// One failure of ten is no border to go along, and where the gradient of that way failed the search once ended.
TEST(Faults, BadLuckDoesNotEndASearchWithoutGradients) {
    for (const Method method : {Method::cobyla, Method::bobyqa})
        for (unsigned seed = 1; seed <= 40; ++seed) {
            SCOPED_TRACE(text(method_facts(method).name, ", seed ", seed));
            NonlinearProgram p = bowl().program;
            int calls = 0;
            p.differentiate = nullptr;
            p.evaluate = [&, sound = p.evaluate](const VectorXd& x) {
                Evaluation s = sound(x);
                if (calls++ > 0 && random_vector(1, seed * 1000 + calls)[0] > 0.8) s.failure = "bad luck";
                return s;
            };
            const MinimizeResult r = minimize(p, tight_options(method, 600));
            EXPECT_LT(r.best.objective - 1, 1e-3 * (p.evaluate(p.start).objective - 1)) << r.reason;
        }
}

/// sqp begins along the border where the method without gradients has its best point: that is not paid again.
TEST(Faults, NoPointIsPaidTwiceAlongABorder) {
    for (const Method method : {Method::cobyla, Method::bobyqa}) {
        SCOPED_TRACE(method_facts(method).name);
        NonlinearProgram p = bowl().program;
        std::vector<VectorXd> paid;
        p.differentiate = nullptr;
        p.evaluate = [&, sound = p.evaluate](const VectorXd& x) {
            for (const VectorXd& y : paid) EXPECT_NE(x, y) << x.transpose();
            paid.push_back(x);
            Evaluation s = sound(x);
            if (x[0] - x[1] + x[2] > 0.2) s.failure = "the flow separates";
            return s;
        };
        const MinimizeResult r = minimize(p, tight_options(method, 300));
        EXPECT_NE(r.reason.find("sqp went on"), std::string::npos) << r.reason;
    }
}

TEST(Faults, SeveralStartsUnderFaultsToo) {
    for (const MethodFacts& method : all_methods())
        for (const Fault fault : {Fault::not_a_number, Fault::throws, Fault::fails})
            for (const KnownProgram& known : {bowl(), hock_schittkowski_71()}) {
                SCOPED_TRACE(std::string(method.name) + " " + known.name);
                const Faulty f = with_fault(known.program, fault);
                MinimizeOptions o = tight_options(method.method, 1200);
                o.exceptions_are_failures = true;
                o.starts = 3;
                const MinimizeResult r = minimize(f.program, o);
                EXPECT_LE(r.evaluations, 1200);
                EXPECT_EQ(r.failures, *f.struck);
                EXPECT_TRUE(r.x.allFinite() && std::isfinite(r.best.objective));
                const bool right = r.is_feasible && std::abs(r.best.objective - known.value) < 3e-3 * known.value;
                EXPECT_TRUE(right || r.stop != MinimizeStop::converged) << r.reason;
            }
}

TEST(Faults, TheTextOfAnExceptionSurvivesEveryMethod) {
    for (const MethodFacts& method : all_methods()) {
        SCOPED_TRACE(method.name);
        int calls = 0;
        NonlinearProgram p = bowl().program;
        p.evaluate = [&](const VectorXd& x) {
            if (++calls == 4) throw SolverError("the factor has a pivot at row 7");
            return bowl().program.evaluate(x);
        };
        try {
            minimize(p, tight_options(method.method, 100));
            ADD_FAILURE();
        } catch (const SolverError& e) {
            EXPECT_STREQ(e.what(), "the factor has a pivot at row 7");
        }
        EXPECT_EQ(calls, 4);
    }
}

TEST(Faults, AFatalFailureEndsEveryMethodAtOnce) {
    for (const MethodFacts& method : all_methods()) {
        SCOPED_TRACE(method.name);
        int calls = 0;
        NonlinearProgram p = bowl().program;
        p.evaluate = [&](const VectorXd& x) {
            Evaluation s = bowl().program.evaluate(x);
            if (++calls == 6) s.failure = "no licence", s.is_fatal = true;
            return s;
        };
        const MinimizeResult r = minimize(p, tight_options(method.method, 100));
        EXPECT_EQ(r.stop, MinimizeStop::failed);
        EXPECT_NE(r.reason.find("no licence"), std::string::npos);
        EXPECT_EQ(calls, 6);
    }
}

TEST(Faults, StoppingOnRequestEndsEveryMethodAtOnce) {
    for (const MethodFacts& method : all_methods()) {
        SCOPED_TRACE(method.name);
        int steps = 0;
        MinimizeOptions o = tight_options(method.method, 100);
        o.on_step = [&](const MinimizeStep&) { return ++steps < 5; };
        const MinimizeResult r = minimize(rosenbrock().program, o);
        EXPECT_EQ(r.stop, MinimizeStop::stopped) << r.reason;
        EXPECT_EQ(r.evaluations, method.method == Method::model ? 1 + o.batch : 5);  // a batch is evaluated whole
    }
}

/// Steps that are too long fail, as near buckling: 20 variables of very different stiffness under a constraint.
TEST(Faults, NoMethodWithGradientsTakesACutStepForConvergence) {
    const int n = 20;
    VectorXd weight(n), at(n);
    for (int j = 0; j < n; ++j) weight[j] = std::pow(10, 2.0 * j / (n - 1)), at[j] = j % 2 ? 0.8 : -0.6;
    const NonlinearProgram sound = program_of(
        VectorXd::Zero(n), VectorXd::Constant(n, -1), VectorXd::Ones(n), 1, 0,
        [=](const VectorXd& x) {
            return vec({(x - at).cwiseAbs2().dot(weight), (x.squaredNorm() - 4) / 4});
        },
        [=](const VectorXd& x) {
            Eigen::MatrixXd g(2, n);
            g << 2 * (x - at).cwiseProduct(weight).transpose(), x.transpose() / 2;
            return g;
        });
    const double start = sound.evaluate(sound.start).objective;
    const double least = minimize(sound, tight_options(Method::sqp, 1000)).best.objective;
    for (const auto& [method, is_of_step] : std::vector<std::pair<Method, bool>>{{Method::sqp, false},
                                                                                 {Method::sqp, true},
                                                                                 {Method::mma, false},
                                                                                 {Method::ccsaq, false},
                                                                                 {Method::lbfgs, false},
                                                                                 {Method::lbfgs, true},
                                                                                 {Method::tnewton, false}}) {
        SCOPED_TRACE(text(method_facts(method).name, is_of_step ? ", told as the step's" : ""));
        NonlinearProgram p = sound;
        VectorXd best = p.start;
        double lowest = start;
        p.evaluate = [&, of_step = is_of_step](const VectorXd& x) {
            Evaluation s = sound.evaluate(x);
            s.is_of_step = of_step;
            if ((x - best).norm() > 0.5)
                s.failure = "buckled";
            else if (s.objective < lowest && s.constraints[0] <= 1e-6)
                lowest = s.objective, best = x;
            return s;
        };
        std::vector<std::string> told;
        MinimizeOptions o = tight_options(method, 1000);
        o.on_event = [&](const std::string& words) { told.push_back(words); };
        const MinimizeResult r = minimize(p, o);
        EXPECT_TRUE(r.is_feasible);
        for (const std::string& words : told)
            EXPECT_FALSE(is_of_step && (words.find("plane between") != std::string::npos ||
                                        words.find("along their border") != std::string::npos))
                << words;
        EXPECT_GT(start - r.best.objective, 0.999 * (start - least)) << r.reason;
    }
}

/// Each search of an augmented Lagrangian may shrink its steps as often as any other: failures far apart do not add up.
TEST(Faults, FailuresFarApartDoNotAddUpOverTheSearchesOfAnAugmentedLagrangian) {
    const NonlinearProgram sound = program_of(
        vec({-0.5, 0.8, -0.9}), VectorXd::Constant(3, -2), VectorXd::Constant(3, 2), 1, 0,
        [](const VectorXd& x) {
            return vec({x[0] + 2 * x[1] + std::exp(x[2]), x.squaredNorm() - 1});
        },
        [](const VectorXd& x) {
            Eigen::MatrixXd g(2, 3);
            g << 1, 2, std::exp(x[2]), 2 * x.transpose();
            return g;
        });
    MinimizeOptions o = tight_options(Method::lbfgs, 600);
    const MinimizeResult undisturbed = minimize(sound, o);
    o.max_shrinks = 3;
    int calls = 0, failures = 0;
    NonlinearProgram p = sound;
    p.evaluate = [&](const VectorXd& x) {
        Evaluation s = sound.evaluate(x);
        if (++calls % 20 == 0) s.failure = "the licence server was away", s.is_of_step = true, ++failures;
        return s;
    };
    const MinimizeResult r = minimize(p, o);
    EXPECT_GT(failures, o.max_shrinks) << r.reason;
    EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
    EXPECT_NEAR(r.best.objective, undisturbed.best.objective, 1e-6) << r.reason;
}

/// One of ten evaluations fails for no reason of the design's: a long search that goes on gaining is not at its end.
TEST(Faults, ChanceFailuresDoNotAddUpOverALongSearch) {
    const int n = 40;
    VectorXd weight(n);
    for (int j = 0; j < n; ++j) weight[j] = std::pow(10, 3.0 * j / (n - 1));
    const NonlinearProgram sound = program_of(
        VectorXd::Zero(n), VectorXd::Constant(n, -9), VectorXd::Constant(n, 9), 0, 0,
        [=](const VectorXd& x) {
            const Eigen::ArrayXd off = x.array() - 1, bend = x.tail(n - 1).array() - x.head(n - 1).array().square();
            return vec({(weight.array() * (off.square() + 0.1 * off.pow(4))).sum() + 10 * bend.square().sum()});
        },
        [=](const VectorXd& x) {
            const Eigen::ArrayXd off = x.array() - 1, bend = x.tail(n - 1).array() - x.head(n - 1).array().square();
            Eigen::MatrixXd g(1, n);
            g.row(0) = (weight.array() * (2 * off + 0.4 * off.cube())).matrix().transpose();
            g.row(0).tail(n - 1) += 20 * bend.matrix().transpose();
            g.row(0).head(n - 1) -= (40 * bend * x.head(n - 1).array()).matrix().transpose();
            return g;
        });
    int calls = 0, failures = 0;
    NonlinearProgram p = sound;
    p.evaluate = [&](const VectorXd& x) {
        Evaluation s = sound.evaluate(x);
        if (++calls % 10 == 0) s.failure = "the licence server was away", s.is_of_step = true, ++failures;
        return s;
    };
    const double start = sound.evaluate(sound.start).objective;
    const MinimizeOptions o = tight_options(Method::sqp, 600);
    const MinimizeResult r = minimize(p, o);
    EXPECT_GT(failures, o.max_failures) << r.reason;
    EXPECT_LT(r.best.objective, 1e-4 * start) << r.reason;
}

/// What an algorithm asks for is looked at before anything is deformed.
TEST(Guard, NotANumberIsNeverEvaluatedAndBoundsHold) {
    const KnownProgram known = bowl();
    std::vector<VectorXd> asked;
    NonlinearProgram p = known.program;
    p.evaluate = [&](const VectorXd& x) {
        asked.push_back(x);
        return known.program.evaluate(x);
    };
    const MinimizeOptions options;
    for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        Guard guard(p, options);
        EXPECT_THROW(guard.at_all(vec({0, wrong, 0}), false), nlopt::forced_stop);
        EXPECT_EQ(guard.cause, StopCause::nonfinite_point);
        EXPECT_TRUE(asked.empty());
    }
    Guard guard(p, options);
    guard.at_all(vec({0, 7, -1e300}), false);
    ASSERT_EQ(asked.size(), 1u);
    EXPECT_EQ(asked[0], vec({0, 1, -1}));
}
