#include "optimize/nlp/surrogate/pace.hpp"

#include "optimize/nlp/minimizer.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>

/// Searches by models that go on while they gain.
namespace strake {
namespace {

using Eigen::VectorXd;

double first(const VectorXd& values) { return values[0]; }

/// Noted after so many evaluations each.
bool holds(const std::vector<std::pair<int, double>>& notes, double share = 0.25) {
    Pace pace;
    for (const auto& [evaluations, value] : notes) pace.note(evaluations, vec({value}));
    return pace.holds(share, first);
}

TEST(Pace, HoldsWhereTheLastQuarterGainsItsShare) {
    EXPECT_TRUE(holds({{0, 8}, {8, 6}, {16, 4}, {24, 2}, {32, 0}})) << "evenly";
    EXPECT_TRUE(holds({{0, 8}, {8, 8}, {16, 8}, {24, 8}, {32, 7}})) << "only then";
    EXPECT_FALSE(holds({{0, 8}, {8, 3}, {16, 2}, {24, 1.5}, {32, 0}})) << "3/16 of it";
    EXPECT_TRUE(holds({{0, 8}, {8, 3}, {16, 2}, {24, 1.5}, {32, 0}}, 0.1875));
    EXPECT_FALSE(holds({{0, 8}, {8, 8}, {16, 8}, {24, 8}, {32, 8}}, 0.01)) << "nothing is no share of nothing";
    EXPECT_TRUE(holds({{0, 8}, {8, 3}, {16, 2}, {24, 2}, {32, 0}}));
    EXPECT_FALSE(holds({{0, 8}, {8, 8}, {16, 8}, {24, 8}, {32, 8}})) << "nothing";
    EXPECT_FALSE(holds({{0, 8}})) << "the start alone";
    EXPECT_FALSE(holds({}));
    EXPECT_TRUE(holds({{100, 8}, {108, 6}, {116, 4}, {124, 2}, {132, 0}})) << "from where the search began";
}

TEST(Pace, AQuarterIsOfWhatTheSearchHasSpent) {
    Pace pace;
    EXPECT_EQ(pace.part(), 0);
    pace.note(10, vec({1}));
    EXPECT_EQ(pace.part(), 0);
    pace.note(50, vec({0}));
    EXPECT_EQ(pace.part(), 10);
}

/// The penalty of constraints is what it is now, not what it was when values were noted.
TEST(Pace, IsOfTheMeritThatIsAsked) {
    Pace pace;
    for (int k = 0; k < 5; ++k) pace.note(8 * k, vec({double(4 - k), k < 4 ? 0.0 : 10.0}));
    EXPECT_TRUE(pace.holds(0.25, first));
    EXPECT_FALSE(pace.holds(0.25, [](const VectorXd& values) { return values[0] + values[1]; }));
}

TEST(Pace, LessThanNoiseIsNone) {
    Pace pace;
    for (int k = 0; k < 5; ++k) pace.note(8 * k, vec({8.0 - 2 * k}));
    EXPECT_TRUE(pace.holds(0.25, first, 1.9));
    EXPECT_FALSE(pace.holds(0.25, first, 2));
}

/// What counts no more by the present penalty, as the best of a time without one, does not make a pace.
TEST(Pace, CountsFromTheLowestMeritBefore) {
    EXPECT_FALSE(holds({{0, 8}, {8, 1}, {16, 1}, {24, 7}, {32, 0.5}}));
    EXPECT_TRUE(holds({{0, 8}, {8, 7}, {16, 6}, {24, 7}, {32, 0.5}}));
}

/// The distance from a point far away falls by as much with each step, that from one near by does not for long.
MinimizeResult approached(double distance, int limit_while_gaining, std::vector<std::string>* events = nullptr,
                          double gaining_share = MinimizeOptions().gaining_share) {
    NonlinearProgram p;
    p.start = VectorXd::Zero(3);
    p.lower = VectorXd::Constant(3, -1e3);
    p.upper = VectorXd::Constant(3, 1e3);
    p.evaluate = [=](const VectorXd& x) {
        Evaluation at;
        at.objective = std::sqrt(1 + (x - VectorXd::Constant(3, distance)).squaredNorm());
        return at;
    };
    MinimizeOptions how;
    how.method = Method::model;
    how.batch = 4;
    how.max_evaluations = 24;
    how.limit_while_gaining = limit_while_gaining;
    how.gaining_share = gaining_share;
    how.scope = " of level 3";
    if (events) how.on_event = [=](const std::string& words) { events->push_back(words); };
    return minimize(p, how);
}

TEST(Pace, ASearchThatGainsGoesOnToItsLastLimit) {
    std::vector<std::string> events;
    const MinimizeResult ends = approached(300, 0, &events), goes_on = approached(300, 60, &events);
    EXPECT_EQ(ends.evaluations, 24);
    EXPECT_GT(goes_on.evaluations, 56) << "less than a batch is left";
    EXPECT_LE(goes_on.evaluations, 60);
    EXPECT_LT(goes_on.best.objective, ends.best.objective);
    EXPECT_NE(goes_on.reason.find("limit of evaluations of level 3 is reached (6"), std::string::npos)
        << goes_on.reason;
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(
        events[0],
        "the limit of evaluations of level 3 grows by 5: the last quarter of them has gained 15 % of all or more");
}

TEST(Pace, HowMuchASearchMustGainToGoOnIsStated) {
    std::vector<std::string> events;
    EXPECT_EQ(approached(300, 60, &events, 1).evaluations, 24) << "no last quarter gains it all";
    EXPECT_TRUE(events.empty()) << events[0];
}

TEST(Pace, ASearchThatHasComeToRestEndsAtItsLimit) {
    std::vector<std::string> events;
    const MinimizeResult r = approached(0.4, 60, &events);
    EXPECT_LE(r.evaluations, 24);
    EXPECT_TRUE(events.empty()) << events[0];
}

}  // namespace
}  // namespace strake
