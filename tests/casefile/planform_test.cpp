#include "optimize/check/start_check.hpp"
#include "tests/casefile/build_fixture.hpp"
#include "tests/core/planform/lofted_wing.hpp"

#include <map>

/// The block `planform`: values of wings in objective and constraints, and regions of wings.
namespace strake {
namespace {

class Planform : public BuildProblem {
protected:
    Planform() {
        loft_.cells = 12;
        loft_.panels = 16;
        surface(lofted(loft_));
    }
    Loft loft_;
    static std::string frame(const std::string& rest) {
        return "regions: {root: {box: [[-9, -1, -9], [9, 0.3, 9]]}}\nfixed: [root]\nsymmetry: {plane: y, at: 0}\n"
               "parameters: {levels: auto, patches_per_level: [4], variables: [normal], max_displacement: 2%}\n" +
               rest;
    }
    std::map<std::string, double> values(const std::string& rest) {
        std::map<std::string, double> found;
        for (const auto& quantity : check_start(build(frame(rest)).problem).quantities)
            for (const auto& value : quantity.values) found[value.name] = value.value;
        return found;
    }
};

TEST_F(Planform, ValuesAreQuantities) {
    const auto found = values(
        "planform: {wing: {span: y, values: [taper, chord@0.25]}}\n"
        "quantities: {loading: {expression: 1 / wing.area - wing.span}}\n"
        "objective: {minimize: area + 2 * wing.thickness_to_chord@0.5}\n"
        "constraints:\n  wing.twist@0.5: {min: -1deg, max: 0.1rad}\n  loading: {max: 9}\n");
    ASSERT_EQ(found.size(), 9U);  // six of the wing, area, loading, goal
    EXPECT_NEAR(found.at("wing.area"), 4.5, 0.03);
    EXPECT_NEAR(found.at("wing.span"), 6, 0.01);
    EXPECT_NEAR(found.at("wing.taper"), 0.5, 0.01);
    EXPECT_NEAR(found.at("wing.chord@0.25"), 0.875, 0.005);
    EXPECT_NEAR(found.at("wing.twist@0.5"), 0.01, 0.001) << "radians";
    EXPECT_NEAR(found.at("loading"), 1 / found.at("wing.area") - found.at("wing.span"), 1e-12);
}

TEST_F(Planform, AThicknessGridIsOneLine) {
    const BuiltProblem built =
        build(frame("planform: {wing: {span: y, grid: {span: [20%, 60%], chord: [15%, 40%, 70%]}}}\n"
                    "objective: {minimize: area}\nconstraints: {wing.thickness_grid: {min: 0.98, relative: true}}\n"));
    ASSERT_EQ(built.problem.constraints.size(), 6U);
    EXPECT_EQ(built.problem.constraints[4].quantity, "wing.thickness@0.6@0.4");
    for (const Constraint& c : built.problem.constraints) EXPECT_TRUE(c.relative && c.min == 0.98);
}

TEST_F(Planform, RegionsOfAWing) {
    const BuiltProblem built = build(
        "symmetry: {plane: y, at: 0}\nplanform: {wing: {span: y}}\n"
        "regions:\n  box: {of: wing, chord: [15%, 65%], span: [0%, 95%], side: upper}\n"
        "  flap: {of: wing, chord: [70%, 100%], span: [30%, 70%]}\n"
        "  nose: {of: wing, edge: leading}\n  tail: {of: wing, edge: trailing}\n  rest: all - nose - tail - box\n",
        Purpose::deform);
    for (const char* name : {"box", "flap", "nose", "tail", "rest"}) EXPECT_GT(region(built, name).size(), 10U) << name;
    const TriMesh mesh = lofted(loft_);
    for (const int t : region(built, "nose")) {
        double first = 1;
        for (const int v : mesh.triangles.row(t)) {
            const double s = mesh.vertices(v, 1) / 3;
            first = std::min(first, (mesh.vertices(v, 0) - loft_.quarter(s)) / loft_.chord(s) + 0.25);
        }
        EXPECT_LT(first, 0.025);
    }
}

TEST_F(Planform, ErrorsSayWhatToDo) {
    const auto in_case = [&](const std::string& rest) { return error(frame(rest), Purpose::run); };
    const std::string wing = "planform: {wing: {span: y}}\n", goal = "objective: {minimize: area}\n";
    EXPECT_TRUE(contains(in_case(wing + "objective: {minimize: wing.twits@0.5}\n"), "did you mean 'twist'?"));
    EXPECT_TRUE(contains(in_case(wing + goal + "constraints: {wing.twist@0.5: {min: 2}}\n"),
                         "constraints.wing.twist@0.5.min = 2 must carry deg or rad"));
    EXPECT_TRUE(contains(in_case(wing + goal + "constraints: {wing.area: {min: 2deg}}\n"),
                         "must be a plain number: the quantity is not an angle"));
    // One message for each mistake, and none that leads astray.
    const auto count = [](const std::string& words) {
        int lines = 0;
        for (std::size_t at = words.find(".yaml:"); at != std::string::npos; at = words.find(".yaml:", at + 1)) ++lines;
        return lines;
    };
    for (const auto& [limit, words] :
         {std::pair{"wing.twist@1.5: {max: 1deg}", "must be a fraction in [0, 1]"},
          {"wing.twst@0.5: {max: 1deg}", "did you mean 'twist'?"},
          {"fin.twist@0.5: {max: 1deg}", "no wing 'fin' is declared under planform; wings: wing"}}) {
        const std::string said = in_case(wing + goal + "constraints: {" + limit + "}\n");
        EXPECT_TRUE(contains(said, words)) << said;
        EXPECT_EQ(count(said), 1) << said;
    }
    EXPECT_TRUE(contains(in_case("planform: {wing: {span: x}}\n" + goal), "perpendicular"));
    EXPECT_TRUE(contains(in_case("planform: {wing: {}}\n" + goal), "planform.wing.span is missing"));
    EXPECT_TRUE(contains(in_case("planform: {wing: {span: y, stations: [0, 2]}}\n" + goal), "stations[1] = 2"));
    EXPECT_TRUE(contains(in_case("planform: {wing: {span: y, axis: nose}}\n" + goal), "25% chord"));
    EXPECT_TRUE(contains(in_case("planform: {wing: {span: y, on: wig}}\n" + goal), "'wig'"));
    EXPECT_TRUE(contains(in_case("planform: {wing: {span: y, box: {chord: [65%, 15%]}}}\n" + goal), "ascend"));
    EXPECT_TRUE(contains(in_case("planform: {volume: {span: y}}\nquantities: {volume: {type: volume}}\n" + goal),
                         "has the name of a quantity"));
    EXPECT_TRUE(contains(error("regions: {a: {of: wing}}\n"), "is not declared under planform"));
    EXPECT_TRUE(contains(error("planform: {w: {span: y, on: a}}\nregions: {a: {of: w}}\n"), "made of itself: a -> a"));
    EXPECT_TRUE(contains(error(wing + "regions: {a: {of: wing, edge: leading, chord: [0, 1]}}\n"), "use one of them"));
    EXPECT_TRUE(contains(error(wing + "regions: {a: {of: wing, side: above}}\n"), "upper, lower or both"));
    EXPECT_TRUE(contains(error("regions: {a: {plane: {normal: [1, 0, 0], at: 0}}}\n"), "regions.a.side is missing"));
    EXPECT_TRUE(contains(error("regions: {a: {plane: {normal: [1, 0, 0], at: 0}, side: upper}}\n"), "above or below"));
}

}  // namespace
}  // namespace strake
