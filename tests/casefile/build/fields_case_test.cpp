#include "core/fields/displacement_fields.hpp"
#include "core/fields/invariance.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/run/fit.hpp"
#include "tests/casefile/build_fixture.hpp"
#include "tests/core/patches/shapes.hpp"
#include "tests/kinds_of_shape.hpp"

namespace strake {
namespace {

using FieldsOfACase = BuildProblem;

const char* body = R"(regions:
  root: {box: [[-9, -9, -9], [0.5, 9, 9]]}
  tip:  {box: [[2.9, -9, -9], [9, 9, 9]]}
fixed: [root]
objective: {minimize: area}
)";

TEST_F(FieldsOfACase, AreVariablesThatLeaveWhatIsHeld) {
    const TriMesh mesh = box_surface({4, 1, 0.5}, 8);
    surface(mesh);
    EXPECT_EQ(build(std::string(body) + "parameters: {patches_per_level: [4]}\n").problem.parameters.fields, nullptr)
        << "none where patches are stated";
    for (const char* words : {"fields: 12", "fields: {number: 12}", "fields: {number: 12, axis: x}, variables: []"}) {
        const Problem problem = build(std::string(body) + "parameters: {" + words + "}\n").problem;
        ASSERT_NE(problem.parameters.fields, nullptr) << words;
        ASSERT_EQ(problem.parameters.user_variables.size(), 12u) << words;
        EXPECT_EQ(problem.parameters.user_variables[0].name, "section.move_x.0");
        const Points u = problem.parameters.fields->displacement(Eigen::VectorXd::Ones(12));
        for (int v = 0; v < mesh.num_vertices(); ++v) EXPECT_EQ(u.row(v).isZero(0), mesh.vertices(v, 0) <= 0.5) << v;
    }
    const Parameters automatic = build(std::string(body) + "parameters: {fields: auto}\n").problem.parameters;
    EXPECT_EQ(automatic.field_steps.front(), 27);
    EXPECT_GT(automatic.fields->size(), 60) << "those that a refinement may take";
    EXPECT_EQ(automatic.field_steps.back(), automatic.fields->size());
}

/// By gradients a case that says nothing of variables nor of patches begins with fields, and the gradient chooses what
/// becomes finer.
TEST_F(FieldsOfACase, AreTheDefaultByGradientsWhereNothingIsSaidOfPatches) {
    surface(box_surface({4, 1, 0.5}, 8));
    for (const char* words : {"", "constraints: {}\n", "parameters: {max_displacement: 3%}\n",
                              "optimize: {method: sqp}\n", "optimize: {method: auto}\n"}) {
        const Parameters p = build(std::string(body) + words).problem.parameters;
        ASSERT_NE(p.fields, nullptr) << words;
        EXPECT_EQ(p.field_steps.front(), 27) << words;
        EXPECT_EQ(p.split, SplitRule::sensitivity) << words;
        EXPECT_EQ(p.kinds, std::vector{VariableKind::load}) << words;
    }
    for (const char* words :
         {"parameters: {fields: none}\n", "parameters: {variables: [load]}\n", "parameters: {levels: auto}\n",
          "parameters: {split: all}\n", "parameters: {patches_per_level: [4]}\n", "optimize: {method: mma}\n",
          "optimize: {method: nlopt_slsqp}\n"}) {
        const Parameters p = build(std::string(body) + words).problem.parameters;
        EXPECT_EQ(p.fields, nullptr) << words;
        EXPECT_EQ(p.split, SplitRule::tree) << words;
    }
    const Parameters limited =
        build(std::string(body) + "constraints: {volume: {min: 1, relative: true}}\n").problem.parameters;
    EXPECT_NE(limited.fields, nullptr);
    EXPECT_EQ(limited.split, SplitRule::tree) << "under constraints";
    // A run of before goes on as it began.
    const auto yaml = folder.write("case.yaml", std::string("surface: {file: s.obj, units: m}\n") + body);
    EXPECT_TRUE(load_case(yaml, Purpose::run).parameters.fields.is_wanted);
    EXPECT_FALSE(load_case(yaml, Purpose::run, yaml.parent_path()).parameters.fields.is_wanted);
    const auto begun = [&](const std::string& parameters) {
        return load_case(yaml, Purpose::run, {}, "parameters: {" + parameters + "}\n").parameters;
    };
    for (const bool by_sensitivity : {true, false}) {
        const ParameterEntry p =
            begun(by_sensitivity ? "fields: auto, split: sensitivity" : "fields: auto, split: all");
        EXPECT_TRUE(p.fields.is_wanted);
        EXPECT_EQ(p.split.kind, by_sensitivity ? SplitEntry::Kind::sensitivity : SplitEntry::Kind::all);
    }
}

/// A fit that states no variables begins with fields; one that does keeps to them.
TEST_F(FieldsOfACase, AreTheDefaultOfFits) {
    surface(box_surface({4, 1, 0.5}, 8));
    write_surface(folder.path() / "target.obj", box_surface({4, 1.2, 0.4}, 8), SurfaceFormat::obj);
    const std::string fit =
        "regions:\n  root: {box: [[-9, -9, -9], [0.5, 9, 9]]}\nfixed: [root]\n"
        "quantities: {match: {type: target_shape, file: target.obj}}\nfit: [match]\n";
    for (const char* words : {"", "parameters: {patches_per_level: [4]}\n"}) {
        const Parameters automatic = build(fit + words).problem.parameters;
        ASSERT_NE(automatic.fields, nullptr) << words;
        EXPECT_EQ(automatic.field_steps.front(), 27);
        EXPECT_FALSE(automatic.kinds.empty()) << "with patches behind them";
    }
    for (const char* words : {"fields: none", "variables: [load]"})
        EXPECT_EQ(build(fit + "parameters: {" + words + "}\n").problem.parameters.fields, nullptr) << words;
    // A fit of before goes on as it began, from the case that its folder holds.
    const auto yaml = folder.write("case.yaml", "surface: {file: s.obj, units: m}\n" + fit);
    EXPECT_TRUE(load_case(yaml, Purpose::fit).parameters.fields.is_wanted);
    EXPECT_FALSE(load_case(yaml, Purpose::fit, yaml.parent_path()).parameters.fields.is_wanted);
}

/// Such a run that holds nothing is held by a point; what names anything that holds is left as it is.
TEST_F(FieldsOfACase, ByValuesAloneAPointHoldsWhatNothingElseDoes) {
    surface(box_surface({4, 1, 0.5}, 8));
    const std::string region = "regions:\n  root: {box: [[-9, -9, -9], [0.5, 9, 9]]}\n",
                      goal =
                          "quantities: {flow: {command: [cat], outputs: [drag], gradients: false}}\n"
                          "objective: {minimize: flow.drag}\n";
    const auto supports = [&](const std::string& words) {
        return build(region + words + goal).problem.supports.size();
    };
    EXPECT_EQ(supports(""), 1);
    EXPECT_EQ(supports("variables: {alpha: {start: 1, min: 0, max: 2}}\n"), 1);
    EXPECT_EQ(supports("fixed: [root]\n"), 0);
    EXPECT_EQ(supports("shell: {spring: 3}\n"), 0);
    EXPECT_EQ(build(region + "objective: {minimize: area}\n").problem.supports.size(), 0) << "not by gradients";
}

/// By values alone a run that says nothing of its variables nor of its method begins with fields.
TEST_F(FieldsOfACase, AreTheDefaultByValuesAlone) {
    surface(box_surface({4, 1, 0.5}, 8));
    const std::string held = "regions:\n  root: {box: [[-9, -9, -9], [0.5, 9, 9]]}\nfixed: [root]\n";
    const auto has_fields = [&](const std::string& quantities, const std::string& objective,
                                const std::string& more = "") {
        return build(held + "quantities: {" + quantities + "}\nobjective: {minimize: " + objective +
                     "}\nparameters: {patches_per_level: [4]}\n" + more)
                   .problem.parameters.fields != nullptr;
    };
    const std::string flow = "flow: {command: [cat], outputs: [drag, lift], gradients: false}",
                      formula = flow + ", cost: {expression: 2 * flow.drag + volume}";
    EXPECT_TRUE(has_fields(flow, "flow.drag"));
    EXPECT_TRUE(has_fields(flow, "flow.drag", "optimize: {method: model, budget: {evaluations: 1000}}\n"));
    EXPECT_TRUE(has_fields(flow, "volume", "constraints: {flow.lift: {min: 1}}\n"));
    EXPECT_TRUE(has_fields(formula, "cost"));
    EXPECT_TRUE(has_fields(flow, "volume + 2 * flow.drag"));
    EXPECT_TRUE(has_fields(formula + ", twice: {expression: 2 * cost}", "twice"));
    for (const char* apart : {"volume-flow.drag", "flow.drag-volume"}) EXPECT_TRUE(has_fields(flow, apart)) << apart;
    EXPECT_TRUE(has_fields(flow, "flow.drag", "optimize: {method: Model}\n")) << "as it may be written";
    EXPECT_FALSE(has_fields(flow + ", low-flow: {expression: 2 * volume}", "low-flow")) << "a name of its own";
    EXPECT_FALSE(has_fields("flow: {command: [cat], outputs: [drag]}", "flow.drag")) << "with gradients";
    EXPECT_FALSE(has_fields(flow, "volume")) << "not what counts";
    EXPECT_FALSE(has_fields("flow: {command: [cat], gradients: false, low_fidelity: volume}", "flow")) << "by sqp";
    EXPECT_FALSE(has_fields(formula + ", size: {expression: 2 * volume}", "size"));
    EXPECT_FALSE(has_fields(flow + ", big_flow: {expression: 2 * volume}", "big_flow"));
    for (const char* stated :
         {"parameters: {fields: none}\n", "parameters: {variables: [load]}\n", "optimize: {method: cobyla}\n",
          "optimize: {finite_differences: true}\n", "optimize: {budget: {evaluations: 1001}}\n",
          "parameters: {given: [{name: turn, region: tip, rotate: [0, 1, 0]}]}\nregions: {tip: {box: [[3, -9, -9], "
          "[9, 9, 9]]}}\n"}) {
        const std::string words = stated;
        const bool has_regions = words.find("regions") != words.npos;
        const std::string text = (has_regions ? "hold: point\n" : held) + "quantities: {" + flow +
                                 "}\nobjective: {minimize: flow.drag}\n" + words;
        EXPECT_EQ(build(text).problem.parameters.fields, nullptr) << text;
    }
    // A run of before goes on as it began, from the case that its folder holds.
    const auto yaml = folder.write("case.yaml", "surface: {file: s.obj, units: m}\n" + held + "quantities: {" + flow +
                                                    "}\nobjective: {minimize: flow.drag}\n");
    EXPECT_TRUE(load_case(yaml, Purpose::run).parameters.fields.is_wanted);
    EXPECT_FALSE(load_case(yaml, Purpose::run, yaml.parent_path()).parameters.fields.is_wanted);
}

/// Fields move along the surface; patches then need not.
TEST_F(FieldsOfACase, NormalLoadsFollowThemByValuesAlone) {
    surface(box_surface({4, 1, 0.5}, 8));
    const std::string held = "regions:\n  root: {box: [[-9, -9, -9], [0.5, 9, 9]]}\nfixed: [root]\n",
                      flow =
                          "quantities: {flow: {command: [cat], outputs: [drag], gradients: false}}\n"
                          "objective: {minimize: flow.drag}\n";
    const auto kinds = [&](const std::string& words) { return build(held + words).problem.parameters.kinds; };
    const std::vector<VariableKind> normal{VariableKind::normal_load}, load{VariableKind::load};
    EXPECT_EQ(kinds(flow), normal);
    EXPECT_EQ(kinds(flow + "parameters: {max_displacement: 2%}\n"), normal);
    EXPECT_EQ(kinds(flow + "parameters: {directions: [[0, 0, 1]]}\n"), load) << "which are those of loads";
    EXPECT_EQ(kinds(flow + "parameters: {fields: auto}\n"), load) << "fields are stated";
    EXPECT_EQ(kinds(flow + "parameters: {variables: [load]}\n"), load);
    EXPECT_EQ(kinds(flow + "optimize: {budget: {evaluations: 1001}}\n"), load) << "no fields";
    EXPECT_EQ(kinds("objective: {minimize: area}\n"), load) << "with gradients";
    const std::string words = "surface: {file: s.obj, units: m}\n" + held + flow;
    const auto begun = [&](const std::string& variables) {
        const std::string before = words + "parameters: {fields: auto" + variables + "}\n";
        return load_case(folder.write("case.yaml", words), Purpose::run, {}, before).parameters.variables;
    };
    EXPECT_EQ(begun(", variables: [load]"), load) << "a run goes on as it began";
    EXPECT_EQ(begun(", variables: [normal]"), normal);
}

/// What begins at a design of fields has them.
TEST_F(FieldsOfACase, AreThoseOfTheStart) {
    const auto begun = [&](const std::string& there, const std::string& more = "") {
        std::filesystem::create_directories(folder.path() / "runs" / "first");
        folder.write("runs/first/case.yaml", there);
        return load_case(folder.write("case.yaml",
                                      "surface: {file: s.obj, units: m}\nregions: {root: {box: [[-9, -9, -9], [0.5, 9, "
                                      "9]]}}\nfixed: [root]\nobjective: {minimize: area}\n"
                                      "optimize: {start_from: runs/first}\n" +
                                          more),
                         Purpose::run)
            .parameters;
    };
    surface(box_surface({4, 1, 0.5}, 8));
    EXPECT_EQ(begun("parameters: {fields: 33}\n").fields.number, 33);
    EXPECT_TRUE(begun("parameters: {fields: auto, variables: [load]}\n").fields.is_wanted);
    EXPECT_EQ(begun("parameters: {fields: auto, variables: [load]}\n").variables.at(0), VariableKind::load);
    EXPECT_EQ(begun("parameters: {fields: auto, variables: [normal]}\n").variables.at(0), VariableKind::normal_load);
    EXPECT_EQ(begun("parameters: {fields: none, variables: [normal]}\n").variables.at(0), VariableKind::load);
    EXPECT_EQ(begun("parameters: {fields: auto, split: sensitivity}\n").split.kind, SplitEntry::Kind::sensitivity);
    EXPECT_EQ(begun("parameters: {fields: auto}\n").split.kind, SplitEntry::Kind::all);
    EXPECT_FALSE(begun("parameters: {fields: auto}\n", "parameters: {fields: none}\n").fields.is_wanted);
    EXPECT_FALSE(begun("parameters: {fields: auto}\n", "parameters: {variables: [normal]}\n").fields.is_wanted);
    for (const char* none : {"parameters: {fields: none}\n", "parameters: {}\n", "- 1\n", "a: [\n", ""})
        EXPECT_FALSE(begun(none).fields.is_wanted) << none;
}

/// Four triangles of this body are as near to its middle: one of them holds it, whatever the unit and the order.
TEST_F(FieldsOfACase, HoldPointTakesTheSameTriangleInEveryUnit) {
    const auto held = [&](double unit, bool is_reversed) {
        TriMesh mesh = ellipsoid(unit * Eigen::Vector3d(1, 0.6, 0.4), 2);
        mesh.vertices.rowwise() += unit * Eigen::RowVector3d(0.3, 0.1, -0.7);
        if (is_reversed) mesh.triangles = mesh.triangles.colwise().reverse().eval();
        surface(mesh);
        const Problem problem = build("hold: point\nobjective: {minimize: area}\n").problem;
        EXPECT_EQ(problem.supports.size(), 1u);
        const int t = problem.supports.front();
        return is_reversed ? mesh.num_triangles() - 1 - t : t;
    };
    const int first = held(1, false);
    for (const double unit : {0.001, 0.1, 0.3, 3.0, 7.0, 25.4, 1000.0})
        for (const bool is_reversed : {false, true}) EXPECT_EQ(held(unit, is_reversed), first) << unit << is_reversed;
}

/// At most 3 % of the distance is left of what loads alone hardly make.
TEST_F(FieldsOfACase, AFitWithoutOptionsFindsAWidenedAndFlattenedBody) {
    const TriMesh start = ellipsoid({1, 0.2, 0.2}, 2);
    surface(start);
    TriMesh target = start;
    target.vertices.col(1) *= 1.2;
    target.vertices.col(2) *= 0.8;
    write_surface(folder.path() / "target.obj", target, SurfaceFormat::obj);
    const std::string fit_case =
        "hold: point\nquantities: {match: {type: target_shape, file: target.obj}}\nfit: [match]\n";
    const auto left = [&](const std::string& words) {
        Problem problem = build(fit_case + words, Purpose::fit).problem;
        problem.optimize.max_evaluations = 24;
        const RunResult r = fit(problem);
        return std::sqrt(r.objective / r.objective_start);
    };
    EXPECT_LT(left(""), 0.03);
    EXPECT_GT(left("parameters: {fields: none, patches_per_level: [4, 8]}\n"), 0.2) << "what fields are for";
}

/// The same of a wing that is swept by 5.7 degrees beyond its root and whose tip has three quarters of its chord and
/// thickness.
TEST_F(FieldsOfACase, AFitWithoutOptionsFindsASweptAndTaperedWing) {
    const TriMesh start = naca0012_wing(12, 10, 3);
    surface(start);
    TriMesh target = start;
    for (int v = 0; v < start.num_vertices(); ++v) {
        const double free = std::max(0.0, start.vertices(v, 1) - 0.3), scale = 1 - 0.25 * free / 2.7;
        target.vertices(v, 0) = 0.25 + scale * (start.vertices(v, 0) - 0.25) + 0.1 * free;
        target.vertices(v, 2) *= scale;
    }
    write_surface(folder.path() / "target.obj", target, SurfaceFormat::obj);
    Problem problem = build(
                          "regions: {root: {box: [[-9, -9, -9], [9, 0.01, 9]], touch: any}}\nfixed: [root]\n"
                          "quantities: {match: {type: target_shape, file: target.obj}}\nfit: [match]\n",
                          Purpose::fit)
                          .problem;
    problem.optimize.max_evaluations = 24;
    const RunResult r = fit(problem);
    EXPECT_LT(std::sqrt(r.objective / r.objective_start), 0.03);
}

TEST_F(FieldsOfACase, DoOnlyTheChosenMotions) {
    surface(box_surface({4, 1, 0.5}, 8));
    const Problem problem =
        build(std::string(body) + "parameters: {fields: {number: 6, motions: [scale, twist]}, variables: []}\n")
            .problem;
    ASSERT_EQ(problem.parameters.user_variables.size(), 6u);
    for (const auto& variable : problem.parameters.user_variables)
        EXPECT_TRUE(contains(variable.name, "scale") || contains(variable.name, "twist")) << variable.name;
}

TEST_F(FieldsOfACase, MoveOnlyTheirRegionAndNothingThatIsFrozen) {
    const TriMesh mesh = box_surface({4, 1, 0.5}, 8);
    surface(mesh);
    for (const char* words :
         {"fields: {number: 6, on: tip}", "fields: 6, variables_on: [tip]", "fields: 6, frozen: [most]"}) {
        std::string yaml = std::string(body) + "parameters: {" + words + "}\n";
        yaml.replace(yaml.find("  tip:"), 0, "  most: all - tip\n");
        const Problem problem = build(yaml).problem;
        const Points u = problem.parameters.fields->displacement(Eigen::VectorXd::Ones(6));
        double largest = 0;
        for (int v = 0; v < mesh.num_vertices(); ++v) {
            if (mesh.vertices(v, 0) <= 2.9) {
                EXPECT_TRUE(u.row(v).isZero(0)) << words << v;
            }
            largest = std::max(largest, u.row(v).norm());
        }
        EXPECT_GT(largest, 0.1);
    }
}

TEST_F(FieldsOfACase, MayHoldAPointOrNothing) {
    const TriMesh mesh = box_surface({4, 1, 0.5}, 8);
    surface(mesh);
    const std::string goal = "objective: {minimize: area}\n";
    const Problem none = build("hold: none\n" + goal + "parameters: {fields: 12, variables: []}\n").problem;
    EXPECT_TRUE(none.fixed.empty());
    EXPECT_EQ(none.supports.size(), 1u) << "of the shell alone";
    const Eigen::VectorXd area = vertex_areas(mesh);
    for (int b = 0; b < 12; ++b)
        EXPECT_LT((area.transpose() * none.parameters.fields->field(b)).norm(), 1e-9 * area.sum()) << "in the mean";
    const Problem point = build("hold: {point: [0, 0.5, 0.25]}\n" + goal + "parameters: {fields: 12}\n").problem;
    ASSERT_EQ(point.supports.size(), 1u);
    EXPECT_LT(area_centroid(mesh, point.supports)[0], 0.5);
    bool moves_near = false;
    for (int b = 0; b < 12; ++b) {
        const Points u = point.parameters.fields->field(b);
        for (int v = 0; v < mesh.num_vertices(); ++v) moves_near |= mesh.vertices(v, 0) == 0 && u.row(v).norm() > 0.05;
    }
    EXPECT_TRUE(moves_near) << "the end may swell";
    EXPECT_EQ(build("hold: point\n" + goal).problem.supports.size(), 1u);
    EXPECT_TRUE(build("hold: fixed\n" + std::string(body)).problem.supports.empty());

    EXPECT_TRUE(contains(error("hold: none\n" + goal), "hold: none leaves the shell without a support"));
    EXPECT_TRUE(contains(error("hold: none\n" + goal + "parameters: {fields: 6}\n"), "need something to act against"));
    EXPECT_TRUE(contains(error("hold: point\n" + std::string(body)), "fixed and hold: point exclude each other"));
    EXPECT_TRUE(contains(error("hold: rim\n" + goal), "case.yaml:3:"));
}

TEST_F(FieldsOfACase, KeepAKindOfShape) {
    surface(extruded_section(16, 3));
    const std::string goal = "objective: {maximize: volume}\nregions: {front: {box: [[-9, -9, -9], [-0.3, 9, 9]]}}\n";
    const std::string held = goal + "fixed: [front]\n";
    const Problem problem =
        build(held + "invariance: {extrude: y}\nparameters: {fields: 9, variables: [normal]}\n").problem;
    ASSERT_NE(problem.parameters.invariance, nullptr);
    for (int b = 0; b < 9; ++b)
        EXPECT_LT(problem.parameters.invariance->deviation(problem.parameters.fields->field(b)), 1e-9);
    EXPECT_EQ(build(held).problem.parameters.invariance, nullptr) << "none by default";
    const auto refusal = [&](const std::string& words) { return error(held + "invariance: " + words + "\n"); };
    EXPECT_TRUE(contains(refusal("{extrude: x}"), "case.yaml:6:13: invariance: the surface is not extruded along x"))
        << refusal("{extrude: x}");
    EXPECT_TRUE(contains(refusal("{revolve: y}"), "not revolved about y")) << refusal("{revolve: y}");
    EXPECT_TRUE(contains(refusal("{extrude: y, revolve: y}"), "exactly one of extrude, revolve, cyclic"));
    EXPECT_TRUE(contains(refusal("{cyclic: 6}"), "needs its axis, about"));
    EXPECT_TRUE(contains(refusal("{cyclic: 1, about: x}"), "must be in [2, 10000]"))
        << refusal("{cyclic: 1, about: x}");
    EXPECT_TRUE(contains(refusal("{extrude: y, through: [0, 0, 0]}"), "belongs to revolve and cyclic"));
    EXPECT_TRUE(contains(refusal("{extrude: y}\nparameters: {variables: [strain]}"), "strain variables move patches"));
    const std::string one_side =
        "objective: {maximize: volume}\nregions: {corner: {box: [[-9, -9, -9], [-0.3, 0.5, 9]]}}\n"
        "fixed: [corner]\ninvariance: {extrude: y}\n";
    EXPECT_TRUE(contains(error(one_side), "what is held must be extruded along y, too")) << error(one_side);
}

TEST_F(FieldsOfACase, WrongOnesAreErrorsWithTheirLine) {
    surface(box_surface({4, 1, 0.5}, 4));
    const auto refusal = [&](const std::string& words) {
        return error(std::string(body) + "parameters: {" + words + "}\n");
    };
    EXPECT_TRUE(contains(refusal("fields: 0"), "parameters.fields = 0 must be in [1, 600]")) << refusal("fields: 0");
    EXPECT_TRUE(contains(refusal("fields: many"), "case.yaml:8:")) << refusal("fields: many");
    EXPECT_TRUE(contains(refusal("fields: {axis: [0, 0, 0]}"), "parameters.fields.axis = [0, 0, 0] has no direction"));
    EXPECT_TRUE(contains(refusal("fields: {motions: [grow]}"), "case.yaml:8:")) << refusal("fields: {motions: [grow]}");
    EXPECT_TRUE(contains(refusal("fields: {on: tpi}"), "parameters.fields.on: 'tpi' is not a declared region"));
    EXPECT_TRUE(contains(refusal("variables: []"), "nothing can change"));
}

}  // namespace
}  // namespace strake
