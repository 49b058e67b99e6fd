#include "objectives/external/gradient.hpp"

#include "core/error.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/refused.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

const TriMesh flap = hinge(2, 1);  // four vertices

std::string kind(const std::string& bytes, double tolerance = 1e-5) {
    try {
        parse_gradient(bytes, "g.csv", flap, tolerance);
    } catch (const Refused& refused) {
        return refused.failure.kind;
    }
    return "";
}

std::string by_place(double shift) {
    std::string rows;
    for (int v = 3; v >= 0; --v)
        rows += text(flap.vertices(v, 0) + shift, ",", flap.vertices(v, 1), ",", flap.vertices(v, 2), ",", v, ",0,0\n");
    return rows;
}

}  // namespace

TEST(GradientFile, RowsInAnyOrderWithHeaderCommentsAndBlanks) {
    const Points g = parse_gradient(
        "index, x, y, z\r\n# note\r\n\r\n3, 1,2, 3\r\n 1,4,5,6\r\n0.0,7,8,9\r\n2e0,-1,+2,1D-1", "g.csv", flap, 1e-5);
    Points want(4, 3);
    want << 7, 8, 9, 4, 5, 6, -1, 2, 0.1, 1, 2, 3;
    EXPECT_EQ(g, want);
}

TEST(GradientFile, CoordinatesMatchWithinTheToleranceOnly) {
    const Points g = parse_gradient(by_place(0.9e-5), "g.csv", flap, 1e-5);
    for (int v = 0; v < 4; ++v) EXPECT_EQ(g(v, 0), v);
    EXPECT_EQ(kind(by_place(1.1e-5)), "wrong_count");
    EXPECT_EQ(kind("1e300,0,0,1,1,1\n"), "wrong_count");
}

TEST(GradientFile, NearestVertexWinsWhereTwoAreWithinTheTolerance) {
    EXPECT_EQ(kind(by_place(0), 10), "");
    EXPECT_EQ(kind(by_place(0.1), 10), "");
}

TEST(GradientFile, EverythingElseIsRefused) {
    EXPECT_EQ(kind(""), "wrong_count");
    EXPECT_EQ(kind("header\nheader\n"), "unreadable");
    EXPECT_EQ(kind("0,1,2,3\n1,1,2,3\n2,1,2,3\n"), "wrong_count");
    EXPECT_EQ(kind("0,1,2,3\n0,1,2,3\n"), "wrong_count");
    EXPECT_EQ(kind("-1,1,2,3\n"), "wrong_count");
    EXPECT_EQ(kind("4,1,2,3\n"), "wrong_count");
    EXPECT_EQ(kind("99999999999999999999,1,2,3\n"), "wrong_count");
    EXPECT_EQ(kind("0.5,1,2,3\n"), "unreadable");
    EXPECT_EQ(kind("0,1,2\n"), "unreadable");
    EXPECT_EQ(kind("0,1,2,3,4\n"), "unreadable");
    EXPECT_EQ(kind("0,1,2,3,4,5,6,7,8\n"), "unreadable");
    EXPECT_EQ(kind("0,1,2,3\n1,0,0,1,1,1\n"), "unreadable");
    EXPECT_EQ(kind("0,1,,3\n"), "unreadable");
    EXPECT_EQ(kind("0,1,1.0.0,3\n"), "unreadable");
    EXPECT_EQ(kind("0;1;2;3\n1;1;2;3\n"), "unreadable");
    EXPECT_EQ(kind("0,1,inf,3\n"), "not_finite");
    EXPECT_EQ(kind("0,1,1e400,3\n"), "not_finite");
}

TEST(Number, IsReadStrictlyAndWithoutLocale) {
    double value = -1;
    EXPECT_EQ(parse_number(" +1.5 ", value), NumberIs::finite);
    EXPECT_EQ(value, 1.5);
    EXPECT_EQ(parse_number("1e-400", value), NumberIs::finite);
    EXPECT_EQ(value, 0);
    for (const char* wrong : {"", " ", "+", "+-1", "1 2", "1,5", "0x10", "abc", "1e"})
        EXPECT_EQ(parse_number(wrong, value), NumberIs::not_a_number) << wrong;
    for (const char* large : {"nan", "-inf", "1e400", "-1E+400"})
        EXPECT_EQ(parse_number(large, value), NumberIs::not_finite) << large;
}
