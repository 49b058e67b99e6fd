#include "objectives/formula/expression.hpp"

#include "ask.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

namespace {

const std::vector<std::string> known{"a", "b", "aero.drag", "aero", "x-y", "sin", "e1"};

double at(const std::string& formula, const std::vector<double>& values = {}) {
    return Expression(formula, known).value(Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)));
}
std::string error(const std::string& formula) {
    return refusal([&] { Expression(formula, known); });
}

}  // namespace

TEST(Expression, Arithmetic) {
    EXPECT_EQ(at("1 + 2 * 3"), 7);
    EXPECT_EQ(at("(1 + 2) * 3"), 9);
    EXPECT_EQ(at("2 - 3 - 4"), -5);
    EXPECT_EQ(at("8 / 4 / 2"), 1);
    EXPECT_EQ(at("-2^2"), -4);
    EXPECT_EQ(at("2^3^2"), 512);
    EXPECT_EQ(at("2^-1"), 0.5);
    EXPECT_EQ(at("- -3 + +1"), 4);
    EXPECT_EQ(at("1e-3*.5"), 0.0005);
    EXPECT_EQ(at("min(3, 1, 2) + max(3, 1, 2)"), 4);
    EXPECT_DOUBLE_EQ(at("cos(pi) + sqrt(16) + log(exp(2)) + log10(100)"), 7);
    EXPECT_NEAR(at("softmin(0.1, 1, 1)"), 1 - 0.1 * std::log(2.0), 1e-15);
    EXPECT_NEAR(at("softmax(1e-3, 1, 5)"), 5, 1e-15);
}

TEST(Expression, Names) {
    EXPECT_EQ(Expression("b + a * b", known).names(), (std::vector<std::string>{"b", "a"}));
    EXPECT_EQ(at("aero.drag / aero", {6, 2}), 3);
    EXPECT_EQ(at("x-y", {5}), 5);     // a known name with a dash
    EXPECT_EQ(at("a-b", {5, 2}), 3);  // a difference
    EXPECT_EQ(at("a-2", {5}), 3);
    EXPECT_EQ(at("x-y-a", {5, 1}), 4);
    const std::vector<std::string> numbered{"x", "x-1"};
    const auto of_numbered = [&](const std::string& formula) {
        return Expression(formula, numbered).value(Eigen::VectorXd::Constant(1, 12));
    };
    EXPECT_EQ(of_numbered("x-10"), 2) << "a name never ends within a number";
    EXPECT_EQ(of_numbered("x-1.5"), 10.5);
    EXPECT_EQ(of_numbered("x-1e1"), 2);
    EXPECT_EQ(of_numbered("x-1"), 12);
    EXPECT_EQ(at("sin*2", {4}), 8) << "a quantity hides the function of its name";
    EXPECT_EQ(at("2*e1", {4}), 8);
}

TEST(Expression, DerivativesAreExact) {
    const std::string formulas[] = {"a*b/(1+a^2)",
                                    "a^b + b^3 - 2^a",
                                    "sqrt(a)*exp(-b)*log(a+b)",
                                    "sin(a)*cos(b)+tan(a*b/9)",
                                    "asin(a/9)+acos(b/9)-atan(a*b)+tanh(a-b)",
                                    "abs(a-b)*log10(a)",
                                    "min(a^2,b^3,a*b)+max(a^2,b)",
                                    "softmin(0.3*a, a, b, 1.1)+softmax(b, a, 2)"};
    for (const std::string& formula : formulas) {
        const Expression e(formula, {"a", "b"});
        Eigen::VectorXd x(2), g, p(2);
        x << 1.3, 0.7;
        p << 0.6, -0.8;
        e.value(x, &g);
        const auto J = [&](const Eigen::VectorXd& y) {
            Eigen::VectorXd in_order(2);
            for (int i = 0; i < 2; ++i) in_order[i] = y[i];
            return e.value(in_order);
        };
        EXPECT_NEAR(taylor_order(J, x, g, p), 2, 0.15) << formula;
        EXPECT_NEAR(taylor_order(J, x, 1.3 * g, p), 1, 0.15) << formula;
    }
}

TEST(Expression, WhatIsConstantHasNoDerivative) {
    Eigen::VectorXd x(1), g;
    x << 0;
    EXPECT_EQ(Expression("0^0.5 + a", {"a"}).value(x, &g), 0);
    EXPECT_EQ(g[0], 1);
    EXPECT_EQ(Expression("a^2", {"a"}).value(x, &g), 0);
    EXPECT_EQ(g[0], 0);
    EXPECT_FALSE(std::isfinite(at("log(-1)")));
    EXPECT_FALSE(std::isfinite(at("1/0")));
    EXPECT_FALSE(std::isfinite(at("softmin(0, 1, 2)")));
}

TEST(Expression, ErrorsNameTheColumn) {
    EXPECT_TRUE(has(error("a + "), "column 5: a number, a name or '(' expected, got the end"));
    EXPECT_TRUE(has(error("(a"), "column 3: ')' expected, got the end"));
    EXPECT_TRUE(has(error("a b"), "column 3: an operator expected, got 'b'"));
    EXPECT_TRUE(has(error("2a"), "column 2: an operator expected"));
    EXPECT_TRUE(has(error("c"), "'c' is not known; there are: a, b"));
    EXPECT_TRUE(has(error("sqrt(1, 2)"), "sqrt takes 1 argument, got 2"));
    EXPECT_TRUE(has(error("min(1)"), "min takes at least 2 arguments, got 1"));
    EXPECT_TRUE(has(error("exp 2"), "'(' expected after exp"));
    EXPECT_TRUE(has(error(""), "expected"));
    EXPECT_TRUE(has(error("1e999"), "not a number"));
    EXPECT_TRUE(has(error(std::string(200, '(')), "nested deeper than 100"));
    EXPECT_TRUE(has(error(std::string(200, '-') + "1"), "nested deeper than 100"));
    EXPECT_TRUE(has(error(std::string(20000, '1')), "too long"));
}
