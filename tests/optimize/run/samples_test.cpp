#include "optimize/run/samples.hpp"

#include "core/error.hpp"
#include "core/mesh/temp_folder.hpp"
#include "optimize/nlp/surrogate/spread.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/design_table.hpp"
#include "optimize/run/run_state.hpp"
#include "optimize/run/sample_effects.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <set>

namespace strake {
namespace {

Problem sampled_ellipsoid(int designs, Spread spread = Spread::sobol) {
    Problem problem = ellipsoid_problem(2, 2);
    maximize_volume(problem);
    problem.sample = spread;
    problem.optimize.max_evaluations = designs;
    return problem;
}

/// A quantity of three parameters, the shape as it is.
Problem ishigami(int designs, int* calls = nullptr) {
    Problem problem = sampled_ellipsoid(designs);
    problem.parameters.kinds = {};
    for (const char* name : {"a", "b", "c"}) problem.program_parameters.push_back({name, 0, -M_PI, M_PI, true});
    Quantity f;
    f.names = {"f"};
    f.has_sensitivities = false;
    f.evaluate = [calls](const QuantityRequest& request) {
        if (calls) ++*calls;
        const auto x = [&](std::size_t i) { return request.parameters[i].second; };
        QuantityResult result;
        result.values = {std::sin(x(0)) + 7 * std::pow(std::sin(x(1)), 2) + 0.1 * std::pow(x(2), 4) * std::sin(x(0))};
        return result;
    };
    problem.quantities = {f};
    problem.objective = "f";
    problem.maximize = false;
    problem.constraints.clear();
    return problem;
}

QuantityResult with_value(double value) {
    QuantityResult result;
    result.values = {value};
    return result;
}

Problem spread_by_levels(Problem problem) {
    problem.sample = Spread::levels;
    return problem;
}

std::vector<EvaluationRecord> records_of(const Problem& problem) {
    std::vector<EvaluationRecord> records;
    RunEvents events;
    events.evaluation = [&](const EvaluationRecord& record) { records.push_back(record); };
    const RunResult r = sample(problem, events);
    EXPECT_EQ(r.status, "sampled") << r.reason;
    return records;
}

std::string refusal(const std::function<void()>& work) {
    try {
        work();
    } catch (const InvalidInput& refused) {
        return refused.what();
    } catch (const InputError& refused) {
        return refused.what();
    }
    return "";
}

bool says(const std::string& all, const std::string& words) { return all.find(words) != std::string::npos; }

}  // namespace

TEST(Sample, SpreadsDesignsInsideTheMotionLimit) {
    const Problem problem = sampled_ellipsoid(40);
    std::vector<EvaluationRecord> records;
    RunEvents events;
    events.evaluation = [&](const EvaluationRecord& record) { records.push_back(record); };
    const RunResult r = sample(problem, events);
    EXPECT_EQ(r.status, "sampled") << r.reason;
    EXPECT_TRUE(r.is_done());
    ASSERT_EQ(records.size(), 40u);
    const DesignTable& table = *r.samples->table;
    EXPECT_EQ(table.rows(), 40);
    EXPECT_EQ(table.values, (std::vector<std::string>{"volume", "area"}));
    EXPECT_EQ(table.designs.row(0).norm(), 0);  // the start
    const double limit = problem.parameters.max_displacement * box_diagonal(problem.surface);
    int near = 0, far = 0;
    for (const EvaluationRecord& record : records) {
        EXPECT_EQ(record.status, "ok") << record.reason;
        EXPECT_LE(record.max_displacement, limit * (1 + 1e-9));
        near += record.max_displacement < 0.5 * limit;
        far += record.max_displacement > 0.6 * limit;
    }
    EXPECT_GT(near, 3);
    EXPECT_GT(far, 3);
    // No direction of the design space is left out.
    const Eigen::MatrixXd centred = table.designs.rowwise() - table.designs.colwise().mean();
    const Eigen::VectorXd spread = centred.colwise().norm();
    EXPECT_GT(spread.minCoeff(), 0.01 * spread.maxCoeff());  // of tractions along and across
}

TEST(Sample, IsTheSameEachTimeAndASequenceGoesOn) {
    const RunResult once = sample(sampled_ellipsoid(12)), again = sample(sampled_ellipsoid(12)),
                    longer = sample(sampled_ellipsoid(16));
    EXPECT_EQ(once.samples->table->designs, again.samples->table->designs);
    EXPECT_EQ(once.samples->table->given, again.samples->table->given);
    EXPECT_EQ(once.samples->table->designs, longer.samples->table->designs.topRows(12));
    const RunResult lhs = sample(sampled_ellipsoid(12, Spread::lhs));
    EXPECT_EQ(lhs.status, "sampled");
    EXPECT_NE(once.samples->table->designs, lhs.samples->table->designs);
    Problem other = sampled_ellipsoid(12, Spread::lhs);
    other.optimize.seed = 2;
    EXPECT_NE(sample(other).samples->table->designs, lhs.samples->table->designs);
}

TEST(Sample, LevelsAreAllCombinations) {
    const RunResult r = sample(spread_by_levels(ishigami(28)));
    EXPECT_EQ(r.status, "sampled") << r.reason;
    EXPECT_TRUE(says(r.reason, "3 levels of each variable")) << r.reason;
    EXPECT_TRUE(says(r.reason, "all there are of these levels")) << r.reason;
    const DesignTable& table = *r.samples->table;
    ASSERT_EQ(table.rows(), 27);  // the middle is the start, which is paid once
    std::set<std::vector<int>> seen;
    for (int i = 0; i < 27; ++i) {
        std::vector<int> level;
        for (int j = 0; j < 3; ++j) level.push_back(static_cast<int>(std::lround(table.designs(i, j) / M_PI)));
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(table.designs(i, j), level[static_cast<std::size_t>(j)] * M_PI, 1e-12);
        seen.insert(level);
    }
    EXPECT_EQ(seen.size(), 27u);
    EXPECT_TRUE(says(refusal([] { sample(spread_by_levels(ishigami(8))); }),
                     "two levels of each of 3 variables are 9 designs, and there are 8"));
    EXPECT_TRUE(says(refusal([] { sample(sampled_ellipsoid(40, Spread::levels)); }), "take method sobol or lhs"));
}

TEST(Sample, AnActiveMotionLimitHoldsAndIsReached) {
    const auto largest = [](Spread spread, int designs, double limit) {  // over the limit
        Problem problem = sampled_ellipsoid(designs, spread);
        problem.parameters.max_outward = Eigen::VectorXd::Constant(problem.surface.num_vertices(), limit);
        // Of a vertex that is held: variables have as much room as the largest limit allows.
        problem.parameters.max_outward[problem.surface.triangles(problem.fixed[0], 0)] = 0.05;
        problem.parameters.max_inward = problem.parameters.max_outward;
        double most = 0;
        for (const EvaluationRecord& record : records_of(problem)) {
            EXPECT_EQ(record.status, "ok") << record.reason;
            most = std::max(most, record.max_displacement);
        }
        return most / (limit * box_diagonal(problem.surface));
    };
    for (const auto& [spread, designs] : {std::pair(Spread::levels, 65), std::pair(Spread::lhs, 24)}) {
        const double of_tight = largest(spread, designs, 0.01), of_wide = largest(spread, designs, 0.05);
        EXPECT_LE(of_tight, 1);
        EXPECT_GT(of_tight, spread == Spread::levels ? 0.99 : 0.6);  // the others go a share of the way
        EXPECT_GT(5 * of_wide, 1.2);                                 // without the tight limit designs are beyond it
    }
}

TEST(Sample, MainEffectsOfIshigamisFunction) {
    const RunResult r = sample(ishigami(200));
    ASSERT_EQ(r.status, "sampled") << r.reason;
    ASSERT_EQ(r.samples->values.size(), 1u);
    const SampledValue& f = r.samples->values[0];
    const double p4 = std::pow(M_PI, 4), V = 49.0 / 8 + 0.1 * p4 / 5 + 0.01 * p4 * p4 / 18 + 0.5;
    const double exact[] = {0.5 * std::pow(1 + 0.1 * p4 / 5, 2) / V, 49.0 / 8 / V, 0};
    for (int j = 0; j < 3; ++j) {
        EXPECT_NEAR(f.share[j], exact[j], 0.02) << j;
        EXPECT_LT(f.error[j], 0.02);
    }
    // With interactions: x1 and x3 have V13 = 8 b^2 pi^8 / 225 together.
    const double V13 = 8 * 0.01 * p4 * p4 / 225;
    const double total[] = {exact[0] + V13 / V, exact[1], V13 / V};
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(f.total[j], total[j], 0.02) << j;
    EXPECT_TRUE(r.samples->remarks.empty()) << r.samples->remarks[0];  // x3 is not without effect
    EXPECT_GT(f.predicted_share, 0.97);
    EXPECT_EQ(r.samples->lower[0], -M_PI);
    EXPECT_FALSE(says(sample(ishigami(8)).samples->without_effects, "nan"));
    EXPECT_TRUE(says(sample(ishigami(8)).samples->without_effects, "at least 10"));
}

TEST(Sample, DesignsThatFailAreRowsWithoutValues) {
    Problem problem = ishigami(32);
    Quantity& f = problem.quantities[0];
    f.failing_shortens_step = true;
    f.evaluate = [inner = f.evaluate](const QuantityRequest& request) {
        if (request.parameters[0].second <= 1) return inner(request);
        QuantityResult result;
        result.failure = Failure{"exit", "status 1"};
        return result;
    };
    const RunResult r = sample(problem);
    EXPECT_EQ(r.status, "sampled");
    const DesignTable& table = *r.samples->table;
    int failed = 0;
    for (int i = 0; i < table.rows(); ++i) {
        const bool fails = table.designs(i, 0) > 1;
        failed += fails;
        EXPECT_EQ(table.status[i] == "ok", !fails);
        EXPECT_EQ(std::isnan(table.given(i, 0)), fails);
    }
    EXPECT_GT(failed, 5);
    EXPECT_TRUE(says(r.reason, std::to_string(failed) + " of them without a value")) << r.reason;
    f.failing_shortens_step = false;
    EXPECT_EQ(sample(problem).status, "evaluation_failed");
}

TEST(Sample, SaysWhatIsOddWithARemedy) {
    Problem constant = ishigami(16);
    constant.quantities[0].evaluate = [](const QuantityRequest&) { return with_value(2.5); };
    const auto of_constant = sample(constant).samples->remarks;
    ASSERT_EQ(of_constant.size(), 1u);
    EXPECT_TRUE(says(of_constant[0], "f is 2.5 in all 16 designs")) << of_constant[0];
    EXPECT_TRUE(says(of_constant[0], "check that it depends on")) << of_constant[0];

    Problem without = ishigami(40);
    without.quantities[0].evaluate = [](const QuantityRequest& request) {
        return with_value(std::sin(request.parameters[0].second));
    };
    const auto of_idle = sample(without).samples->remarks;
    ASSERT_EQ(of_idle.size(), 1u);
    EXPECT_TRUE(says(of_idle[0], "b, c have no effect on any value")) << of_idle[0];

    DesignTable table = *sample(ishigami(16)).samples->table;
    Problem read = ishigami(2);
    const auto remarks_of = [&](const DesignTable& t) {
        read.table = std::make_shared<const DesignTable>(t);
        return sample(read).samples->remarks;
    };
    EXPECT_TRUE(remarks_of(table).empty());
    table.designs.row(9) = table.designs.row(4);
    ASSERT_EQ(remarks_of(table).size(), 1u);
    EXPECT_TRUE(says(remarks_of(table)[0], "rows 5 and 10 are the same design, with f = ")) << remarks_of(table)[0];
    table.given(9, 0) = table.given(4, 0);
    EXPECT_TRUE(says(remarks_of(table)[0], "rows 5 and 10 are the same design: the second says nothing new; remove"));
}

/// A model of thousands of designs would take hours: a part of them is enough for the same answer.
TEST(Sample, ManyDesignsAreLearnedFromAPartOfThem) {
    DesignTable table;
    table.name = "many.csv";
    table.variables = {"a", "b", "c"};
    table.values = {"f"};
    table.designs = M_PI * (2 * sobol_points(0, 4000, 3).array() - 1);
    table.given = (table.designs.col(0).array().sin() + 2 * table.designs.col(1).array().sin()).matrix();
    table.status.assign(4000, "ok");
    SampleSummary samples;
    samples.table = std::make_shared<const DesignTable>(table);
    const Problem problem = ishigami(2);
    const RunEvents events;
    RunState state(problem, events, {});
    state.next_level({});
    learn(problem, state.space, samples);
    ASSERT_FALSE(samples.remarks.empty());
    EXPECT_TRUE(says(samples.remarks[0], "500 of the 4000 designs"));
    EXPECT_NEAR(samples.values[0].share[0], 0.2, 0.01);
    EXPECT_NEAR(samples.values[0].share[1], 0.8, 0.01);
}

TEST(DesignTable, GoesThroughAFileAndSaysWhatIsWrong) {
    const TempFolder folder;
    const RunResult r = sample(ishigami(16));
    const DesignTable& table = *r.samples->table;
    const auto read = [&](const std::string& text) { return read_table(folder.write("t.csv", text), {"f"}); };
    const DesignTable back = read(table_csv(table));
    EXPECT_EQ(back.variables, table.variables);
    EXPECT_EQ(back.designs, table.designs);
    EXPECT_EQ(back.given, table.given);
    const DesignTable turned = with_variables(read("f, c, a, b\n1, 2, 3, 4\n,5,6,7\n"), {"a", "b", "c"});
    EXPECT_EQ(turned.designs(0, 0), 3);
    EXPECT_EQ(turned.designs(0, 2), 2);
    EXPECT_EQ(turned.status[1], "no_value");
    const auto refused = [&](const std::string& text) { return refusal([&] { read(text); }); };
    EXPECT_EQ(read("\xEF\xBB\xBF"
                   "a,f\n1,2\n")
                  .variables[0],
              "a")
        << "as spreadsheets begin";
    EXPECT_EQ(read("a,f\n1,NAN\n").status[0], "no_value");
    EXPECT_TRUE(says(refused(""), "t.csv:1: the table is empty"));
    EXPECT_TRUE(says(refused("a;f\n1;2\n"), "t.csv:1: columns are separated by ';'"));
    EXPECT_TRUE(says(refused("a,f,\n1,2,\n"), "t.csv:1: column 3 has no name"));
    EXPECT_TRUE(says(refused("a,b,c\n1,2,3\n"), "no column is one of the values of the case (f)"));
    EXPECT_TRUE(says(refused("a,f\n1,x\n"), "t.csv:2: column 'f': 'x' is not a finite number; leave"));
    EXPECT_TRUE(says(refused("a,f\n1,2\ninf,3\n"), "t.csv:3: column 'a': 'inf' is not a finite number; correct it"));
    EXPECT_TRUE(says(refused("a,f\n1\n"), "t.csv:2: has 1 fields"));
    EXPECT_TRUE(says(refused("a,a,f\n1,1,1\n"), "two columns are called 'a'"));
    EXPECT_TRUE(says(refused("a,f\n"), "there is no row"));
    EXPECT_TRUE(says(refusal([&] { with_variables(read("a,d,f\n1,2,3\n"), {"a"}); }), "column 'd' is neither"));
    EXPECT_TRUE(says(refusal([&] { with_variables(read("a,f\n1,2\n"), {"a", "b"}); }), "variable 'b'"));
}

TEST(Sample, ATableIsReadAndNothingIsCalled) {
    int calls = 0;
    const RunResult r = sample(ishigami(64));
    Problem problem = ishigami(2, &calls);
    problem.table = std::make_shared<const DesignTable>(*r.samples->table);
    const RunResult read = sample(problem);
    EXPECT_EQ(read.status, "sampled") << read.reason;
    EXPECT_EQ(calls, 0);
    EXPECT_LT((read.samples->table->designs - r.samples->table->designs).lpNorm<Eigen::Infinity>(), 1e-14);
    EXPECT_EQ(read.samples->table->given, r.samples->table->given);
    EXPECT_EQ(read.best_evaluation, r.best_evaluation);
    DesignTable beyond = *r.samples->table;
    beyond.designs(3, 1) = 4;
    problem.table = std::make_shared<const DesignTable>(beyond);
    EXPECT_TRUE(says(refusal([&] { sample(problem); }), "row 4: b = 4 is outside of its bounds, -3.14159"));
    int rows = 0;
    RunEvents events;
    events.evaluation = [&](const EvaluationRecord&) { ++rows; };
    EXPECT_THROW(sample(problem, events), InvalidInput);
    EXPECT_EQ(rows, 0) << "known before anything is evaluated";
}

/// The middle of the sequence is the start where only parameters vary: nobody pays for it twice.
TEST(Sample, NoDesignIsTheStartAgain) {
    const DesignTable table = *sample(ishigami(20)).samples->table;
    for (int i = 1; i < table.rows(); ++i)
        EXPECT_GT((table.designs.row(i) - table.designs.row(0)).lpNorm<Eigen::Infinity>(), 1e-3) << i;
}

/// Samples jump across the whole space: what a design gives is what it gives alone, from rest.
TEST(Sample, NoDesignFailsForTheOneBeforeIt) {
    Problem problem = sampled_ellipsoid(16);
    problem.parameters.max_displacement = 0.25;
    problem.constraints.clear();
    const DesignTable together = *sample(problem).samples->table;
    Problem alone = problem;
    for (int i = 0; i < together.rows(); ++i) {
        DesignTable row = together;
        row.name = "row.csv";
        row.designs = together.designs.row(i);
        row.given = Eigen::MatrixXd::Zero(1, together.given.cols());
        row.status = {"ok"};
        alone.table = std::make_shared<const DesignTable>(row);
        EXPECT_EQ(sample(alone).samples->table->status[0], together.status[static_cast<std::size_t>(i)]) << i;
    }
}

}  // namespace strake
