#include "optimize/evaluate/constraints.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

Constraint limit_of(std::optional<double> min, std::optional<double> max, std::optional<double> equals) {
    return {"pitch", min, max, equals, true};
}

ConstraintRows rows_for(const Constraint& constraint, double start) {
    return constraint_rows({constraint}, {0}, {-1}, {start});
}

bool meets(const ConstraintRows& rows, double value) {
    for (std::size_t i = 0; i < rows.rows.size(); ++i) {
        const double c = rows.rows[i].of(value);
        if (static_cast<int>(i) < rows.num_inequalities ? c > 1e-12 : std::abs(c) > 1e-12) return false;
    }
    return true;
}

}  // namespace

TEST(Constraints, SharesOfANegativeStartAreShares) {
    const ConstraintRows both = rows_for(limit_of(0.9, 1.1, {}), -0.05);
    EXPECT_TRUE(meets(both, -0.05));
    EXPECT_TRUE(meets(both, -0.0451));
    EXPECT_TRUE(meets(both, -0.0549));
    EXPECT_FALSE(meets(both, -0.0449));
    EXPECT_FALSE(meets(both, -0.0551));
    const ConstraintRows least = rows_for(limit_of(0.9, {}, {}), -0.05);
    EXPECT_TRUE(meets(least, -1)) << "more of it";
    EXPECT_FALSE(meets(least, 0.05));
    const ConstraintRows most = rows_for(limit_of({}, 1.1, {}), -0.05);
    EXPECT_TRUE(meets(most, 0.05));
    EXPECT_FALSE(meets(most, -0.06));
    EXPECT_TRUE(meets(rows_for(limit_of({}, {}, 2.0), -0.05), -0.1));
    EXPECT_FALSE(meets(rows_for(limit_of({}, {}, 2.0), -0.05), 0.1));
}

TEST(Constraints, SharesOfAPositiveStartStayWhatTheyWere) {
    const ConstraintRows both = rows_for(limit_of(0.9, 1.1, {}), 50);
    EXPECT_TRUE(meets(both, 45.1) && meets(both, 54.9));
    EXPECT_FALSE(meets(both, 44.9) || meets(both, 55.1));
    EXPECT_EQ(both.num_inequalities, 2);
}

TEST(Constraints, SharesOfNothingAreRefusedWithTheRemedy) {
    for (const Constraint& constraint : {limit_of(0.9, {}, {}), limit_of({}, 1.1, {}), limit_of({}, {}, 1.0)}) try {
            rows_for(constraint, 0);
            ADD_FAILURE() << "not refused";
        } catch (const InvalidInput& e) {
            const std::string words = e.what();
            EXPECT_NE(words.find("pitch"), std::string::npos) << words;
            EXPECT_NE(words.find("without `relative`"), std::string::npos) << words;
        }
    Constraint absolute = limit_of(-1.0, 1.0, {});
    absolute.relative = false;
    EXPECT_TRUE(meets(rows_for(absolute, 0), 0));
}
