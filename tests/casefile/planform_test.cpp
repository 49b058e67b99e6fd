#include "core/fields/displacement_fields.hpp"
#include "core/planform/planform_motion.hpp"
#include "optimize/check/start_check.hpp"
#include "tests/casefile/build_fixture.hpp"
#include "tests/core/planform/lofted_wing.hpp"

#include <algorithm>
#include <map>
#include <numbers>

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

TEST_F(Planform, AFlapHasGapAndOverlapBehindTheWing) {
    Loft flap = loft_;
    flap.chord = [](double s) { return 0.25 * (1 - 0.5 * s); };
    flap.quarter = [](double s) { return 1.1 + 0.76 * s; };
    flap.height = [](double s) { return 0.3 * s - 0.06; };
    const TriMesh main = lofted(loft_), rear = lofted(flap);
    TriMesh both;
    both.vertices.resize(main.num_vertices() + rear.num_vertices(), 3);
    both.vertices << main.vertices, rear.vertices;
    both.triangles.resize(main.num_triangles() + rear.num_triangles(), 3);
    both.triangles << main.triangles, Triangles(rear.triangles.array() + main.num_vertices());
    surface(both);
    const auto text_of = [&](const std::string& behind, const std::string& goal) {
        return "regions: {rear: {component: 1}, front: {component: 0}}\nsymmetry: {plane: y, at: 0}\nshell: none\n"
               "planform: {main: {on: front, span: y}, flap: {on: rear, span: y" +
               behind +
               "}}\n"
               "parameters: {planform: {flap.aft: {range: [-20%, 20%]}, flap.up: {range: [-20%, 20%]}}}\n" +
               goal;
    };
    const std::string goal =
        "objective: {minimize: area}\nconstraints: {flap.gap@0.5: {min: 0.02}, flap.overlap_grid: "
        "{min: -0.1}}\n";
    std::map<std::string, double> found;
    for (const auto& quantity : check_start(build(text_of(", behind: main", goal)).problem).quantities)
        for (const auto& value : quantity.values) found[value.name] = value.value;
    EXPECT_GT(found.at("flap.gap@0.5"), 0.01);
    EXPECT_LT(found.at("flap.gap@0.5"), 0.1);
    EXPECT_TRUE(found.contains("flap.overlap@0.1"));
    EXPECT_TRUE(contains(error(text_of("", goal), Purpose::run), "of which wing? Write planform.flap: {behind: NAME}"));
    EXPECT_TRUE(contains(error(text_of(", behind: mian", goal), Purpose::run), "did you mean 'main'?"));
    EXPECT_TRUE(contains(error(text_of(", behind: flap", goal), Purpose::run), "must be another wing under planform"));
}

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

TEST_F(Planform, OneLineConstrainsAllStations) {
    const BuiltProblem built =
        build(frame("planform: {wing: {span: y, grid: {span: [20%, 50%, 80%]}}}\nobjective: {minimize: area}\n"
                    "constraints: {wing.twist_step_grid: {max: 0.5deg}, wing.camber_grid: {min: 0}, "
                    "wing.spar_offset_grid: {min: -0.1, max: 0.1}}\n"));
    const auto& all = built.problem.constraints;
    ASSERT_EQ(all.size(), 2U + 3U + 6U);
    EXPECT_EQ(all[1].quantity, "wing.twist_step@0.5@0.8");
    EXPECT_NEAR(*all[1].max, 0.5 * std::numbers::pi / 180, 1e-15);
    EXPECT_EQ(all[2].quantity, "wing.camber@0.2");
    EXPECT_EQ(all[10].quantity, "wing.spar_offset@0.8@0.65");
}

