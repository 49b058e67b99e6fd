#include "casefile/model/case.hpp"
#include "core/formats/io.hpp"
#include "optimize/check/gradient_check.hpp"
#include "optimize/check/start_check.hpp"
#include "tests/casefile/build_fixture.hpp"

/// Built-in quantities and formulas in a case file, and their gradients through the deformation.
namespace strake {
namespace {

class Goals : public BuildProblem {
protected:
    Goals() {
        TriMesh body = ellipsoid({2, 1, 0.6}, 3);  // bent: nothing is zero by symmetry
        for (int v = 0; v < body.num_vertices(); ++v)
            body.vertices(v, 1) += 0.1 * body.vertices(v, 0) * (body.vertices(v, 0) + 0.3 * body.vertices(v, 2));
        surface(body);
    }
    static std::string with(const std::string& quantities, const std::string& goal) {
        return "regions:\n  nose: {box: [[-3, -2, -2], [-1.7, 2, 2]]}\n  rest: {box: [[-1.8, -2, -2], [3, 2, 2]]}\n"
               "fixed: [nose]\nshell: {thickness: 10%}\n"
               "parameters: {levels: auto, patches_per_level: [4], variables: [normal], max_displacement: 2%}\n"
               "variables:\n  a: {start: 3deg, min: 0, max: 6deg}\n"
               "quantities:\n" +
               quantities + "objective: {minimize: \"" + goal + "\"}\n";
    }
};

const char* const all_types =
    "  aero: {type: newtonian, mach: 6, gamma: 1.3, alpha: {variable: a}, beta: 2deg, leeward: prandtl_meyer, "
    "moment_center: [0.2, "
    "0, "
    "0.1]}\n"
    "  wave: {type: wave_drag, mach: 1.4, stations: 12, angles: 3, base: nose}\n"
    "  skin: {type: friction, mach: 2, reynolds: 1e6, boundary_layer: laminar}\n"
    "  front: {type: projected_area, alpha: {variable: a}}\n"
    "  mass: {type: mass_properties}\n"
    "  span: {type: extent, direction: [0, 1, 0], smoothing: 1%}\n"
    "  sections: {type: section_areas, direction: [1, 0, 0], stations: 4}\n"
    "  wall: {type: wall_thickness, region: rest, sharpness: 20}\n"
    "  curved: {type: bending_energy}\n"
    "  fair: {type: fairness, region: rest}\n"
    "  keep: {type: clearance, file: engine.obj, smoothing: 0.5%, region: rest}\n"
    "  flat: {type: planarity, region: nose}\n"
    "  even: {type: symmetry_error, plane: {normal: [0, 1, 0], at: 0}}\n"
    "  tip: {type: edge_radius, region: rest}\n"
    "  edge: {type: edge_radius, region: rest, plane: {normal: [0, 0.1, 1], at: 0.013}}\n"
    "  moved: {type: displacement}\n"
    "  sum: {expression: \"aero.drag + 0.1 * volume + a\"}\n"
    "  more: {expression: \"sum ^ 2 / wave\"}\n";

const char* const all_values[] = {"aero.drag",
                                  "aero.lift",
                                  "aero.lift_to_drag",
                                  "aero.pitch",
                                  "wave",
                                  "skin",
                                  "front",
                                  "mass.centroid_x",
                                  "mass.ixy",
                                  "mass.principal_2",
                                  "mass.axis_1_x",
                                  "span.length",
                                  "sections.2",
                                  "wall.smooth",
                                  "curved",
                                  "fair",
                                  "keep",
                                  "even",
                                  "tip",
                                  "edge",
                                  "moved",
                                  "sum",
                                  "more"};

}  // namespace

TEST_F(Goals, GradientsOfAllGoThroughTheDeformation) {
    write_surface(folder.path() / "engine.obj", ellipsoid({1, 0.3, 0.2}, 2), SurfaceFormat::obj);
    std::string constraints = "constraints:\n";
    for (const char* value : all_values) constraints += std::string("  ") + value + ": {max: 1e6}\n";
    const BuiltProblem built = build(with(all_types, "2 * aero.drag - sqrt(area) * mass.izz") + constraints);
    EXPECT_EQ(built.problem.objective, "goal");
    GradientCheckOptions options;
    options.h = {1e-2, 1e-3, 1e-4, 1e-5};
    const GradientCheck check = check_gradients(built.problem, options);
    EXPECT_EQ(check.tests.size(), std::size(all_values) + 1);
    for (const TaylorTest& test : check.tests) EXPECT_TRUE(test.passed) << test.name << ": " << test.verdict;
}

TEST_F(Goals, OnlyWhatIsNeededIsDifferentiated) {
    const BuiltProblem built =
        build(with("  aero: {type: newtonian, mach: 6}\n  ld: {expression: aero.lift / aero.drag}\n"
                   "  twice: {expression: 2 * a * ld}\n",
                   "twice"));
    const StartAnswer answer = check_start(built.problem);
    ASSERT_EQ(answer.status, "ok") << answer.reason;
    ASSERT_EQ(answer.quantities.size(), 3u);
    EXPECT_TRUE(answer.quantities[0].values[0].has_gradient);
    EXPECT_TRUE(answer.quantities[0].values[1].has_gradient);
    EXPECT_FALSE(answer.quantities[0].values[5].has_gradient);
    EXPECT_NEAR(answer.quantities[1].values[0].value,
                answer.quantities[0].values[1].value / answer.quantities[0].values[0].value, 1e-14);
}

TEST_F(Goals, FormulasStandBehindAllOthers) {
    const BuiltProblem built = build(
        with("  ld: {expression: aero.lift / aero.drag}\n  aero: {type: newtonian, cp_max: 2}\n", "a * ld + volume"));
    std::vector<std::string> names;
    for (const Quantity& quantity : built.problem.quantities) names.push_back(quantity.names[0]);
    EXPECT_EQ(names, (std::vector<std::string>{"aero.drag", "volume", "ld", "goal"}));
}

TEST_F(Goals, ErrorsNameThePlace) {
    const auto one = [&](const std::string& quantity, const std::string& goal = "q + a") {
        return error(with("  q: " + quantity + "\n", goal));
    };
    EXPECT_TRUE(contains(one("{type: newtonian}", "a * q.drag"), "quantities.q must have mach or cp_max"));
    EXPECT_TRUE(contains(one("{type: newtonian, mach: 0.5}", "a * q.drag"), "q: mach = 0.5 must be >= 1"));
    EXPECT_TRUE(contains(one("{type: newtonian, mach: 5, alpha: {variable: b}}", "a * q.drag"),
                         "variable 'b' is not declared"));
    EXPECT_TRUE(contains(one("{type: fairness, region: nos}"), "region 'nos' is not declared; did you mean 'nose'?"));
    EXPECT_TRUE(contains(one("{type: symmetry_error}"), "quantities.q.plane is missing"));
    EXPECT_TRUE(contains(one("{type: edge_radius}"), "quantities.q.region is missing"));
    EXPECT_TRUE(contains(one("{type: wave_drag, leeward: zero}"),
                         "quantities.q.leeward is only allowed with 'type: newtonian'"));
    EXPECT_TRUE(
        contains(one("{type: area, expression: 2 * volume}"), "exactly one of type, command, plugin, expression"));
    EXPECT_TRUE(
        contains(one("{expression: 2 * volum}"),
                 "quantities.q: formula '2 * volum', column 5: 'volum' is not known; there are: volume, area, a"));
    EXPECT_TRUE(contains(one("{expression: q + volume}"), "'q' is not known"));
    EXPECT_TRUE(contains(error(with("  area: {expression: 2 * area}\n", "area + a")), "'area' is not known"));
    EXPECT_TRUE(
        contains(error(with("  area: {expression: 2 * volume}\n  volume: {expression: area + 1}\n", "area + a")),
                 "'volume' is not known"));
    std::string plain = with("  q: {type: newtonian, mach: 5, alpha: {variable: a}}\n", "q.drag");
    plain.replace(plain.find("{start: 3deg, min: 0, max: 6deg}"), 32, "{start: 3, min: 0, max: 6}");
    EXPECT_TRUE(contains(error(plain), "needs an angle; write it as one"));
    EXPECT_TRUE(contains(one("{expression: 2 * a}"), "a formula must contain at least one value of a quantity"));
    EXPECT_TRUE(contains(one("{type: area}", "q +"), "formula 'q +', column 4"));
    EXPECT_TRUE(contains(one("{type: area}", "p"), "quantity 'p' is not known"));
    EXPECT_TRUE(contains(error(with("  goal: {type: area}\n", "goal + a")),
                         "the value of the formula is named 'goal', like a quantity"));
    const std::string values_only = with("  q: {command: [\"true\"], gradients: false, depends_on: []}\n", "a + 2 * q");
    EXPECT_TRUE(contains(error(values_only + "optimize: {method: mma}\n"), "'q' has no gradients"));
}

}  // namespace strake
