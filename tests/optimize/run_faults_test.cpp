#include "core/error.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

/// Whole runs with every method whose quantity fails on three calls of ten: the right optimum or a clear verdict
/// within the budget, and every failure in the log under its number.
namespace strake {
namespace {

enum class Fault { not_a_number, throws, fails };
constexpr Fault all_faults[] = {Fault::not_a_number, Fault::throws, Fault::fails};
constexpr int budget = 40;

/// Three calls of ten, the first never.
bool is_struck(int call) {
    auto h = static_cast<unsigned>(call) * 2654435761u;
    h ^= h >> 15;
    h *= 2246822519u;
    h ^= h >> 13;
    return call > 1 && h % 10 < 3;
}

Problem sound_problem() {
    Problem problem = ellipsoid_problem(1, 2);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.objective = "volume";
    problem.maximize = true;
    problem.constraints = {{"area", {}, 1.02, {}, true}};
    problem.optimize.max_evaluations = budget;
    return problem;
}

/// The first quantity fails; `struck` holds the numbers of the evaluations.
Problem with_fault(Fault fault, bool shortens_step, std::vector<int>& struck) {
    Problem problem = sound_problem();
    Quantity& quantity = problem.quantities[0];
    quantity.failing_shortens_step = shortens_step;
    quantity.evaluate = [=, &struck, honest = quantity.evaluate,
                         calls = std::make_shared<int>(0)](const QuantityRequest& request) -> QuantityResult {
        QuantityResult result = honest(request);
        if (!is_struck(++*calls)) return result;
        struck.push_back(request.evaluation);
        if (fault == Fault::not_a_number) result.values[0] = std::numeric_limits<double>::quiet_NaN();
        if (fault == Fault::throws) throw std::runtime_error("the licence server is gone");
        if (fault == Fault::fails) return {{}, {}, Failure{"undefined", "no crossing"}};
        return result;
    };
    return problem;
}

const char* words_of(Fault fault) {
    return fault == Fault::not_a_number ? "nan" : fault == Fault::throws ? "the licence server is gone" : "no crossing";
}

void PrintTo(Fault fault, std::ostream* out) { *out << words_of(fault); }

class EveryMethodInARun : public testing::TestWithParam<std::tuple<MethodFacts, Fault>> {};

std::string method_and_fault(const testing::TestParamInfo<EveryMethodInARun::ParamType>& info) {
    const char* names[] = {"NotANumber", "Throws", "Fails"};
    return std::string(std::get<0>(info.param).name) + names[static_cast<int>(std::get<1>(info.param))];
}

/// Log of a run: every record is finite or has its reason.
struct Log {
    std::vector<EvaluationRecord> records;
    std::vector<int> failed() const {
        std::vector<int> numbers;
        for (const EvaluationRecord& r : records)
            if (r.status == "quantity_failed") numbers.push_back(r.evaluation);
        return numbers;
    }
};

RunResult logged(const Problem& problem, Log& log) {
    RunEvents events;
    events.evaluation = [&](const EvaluationRecord& r) {
        EXPECT_EQ(r.evaluation, static_cast<int>(log.records.size()) + 1);
        EXPECT_EQ(r.status == "ok", std::isfinite(r.objective));
        EXPECT_EQ(r.status == "ok", r.reason.empty());
        log.records.push_back(r);
    };
    return optimize(problem, events);
}

double min_possible() {
    static const double objective = [] {
        Problem problem = sound_problem();
        problem.optimize.max_evaluations = 200;
        return optimize(problem).objective;
    }();
    return objective;
}

}  // namespace

TEST_P(EveryMethodInARun, RightOptimumOrAClearVerdictWithinTheBudget) {
    const auto& [method, fault] = GetParam();
    std::vector<int> struck;
    Problem problem = with_fault(fault, true, struck);
    problem.optimize.method = method.method;
    Log log;
    const RunResult r = logged(problem, log);
    EXPECT_LE(r.evaluations, budget);
    const std::vector<int> failed = log.failed();
    ASSERT_GT(failed.size(), 0u);
    if (method.method == Method::model)  // asks what constraints need of designs that it does not evaluate, too
        for (const int number : failed) EXPECT_NE(std::find(struck.begin(), struck.end(), number), struck.end());
    else
        EXPECT_EQ(failed, struck);
    EXPECT_NE(log.records[failed[0] - 1].reason.find(words_of(fault)), std::string::npos)
        << log.records[failed[0] - 1].reason;
    // The result is the best of what was seen.
    double best = 0;
    for (const EvaluationRecord& record : log.records)
        if (record.status == "ok" && record.max_violation <= 1e-6) best = std::max(best, record.objective);
    EXPECT_EQ(r.objective, best);
    EXPECT_TRUE(r.vertices.allFinite() && r.vertices.rows() > 0);
    const double gain = (r.objective - r.objective_start) / (min_possible() - r.objective_start);
    if (std::getenv("STRAKE_TELL"))
        std::cout << "TELL " << method.name << " " << gain << " after " << r.evaluations << ": " << r.status << ": "
                  << r.reason << "\n";
    int active = 0, variables = 0;
    if (const std::size_t at = r.reason.find("bounds active on"); at != std::string::npos) {
        ASSERT_EQ(std::sscanf(r.reason.c_str() + at, "bounds active on %d of %d", &active, &variables), 2);
        EXPECT_LE(active, variables) << r.reason;
    }
    // Where bounds, and the constraint with the last variable, hold all there is, or the motion limit does, a local
    // optimum is one of several, and the verdict says what would give room.
    const bool cornered = (variables > 0 && active >= variables - 1) || r.motion.is_active ||
                          r.reason.find("a larger max_displacement would give them room") != std::string::npos;
    EXPECT_TRUE(gain > 0.98 || r.status == "budget" || r.status == "no_valid_step" || cornered)
        << gain << " " << r.status << ": " << r.reason;
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethodInARun,
                         testing::Combine(testing::ValuesIn(all_methods()), testing::ValuesIn(all_faults)),
                         method_and_fault);

TEST(RunFaults, WithoutLeaveToGoOnTheFirstFailureEndsTheRun) {
    for (const Fault fault : all_faults)
        for (const MethodFacts& method : all_methods()) {
            SCOPED_TRACE(method.name);
            std::vector<int> struck;
            Problem problem = with_fault(fault, false, struck);
            problem.optimize.method = method.method;
            Log log;
            const RunResult r = logged(problem, log);
            EXPECT_EQ(r.status, "evaluation_failed");
            EXPECT_NE(r.reason.find(words_of(fault)), std::string::npos) << r.reason;
            EXPECT_EQ(log.failed(), std::vector<int>{r.evaluations});
            // model asks what constraints need of designs that it does not evaluate, too.
            EXPECT_TRUE(method.method == Method::model || struck == log.failed());
            EXPECT_FALSE(r.is_done());
        }
}

TEST(RunFaults, SeveralStartsGoOnAfterFailures) {
    for (const Fault fault : all_faults) {
        std::vector<int> struck;
        Problem problem = with_fault(fault, true, struck);
        problem.optimize.starts = 3;
        problem.optimize.max_evaluations = 120;
        Log log;
        const RunResult r = logged(problem, log);
        EXPECT_LE(r.evaluations, 120);
        EXPECT_EQ(log.failed(), struck);
        EXPECT_GT(r.objective - r.objective_start, 0.9 * (min_possible() - r.objective_start)) << r.reason;
    }
}

TEST(RunFaults, AGradientThatIsNotFiniteIsNamed) {
    Problem problem = sound_problem();
    problem.quantities[0].evaluate = [honest = problem.quantities[0].evaluate](const QuantityRequest& request) {
        QuantityResult result = honest(request);
        if (request.want_sensitivities && request.evaluation >= 3)
            result.dJ_dv[0](7, 1) = std::numeric_limits<double>::infinity();
        return result;
    };
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "evaluation_failed");
    EXPECT_NE(r.reason.find("volume: no finite vertex sensitivities"), std::string::npos) << r.reason;
    EXPECT_EQ(r.evaluations, 3);
}

/// A limit stands even where nobody asked for one.
TEST(RunFaults, DefaultsLimitARunThatNeverSucceedsAgain) {
    EXPECT_GE(OptimizeOptions().max_evaluations, 1);
    for (const MethodFacts& method : all_methods()) {
        SCOPED_TRACE(method.name);
        Problem problem = sound_problem();
        problem.optimize = {};
        problem.optimize.method = method.method;
        problem.quantities[0].failing_shortens_step = true;
        problem.quantities[0].evaluate = [honest = problem.quantities[0].evaluate](const QuantityRequest& request) {
            QuantityResult result = honest(request);
            if (request.evaluation > 1) result.values[0] = std::numeric_limits<double>::quiet_NaN();
            return result;
        };
        const RunResult r = optimize(problem);
        EXPECT_LE(r.evaluations, OptimizeOptions().max_evaluations);
        EXPECT_EQ(r.best_evaluation, 1);
        EXPECT_NE(r.status, "converged") << r.reason;
        EXPECT_FALSE(r.reason.empty());
    }
}

}  // namespace strake