/// Loads keep the edges of a declared wing, if it does not say otherwise.
TEST_F(Planform, EdgesOfADeclaredWingAreKept) {
    const std::string goal = "objective: {minimize: area}\n";
    const auto kept = [&](const std::string& wing) {
        return build(frame("planform: {wing: " + wing + "}\n" + goal)).problem.parameters.kept_sections != nullptr;
    };
    EXPECT_TRUE(kept("{span: y}"));
    EXPECT_TRUE(kept("{span: y, keep: outline}"));
    EXPECT_FALSE(kept("{span: y, keep: none}"));
    EXPECT_EQ(build(frame(goal)).problem.parameters.kept_sections, nullptr);
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
          {"fin.twist@0.5: {max: 1deg}", "no wing or body 'fin' is declared under planform; declared: wing"}}) {
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

/// By values, of a declared wing that keeps its planform and alone can move, fields are those of a wing, unless the
/// case says otherwise or its run began before there were any. Of others where it is asked for.
TEST_F(Planform, FieldsAreThoseOfAWingWhereItAloneMoves) {
    const std::string goal =
                          "shell: none\nsymmetry: {plane: y, at: 0}\nobjective: {minimize: flow.drag}\n"
                          "quantities: {flow: {command: [cat], outputs: [drag], gradients: false}}\n",
                      wing = "planform: {wing: {span: y}}\n";
    const auto fields = [&](const std::string& rest) { return build(goal + rest).problem.parameters; };
    const Parameters own = fields(wing + "parameters: {fields: auto}\n");
    EXPECT_EQ(own.user_variables[0].name, "wing.camber.2.s0") << "the planform is kept";
    EXPECT_EQ(own.field_steps.front(), 24);
    const std::string asked = "parameters: {fields: {number: 9, kind: wing}}\n",
                      free = "planform: {w: {span: y, keep: none}}\n";
    const auto has_twist = [](const Parameters& p, const std::string& name) {
        return std::ranges::any_of(p.user_variables,
                                   [&](const UserVariable& v) { return v.name == name + ".twist.s0"; });
    };
    EXPECT_TRUE(has_twist(fields(free + asked), "w"));
    const BuiltProblem seen = build(goal + asked);
    EXPECT_TRUE(has_twist(seen.problem.parameters, "wing")) << "it looks like one";
    EXPECT_TRUE(std::ranges::any_of(seen.notes, [](const std::string& n) { return contains(n, "kind: sections"); }));
    for (const std::string& declared : {std::string(), free})
        EXPECT_TRUE(fields(declared + "parameters: {fields: 9}\n").user_variables[0].name.starts_with("section."));
    EXPECT_TRUE(build("shell: none\nsymmetry: {plane: y, at: 0}\nobjective: {maximize: volume}\n" + wing +
                      "parameters: {fields: 9}\n")
                    .problem.parameters.user_variables[0]
                    .name.starts_with("section."))
        << "by gradients";
    for (const char* others : {"{number: 9, kind: sections}", "{number: 9, axis: y}", "{number: 9, motions: [move]}",
                               "{number: 9, along: splines}"})
        EXPECT_TRUE(
            fields(wing + "parameters: {fields: " + others + "}\n").user_variables[0].name.starts_with("section."))
            << others;
    EXPECT_TRUE(fields(wing + "parameters: {fields: {number: 4, kind: wing, motions: [thickness]}}\n")
                    .user_variables[3]
                    .name.starts_with("wing.thickness."));
    Case before = load_case(
        folder.write("case.yaml", "case: c\nsurface: {file: s.obj}\n" + goal + wing + "parameters: {fields: auto}\n"),
        Purpose::any);
    before.parameters.fields.are_sections_by_default = true;
    const Parameters began = build_problem(before, Purpose::any).problem.parameters;
    EXPECT_TRUE(began.user_variables[0].name.starts_with("section."));
    EXPECT_EQ(began.field_steps.front(), 27);
}

/// A body that moves, too, has sections; `kind: wing` leaves it where it is, and so does a wing beside it that is
/// fixed.
TEST_F(Planform, FieldsOfAWingLeaveTheRest) {
    const std::string goal =
        "shell: none\nsymmetry: {plane: y, at: 0}\nobjective: {minimize: flow.drag}\n"
        "quantities: {flow: {command: [cat], outputs: [drag], gradients: false}}\n"
        "regions: {inner: {box: [[-9, -9, -9], [9, 0.8, 9]]}}\n"
        "planform: {wing: {span: y, on: all - inner}}\n";
    const auto fields = [&](const std::string& rest) { return build(goal + rest).problem.parameters; };
    EXPECT_TRUE(fields("parameters: {fields: 9}\n").user_variables[0].name.starts_with("section."));
    for (const char* words :
         {"fixed: [inner]\nparameters: {fields: 9}\n", "parameters: {fields: {number: 9, kind: wing}}\n"}) {
        const BuiltProblem built = build(goal + words);
        const Parameters& p = built.problem.parameters;
        EXPECT_TRUE(p.user_variables[0].name.starts_with("wing.")) << words;
        const Points u = p.fields->displacement(Eigen::VectorXd::Ones(9));
        for (const int t : region(built, "inner"))
            for (const int v : built.problem.surface.triangles.row(t)) EXPECT_TRUE(u.row(v).isZero(0));
        EXPECT_GT(u.norm(), 1);
    }
    EXPECT_TRUE(contains(error("shell: none\nhold: none\nobjective: {maximize: volume}\n"
                               "planform: {a: {span: y}, b: {span: y}}\nparameters: {fields: {kind: wing}}\n"),
                         "planform declares 2 wings; fields are those of one; or write kind: sections"));
}

TEST_F(Planform, RangesAreVariables) {
    const std::string wing =
        "shell: none\nsymmetry: {plane: y, at: 0}\nplanform: {wing: {span: y, stations: [0, 0.5, 1]}}\n";
    const BuiltProblem built =
        build(wing +
              "parameters:\n  planform:\n    wing.twist: {by: station, range: [-4deg, 4deg], root: held}\n"
              "    wing.span: {range: [-5%, 0.1%]}\n    wing.camber@0.5: {range: [0, 1%]}\n"
              "objective: {maximize: volume}\n");
    const Parameters& p = built.problem.parameters;
    EXPECT_EQ(p.fields, nullptr) << "what is not listed stays";
    ASSERT_NE(p.planform, nullptr);
    std::vector<std::string> names;
    for (const auto& v : p.planform->variables()) names.push_back(v.name);
    EXPECT_EQ(names, (std::vector<std::string>{"wing.delta_twist@0.5", "wing.delta_twist@1", "wing.delta_span",
                                               "wing.delta_camber@0.5"}));
    EXPECT_DOUBLE_EQ(p.planform->variables()[0].upper, 4 * std::numbers::pi / 180);
    EXPECT_DOUBLE_EQ(p.planform->variables()[2].lower, -0.05);
    EXPECT_DOUBLE_EQ(p.planform->variables()[3].upper, 0.01);
    const BuiltProblem both = build(wing +
                                    "parameters: {fields: 6, planform: {wing.sweep: {range: [-1deg, 1deg]}}}\n"
                                    "objective: {maximize: volume}\n");
    ASSERT_EQ(both.problem.parameters.user_variables.size(), 7U);
    EXPECT_EQ(both.problem.parameters.user_variables[0].planform, 0);
    const BuiltProblem panels =
        build(wing +
              "parameters:\n  planform:\n    wing.sweep: {by: station, range: [-5deg, 5deg], root: held}\n"
              "    wing.dihedral: {by: station, range: [-3deg, 3deg]}\n"
              "objective: {maximize: wing.sweep@0.2}\nconstraints: {wing.dihedral_grid: {max: 9deg}}\n");
    ASSERT_EQ(panels.problem.parameters.planform->size(), 3);
    EXPECT_EQ(panels.problem.parameters.planform->variables()[0].name, "wing.delta_sweep@0.5");
    EXPECT_EQ(panels.problem.parameters.planform->variables()[1].name, "wing.delta_dihedral@0");
    EXPECT_EQ(panels.problem.constraints.size(), 5U) << "the panels at five places";
    EXPECT_EQ(panels.wings.size(), 1U);
}

TEST_F(Planform, BadRangesAreRefused) {
    const auto said = [&](const std::string& range, const std::string& rest = "") {
        return error(
            "shell: none\nsymmetry: {plane: y, at: 0}\nplanform: {wing: {span: y, stations: [0, 0.5, 1]}}\n"
            "parameters: {planform: {" +
                range + "}}\nobjective: {maximize: volume}\n" + rest,
            Purpose::run);
    };
    for (const auto& [range, words] : std::vector<std::pair<std::string, std::string>>{
             {"wng.span: {range: [-1%, 1%]}", "no wing or body 'wng' is declared under planform; did you mean 'wing'?"},
             {"wing.spam: {range: [-1%, 1%]}", "changes: span, sweep, dihedral"},
             {"wing.span: {range: [-1, 1]}", "range[0] = -1 needs a unit"},
             {"wing.twist: {range: [-1, 1]}", "must be an angle with a unit"},
             {"wing.span: {range: [1%, -1%]}", "must ascend and contain 0"},
             {"wing.span: {range: [1%, 2%]}", "must ascend and contain 0"},
             {"wing.span: {}", "range is missing"},
             {"wing.span: {by: station, range: [-1%, 1%]}", "has no stations"},
             {"wing.twist@0.4: {range: [-1deg, 1deg]}", "there is no such station; stations: 0, 0.5, 1"},
             {"wing.twist@2: {range: [-1deg, 1deg]}", "there is no such station"},
             {"wing.twist@0.5: {range: [-1deg, 1deg]}, wing.twist: {range: [-1deg, 1deg]}", "has a range already"},
             {"wing.sweep@1: {range: [-1deg, 1deg]}", "no panel that begins there; panels: 0, 0.5"},
             {"wing.sweep@0: {range: [-1deg, 1deg]}, wing.sweep: {range: [-1deg, 1deg]}", "has a range already"},
             {"wing.dihedral: {root: held, range: [-1deg, 1deg]}", "belongs to by: station"},
             {"wing.sweep@0: {root: held, range: [-1deg, 1deg]}",
              "wing.sweep@0: root: held leaves the root no variable"},
             {"wing.twist: {root: held, range: [-1deg, 1deg]}", "belongs to by: station"},
             {"wing.twist: {thickness: kept, range: [-1deg, 1deg]}", "belongs to chord"}}) {
        const std::string found = said(range);
        EXPECT_TRUE(contains(found, words)) << range << "\n" << found;
    }
    for (const char* range : {"wing.sweep@0.5: {range: [-1, 1]}", "wing.twist: {range: [1deg, 2deg]}",
                              "wing.sweep@0.5: {by: station, range: [-1deg, 1deg]}"}) {
        const std::string found = said(range);
        EXPECT_EQ(found.find(".yaml:"), found.rfind(".yaml:")) << "not that nothing moves, too:\n" << found;
    }
    EXPECT_TRUE(
        contains(said("wing.span: {range: [-1%, 1%]}", "variables: {wing.delta_span: {start: 0, min: 0, max: 1}}\n"),
                 "is called 'wing.delta_span'"));
    EXPECT_TRUE(
        contains(said("wing.span: {range: [-1%, 1%]}", "regions: {root: {of: wing, span: [0%, 30%]}}\nfixed: [root]\n"),
                 "moves vertex"));
}

}  // namespace
}  // namespace strake
