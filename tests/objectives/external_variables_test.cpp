#include "external_fixture.hpp"

#include <nlohmann/json.hpp>

/// Own variables of a case: what a program is told of them, and the derivatives that it gives.
using namespace strake;

class ExternalVariables : public ExternalTest {
protected:
    QuantityResult ask_about(const ExternalCommand& command, bool sensitivities = true) {
        return external(command).evaluate(
            {mesh, sensitivities, ++asked_, 2, {{"tip.load_x", -2}}, {{"alpha", 0.25}, {"speed", 3}}});
    }
    nlohmann::json request() const {
        char number[16];
        std::snprintf(number, sizeof number, "%06d", asked_);
        return nlohmann::json::parse(contents(folder / "evaluations" / number / "request.json"));
    }
    std::string failure_of(const std::string& role) {
        const QuantityResult result = ask_about(fake(role));
        return result.failure ? result.failure->kind + ": " + result.failure->message : "";
    }

private:
    int asked_ = 0;
};

TEST_F(ExternalVariables, AreHandedOverAndDifferentiated) {
    for (const char* role : {"by_alpha", "by_alpha_short"}) {
        const QuantityResult result = ask_about(fake(role));
        ASSERT_FALSE(result.failure) << role << ": " << result.failure->message;
        EXPECT_NEAR(result.values.at(0), mesh.vertices.sum() + 0.5, 1e-12);
        ASSERT_EQ(result.dJ_dp.size(), 1u);
        EXPECT_EQ(result.dJ_dp[0], Eigen::Vector2d(2, -1));
        EXPECT_EQ(request()["variables"]["alpha"], 0.25);
        EXPECT_EQ(request()["variables"]["tip.load_x"], -2);
        EXPECT_EQ(request()["wanted"]["variables"], (std::vector<std::string>{"alpha", "speed"}));
    }
    EXPECT_FALSE(ask_about(fake("ok"), false).failure) << "nothing is missed where no gradient is wanted";
    EXPECT_TRUE(request()["wanted"]["variables"].empty());
}

TEST_F(ExternalVariables, AMissingDerivativeIsNeverTakenForZero) {
    EXPECT_TRUE(has(failure_of("ok"), "missing_key: ")) << failure_of("ok");
    EXPECT_TRUE(has(failure_of("ok"), "derivative of 'value' by 'alpha'"));
    EXPECT_TRUE(has(failure_of("by_alpha_only"), "no 'speed'")) << failure_of("by_alpha_only");
    EXPECT_TRUE(has(failure_of("by_alhpa"), "did you mean 'alpha'")) << failure_of("by_alhpa");
    EXPECT_TRUE(has(failure_of("by_other_value"), "no 'value' in 'variables'")) << failure_of("by_other_value");
    EXPECT_TRUE(has(failure_of("by_word"), "wrong_type: ")) << failure_of("by_word");
}

TEST_F(ExternalVariables, MayBeMissingWhereDifferencesAreAllowed) {
    ExternalCommand command = fake("by_alpha_only");
    command.may_lack_derivatives = true;
    const QuantityResult result = ask_about(command);
    ASSERT_FALSE(result.failure) << result.failure->message;
    EXPECT_EQ(result.dJ_dp.at(0)[0], 2);
    EXPECT_TRUE(std::isnan(result.dJ_dp.at(0)[1]));
    command = fake("by_alhpa");
    command.may_lack_derivatives = true;
    ASSERT_TRUE(ask_about(command).failure) << "a slip of the pen is one all the same";
}

TEST_F(ExternalVariables, ThatItDoesNotDependOnAreZero) {
    ExternalCommand command = fake("by_alpha_only");
    command.depends_on = {"alpha"};
    const QuantityResult result = ask_about(command);
    ASSERT_FALSE(result.failure) << result.failure->message;
    EXPECT_EQ(result.dJ_dp.at(0), Eigen::Vector2d(2, 0));
    EXPECT_EQ(request()["wanted"]["variables"], std::vector<std::string>{"alpha"});
    EXPECT_EQ(request()["variables"]["speed"], 3) << "told all the same";
    command = fake("ok");
    command.depends_on.emplace();
    const QuantityResult shape_only = ask_about(command);
    ASSERT_FALSE(shape_only.failure) << shape_only.failure->message;
    EXPECT_TRUE(shape_only.dJ_dp.at(0).isZero(0));
}
