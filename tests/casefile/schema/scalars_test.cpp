#include "casefile/schema/scalars.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

namespace strake {
namespace {

struct Row {
    Type type;
    const char* text;
    double value;  ///< NaN: refused
    bool quoted = false;
};
const double refused = std::nan("");
constexpr double pi = std::numbers::pi;

/// What YAML tools read in different ways: each accepted or refused on purpose.
const Row table[] = {
    {Type::number, "0.5", 0.5},
    {Type::number, ".5", 0.5},
    {Type::number, "-1e-3", -1e-3},
    {Type::number, "+2", 2},
    {Type::number, "1e400", refused},
    {Type::number, "1e-400", refused},
    {Type::number, ".inf", refused},
    {Type::number, "-.inf", refused},
    {Type::number, "inf", refused},
    {Type::number, ".nan", refused},
    {Type::number, "NaN", refused},
    {Type::number, "nan", refused},
    {Type::number, "12abc", refused},
    {Type::number, "1_000", refused},
    {Type::number, "1,5", refused},
    {Type::number, "1.0.0", refused},
    {Type::number, "0x10", refused},
    {Type::number, "010", refused},
    {Type::number, "-010", refused},
    {Type::number, "0o10", refused},
    {Type::number, "1:30", refused},
    {Type::number, "3", refused, true},
    {Type::number, "", refused, true},
    {Type::number, "-", refused},
    {Type::number, "+-1", refused},
    {Type::number, "--1", refused},
    {Type::number, "1 000", refused},
    {Type::number, "5%", refused},
    {Type::integer, "5", 5},
    {Type::integer, "-7", -7},
    {Type::integer, "+7", 7},
    {Type::integer, "0", 0},
    {Type::integer, "5.7", refused},
    {Type::integer, "5.0", refused},
    {Type::integer, "1e3", refused},
    {Type::integer, "010", refused},
    {Type::integer, "99999999999", refused},
    {Type::integer, "2147483647", 2147483647},
    {Type::integer, "2147483648", refused},
    {Type::integer, "5", refused, true},
    {Type::flag, "true", 1},
    {Type::flag, "false", 0},
    {Type::flag, "yes", refused},
    {Type::flag, "on", refused},
    {Type::flag, "True", refused},
    {Type::flag, "1", refused},
    {Type::flag, "true", refused, true},
    {Type::fraction, "1%", 0.01},
    {Type::fraction, "1 %", 0.01},
    {Type::fraction, "0.01", 0.01},
    {Type::fraction, "1e2%", 1},
    {Type::fraction, "%", refused},
    {Type::fraction, "1%%", refused},
    {Type::angle, "180deg", pi},
    {Type::angle, "180 deg", pi},
    {Type::angle, "0.5rad", 0.5},
    {Type::angle, "0", 0},
    {Type::angle, "5", refused},
    {Type::angle, "5grad", refused},
    {Type::angle, "5Deg", refused},
    {Type::angle, "deg", refused},
    {Type::duration, "90s", 90},
    {Type::duration, "1.5min", 90},
    {Type::duration, "2h", 7200},
    {Type::duration, "30", refused},
    {Type::duration, "2d", refused},
    {Type::duration, "1e308h", refused},
    {Type::length, "2.5", 2.5},
    {Type::length, "5cm", 50},
    {Type::length, "5 cm", 50},
    {Type::length, "1in", 25.4},
    {Type::length, "1ft", 304.8},
    {Type::length, "7um", 0.007},
    {Type::length, "2m", 2000},
    {Type::length, "0.1mm", 0.1},
    {Type::length, "5%", 0.05},
    {Type::length, "5km", refused},
    {Type::length, "mm", refused},
    {Type::length, "nan mm", refused},
    {Type::length, "010mm", refused},
    {Type::length, "1e308m", refused},
    {Type::coordinate, "5cm", 50},
    {Type::coordinate, "5%", refused},
};

TEST(Scalars, EachIsAcceptedOrRefusedOnPurpose) {
    for (const Row& row : table) {
        Value value;
        value.text = row.text;
        value.quoted = row.quoted;
        const std::string error = convert_scalar(value, row.type, Key{}, {".", "mm"});
        const std::string shown = text("type ", static_cast<int>(row.type), " '", row.text, "': ", error);
        EXPECT_EQ(error.empty(), !std::isnan(row.value)) << shown;
        if (error.empty()) {
            EXPECT_DOUBLE_EQ(value.number, row.value) << shown;
        }
    }
}

TEST(Scalars, PercentagesOfLengthsAreRelative) {
    Value relative, absolute;
    relative.text = "5%";
    absolute.text = "5mm";
    EXPECT_EQ(convert_scalar(relative, Type::length, Key{}, {".", ""}), "");
    EXPECT_TRUE(relative.relative);
    EXPECT_EQ(convert_scalar(absolute, Type::length, Key{}, {".", ""}),
              "has a unit, but surface.units does not state the unit of the surface; state it, or leave the unit out");
    EXPECT_EQ(convert_scalar(absolute, Type::length, Key{}, {".", "mm"}), "");
    EXPECT_FALSE(absolute.relative);
}

TEST(Scalars, LimitsAreNamedInTheUnitOfTheValue) {
    Value value;
    value.text = "190deg";
    const Key key{.path = "k", .limits = {0, 90, true, false}};
    EXPECT_EQ(convert_scalar(value, Type::angle, key, {}), "must be in (0deg, 90deg]");
    value.text = "90deg";
    EXPECT_EQ(convert_scalar(value, Type::angle, key, {}), "");
    value.text = "100%";
    EXPECT_EQ(convert_scalar(value, Type::fraction, {.path = "k", .limits = {0, 1, false, true}}, {}),
              "must be in [0%, 100%)");
}

TEST(Scalars, DegreesComeBackAsWritten) {
    for (const double angle : {1.0, 2.5, 5.0, 10.0, 20.0, 40.0, 90.0, 172.0})
        EXPECT_EQ(degrees(angle * (pi / 180)), angle);
}

TEST(Scalars, AlgorithmsAreUnderstoodWithAndWithoutPrefix) {
    for (const char* name : {"slsqp", "SLSQP", "LD_SLSQP", "nlopt_ld_slsqp", "NLOPT_LD_SLSQP"})
        EXPECT_EQ(algorithm_word(name), "slsqp") << name;
    for (const char* name : {"lbfgs", "L-BFGS", "NLOPT_LD_LBFGS"}) EXPECT_EQ(algorithm_word(name), "lbfgs") << name;
    EXPECT_EQ(algorithm_word("LN_COBYLA"), "cobyla");
}

TEST(Suggestions, DistanceCountsSwapsOnce) {
    EXPECT_EQ(damerau_distance("tpi", "tip"), 1);
    EXPECT_EQ(damerau_distance("", "abc"), 3);
    EXPECT_EQ(damerau_distance("kitten", "sitting"), 3);
}

TEST(Suggestions, TwoEditsOrAThirdOfTheLength) {
    const std::vector<std::string> words{"min", "max", "equals", "max_displacement"};
    EXPECT_EQ(nearest("mim", words), "min");
    EXPECT_EQ(nearest("maxdisplacment", words), "max_displacement");
    EXPECT_EQ(nearest("zzz", words), "");
    EXPECT_EQ(nearest("on", {"at"}), "");
    EXPECT_EQ(nearest(std::string(100000, 'a'), words), "");
}

}  // namespace
}  // namespace strake
