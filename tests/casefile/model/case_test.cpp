#include "casefile/model/case.hpp"
#include "casefile/load_case.hpp"
#include "casefile/read/resolved_case.hpp"
#include "casefile/schema/scalars.hpp"
#include "casefile/schema/schema.hpp"
#include "core/patches/automatic.hpp"
#include "core/patches/segmentation.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "tests/casefile/folder.hpp"

#include <gtest/gtest.h>
#include <numbers>
#include <sstream>

namespace strake {
namespace {

class CaseFile : public testing::Test {
protected:
    Folder folder;
    CaseFile() {
        folder.write("wing.obj", tetrahedron_obj);
        folder.write("flap.txt", "0\n");
        folder.write("run_cfd.sh", "#!/bin/sh\n");
        std::filesystem::permissions(folder.path() / "run_cfd.sh", std::filesystem::perms::owner_all);
    }
    Case load(const std::string& yaml, Purpose purpose = Purpose::any) {
        return load_case(folder.write("case.yaml", yaml), purpose);
    }
    static std::string minimal() { return "case: wing\nsurface: {file: wing.obj, units: mm}\n"; }
};

TEST_F(CaseFile, MinimalOneHasTheDefaultsOfTheStructs) {
    const Case c = load(minimal());
    EXPECT_EQ(c.name, "wing");
    EXPECT_EQ(c.units, "mm");
    EXPECT_TRUE(c.thickness.is_relative_to_diagonal);
    EXPECT_DOUBLE_EQ(c.thickness.value, 0.02);
    EXPECT_EQ(c.spring, 0);
    EXPECT_FALSE(c.couple_nonmanifold);
    EXPECT_EQ(c.solver, LinearSolver::automatic);
    EXPECT_EQ(c.output.dir, folder.path() / "runs/wing");
    // The table's defaults and those of a program that fills in a Problem itself are the same.
    const OptimizeOptions o;
    EXPECT_EQ(c.optimize.method, o.method);
    EXPECT_EQ(c.optimize.max_evaluations, o.max_evaluations);
    EXPECT_EQ(c.optimize.max_seconds, o.max_seconds);
    EXPECT_EQ(c.optimize.progress_below, o.progress_below);
    EXPECT_EQ(c.optimize.min_expected_gain, o.min_expected_gain);
    EXPECT_EQ(c.optimize.objective_tolerance, o.objective_tolerance);
    EXPECT_EQ(c.optimize.step_tolerance, o.step_tolerance);
    EXPECT_EQ(c.optimize.constraint_tolerance, o.constraint_tolerance);
    EXPECT_EQ(c.optimize.finite_differences, o.finite_differences);
    EXPECT_FALSE(c.optimize.ignores_symmetry);
    EXPECT_EQ(c.optimize.starts, o.starts);
    EXPECT_EQ(c.optimize.seed, o.seed);
    const Parameters p;
    EXPECT_EQ(c.parameters.marking_fraction, p.marking_fraction);
    EXPECT_EQ(c.parameters.max_variable_ratio, p.max_variable_ratio);
    EXPECT_EQ(c.parameters.free_border, p.free_border);
    EXPECT_EQ(c.parameters.mirror, p.mirror);
    EXPECT_EQ(c.parameters.directions, p.load_directions);
    EXPECT_EQ(c.parameters.variables, p.kinds);
    EXPECT_EQ(c.parameters.max_displacement.value, p.max_displacement);
    EXPECT_EQ(c.parameters.patches_per_level, AutomaticLevels{}.patches_per_level);
    EXPECT_EQ(c.parameters.sharp_angle_deg, SegmentationOptions{}.sharp_angle_deg);
    EXPECT_EQ(c.parameters.min_patch_percent, SegmentationOptions{}.min_patch_percent);
}

TEST_F(CaseFile, NameIsThatOfTheFileUnlessStated) {
    const Case c = load_case(folder.write("my wing.v2.yaml", "surface: {file: wing.obj}\n"));
    EXPECT_EQ(c.name, "my_wing_v2");
    EXPECT_EQ(c.output.dir, folder.path() / "runs/my_wing_v2");
    EXPECT_EQ(resolved_case(c, folder.path()).find("case: my_wing"), std::string::npos) << "quoted: it holds digits";
    EXPECT_EQ(load_case(folder.write("again.yaml", resolved_case(c, folder.path()))).name, "my_wing_v2");
}

TEST_F(CaseFile, TheCaseOfTheRunFolderHoldsWhatWasUsed) {
    Case c = load(minimal());
    const std::string resolved = resolved_case(c, c.output.dir);
    EXPECT_NE(resolved.find("patches_per_level: [4, 16, 64]"), std::string::npos) << resolved;
    EXPECT_NE(resolved.find("dir: \"" + (folder.path() / "runs/wing").string() + "\""), std::string::npos) << resolved;
    // A copy of it, wherever it lies, still means that folder.
    EXPECT_EQ(load_case(folder.write("elsewhere/copy.yaml", resolved.substr(0, resolved.find("surface")) +
                                                                "surface: {file: ../wing.obj}\n" +
                                                                resolved.substr(resolved.find("output"))))
                  .output.dir,
              folder.path() / "runs/wing");
}

TEST_F(CaseFile, UnitsAreResolved) {
    const Case c = load(minimal() + R"(regions:
  a: {sphere: {center: [1cm, 0, 1 m], radius: 10%}}
  b: {plane: {normal: [0, 0, 2], at: 2.5cm}, side: below}
  c: {component: 0}
shell: {thickness: {default: 1%, b: 3}}
strains: [{region: a, translate: [0, 5%, 1cm], rotate: [0, 180deg, 0.5rad], about: [1in, 0, 0]}]
loads: [{region: b, displacement: 2cm, direction: [0, 3, 4], spring: 0.5}]
parameters: {levels: [20deg, 0.1rad], min_patch: 2%, max_displacement: 3mm}
optimize: {budget: {time: 1.5h}, refine_when: {progress_below: 0.05}}
)");
    const auto& sphere = std::get<SphereShape>(c.regions[0].shape);
    EXPECT_EQ(sphere.center, Eigen::Vector3d(10, 0, 1000));
    EXPECT_DOUBLE_EQ(sphere.radius.in(200), 20);
    const auto& plane = std::get<HalfSpace>(c.regions[1].shape);
    EXPECT_EQ(plane.normal, Eigen::Vector3d(0, 0, 1));
    EXPECT_DOUBLE_EQ(plane.offset, 25);
    EXPECT_FALSE(plane.above);
    EXPECT_DOUBLE_EQ(c.thickness_by_region[0].height.in(1000), 3);
    const StrainEntry& strain = c.strains[0];
    EXPECT_DOUBLE_EQ(strain.translate[1].in(1000), 50);
    EXPECT_DOUBLE_EQ(strain.translate[2].in(1000), 10);
    EXPECT_DOUBLE_EQ(strain.rotate[1], std::numbers::pi);
    EXPECT_DOUBLE_EQ(strain.rotate[2], 0.5);
    EXPECT_DOUBLE_EQ((*strain.about)[0], 25.4);
    EXPECT_DOUBLE_EQ(c.loads[0].displacement->in(1), 20);
    EXPECT_TRUE(c.loads[0].direction.isApprox(Eigen::Vector3d(0, 0.6, 0.8)));
    EXPECT_EQ(c.parameters.levels_deg[0], 20);
    EXPECT_NEAR(c.parameters.levels_deg[1], 18 / std::numbers::pi, 1e-11);
    EXPECT_DOUBLE_EQ(c.parameters.min_patch_percent, 2);
    EXPECT_DOUBLE_EQ(c.optimize.max_seconds, 5400);
}

TEST_F(CaseFile, QuantitiesAndGoals) {
    const Case c = load(minimal() + R"(quantities:
  match: {type: target_shape, file: wing.obj, match: same}
  v: {type: volume}
  aero: {command: [./run_cfd.sh, "{surface}", "{result}"], outputs: [drag, lift], timeout: 2h, format: stl-ascii}
objective: {maximize: aero.lift}
constraints:
  area: {max: 1.01, relative: true}
  aero.drag: {equals: 0.3}
optimize: {method: NLOPT_LN_COBYLA}
output: {dir: here, paraview: none}
)");
    EXPECT_TRUE(c.maximize);
    EXPECT_EQ(c.objective.name, "aero.lift");
    EXPECT_EQ(c.optimize.method, Method::cobyla);
    ASSERT_EQ(c.quantities.size(), 4u) << "area is used without an entry";
    EXPECT_TRUE(std::get<TargetShapeEntry>(c.quantities[0].what).same_connectivity);
    EXPECT_EQ(c.quantities[1].value_names(), std::vector<std::string>{"v"});
    EXPECT_EQ(c.quantities[2].value_names(), (std::vector<std::string>{"aero.drag", "aero.lift"}));
    EXPECT_EQ(std::get<ExternalEntry>(c.quantities[2].what).timeout_s, 7200);
    EXPECT_EQ(c.quantities[3].name, "area");
    EXPECT_TRUE(c.constraints[0].constraint.relative);
    EXPECT_EQ(c.constraints[1].constraint.equals, 0.3);
    EXPECT_EQ(c.output.dir, folder.path() / "here");
    EXPECT_EQ(c.output.paraview, ParaView::none);
}

TEST_F(CaseFile, SplitAndPlanes) {
    const Case c = load(minimal() +
                        "symmetry: {plane: {normal: [0, 2, 0]}, at: 3}\n"
                        "parameters: {split: {containing: [3, {near: [1cm, 0, 0]}]}, variables_on: [wing.upper]}\n");
    EXPECT_EQ(c.symmetry->normal, Eigen::Vector3d(0, 1, 0));
    EXPECT_EQ(c.symmetry->offset, 3);
    const SplitEntry& split = c.parameters.split;
    EXPECT_EQ(split.kind, SplitEntry::Kind::containing);
    EXPECT_EQ(std::get<int>(split.containing[0].first), 3);
    EXPECT_EQ(std::get<NearPoint>(split.containing[1].first).point, Eigen::Vector3d(10, 0, 0));
    EXPECT_EQ(c.parameters.variables_on[0].name, "wing.upper");
    EXPECT_EQ(load(minimal() + "parameters: {split: {largest: 2}}").parameters.split.largest, 2);
    EXPECT_EQ(load(minimal() + "symmetry: {plane: z}").symmetry->normal, Eigen::Vector3d(0, 0, 1));
}

TEST_F(CaseFile, VariablesTiesAndStarts) {
    const Case c = load(minimal() + R"(regions: {tip: {component: 0}}
parameters:
  split: sensitivity
  marking_fraction: 0.5
  max_variable_ratio: 2.5
  variables: [strain_translation, load]
  directions: [[0, 0, -2], [3, 0, 4]]
  free_border: 40%
  frozen: [tip]
  groups: [[p1.1, p1.2], [tip, p2]]
  mirror: true
optimize: {method: NLOPT_LD_TNEWTON_PRECOND_RESTART, starts: 3, seed: 7, finite_differences: true, symmetry: false}
)");
    const ParameterEntry& p = c.parameters;
    EXPECT_EQ(p.split.kind, SplitEntry::Kind::sensitivity);
    EXPECT_EQ(p.marking_fraction, 0.5);
    EXPECT_EQ(p.max_variable_ratio, 2.5);
    EXPECT_EQ(p.variables, (std::vector<VariableKind>{VariableKind::strain, VariableKind::load}));
    EXPECT_FALSE(p.strain_rotates);
    EXPECT_TRUE(p.strain_translates);
    EXPECT_EQ(p.directions[0], Eigen::Vector3d(0, 0, -1));
    EXPECT_TRUE(p.directions[1].isApprox(Eigen::Vector3d(0.6, 0, 0.8)));
    EXPECT_EQ(p.free_border, 0.4);
    EXPECT_EQ(p.frozen[0].name, "tip");
    ASSERT_EQ(p.groups.size(), 2u);
    EXPECT_EQ(p.groups[1][1].name, "p2");
    EXPECT_TRUE(c.optimize.ignores_symmetry);
    EXPECT_TRUE(p.mirror);
    EXPECT_EQ(c.optimize.method, Method::tnewton);
    EXPECT_EQ(c.optimize.starts, 3);
    EXPECT_EQ(c.optimize.seed, 7u);
    EXPECT_TRUE(c.optimize.finite_differences);
    const Case again = load_case(folder.write("again.yaml", resolved_case(c, folder.path())));
    EXPECT_EQ(again.parameters.directions.size(), 2u);
    EXPECT_EQ(again.parameters.free_border, 0.4);
    EXPECT_EQ(load(minimal() + "parameters: {split: gradient}").parameters.split.kind, SplitEntry::Kind::gradient);
    EXPECT_TRUE(load(minimal() + "parameters: {variables: [strain]}").parameters.strain_rotates);
}

TEST_F(CaseFile, EveryMethodIsUnderstoodByItsNameAndByNlopts) {
    EXPECT_EQ(load(minimal() + "optimize: {method: nlopt_slsqp}\n").optimize.method, Method::nlopt_slsqp);
    for (const MethodFacts& method : all_methods())
        for (const std::string& name : {std::string(method.name), std::string(method.algorithm),
                                        std::string("NLOPT_") + method.algorithm, algorithm_word(method.algorithm)})
            if (method.method != Method::nlopt_slsqp) {  // its algorithm's name is that of sqp until 1.0
                EXPECT_EQ(load(minimal() + "optimize: {method: " + name + "}\n").optimize.method, method.method)
                    << name;
            }
}

TEST_F(CaseFile, ResolvedCaseLoadsFromElsewhereAndIsItsOwnResolution) {
    const std::string cases[] = {
        minimal() + R"(regions: {flap: {triangles: flap.txt}, "a-b": {component: 0}, "null": {component: 0}}
fixed: [flap, "null"]
quantities:
  "my-aero": {command: [./run_cfd.sh, "{surface}", "a \"b\"\n#c"], outputs: [drag]}
  t: {type: target_shape, file: ./wing.obj}
objective: {minimize: my-aero.drag}
constraints: {t: {max: 2}}
)",
        minimal() + "quantities: {t: {type: target_shape, file: wing.obj}}\nfit: [t]\n", minimal() + R"(quantities:
  t: {type: thickness, at: lines.csv}
  p: {type: measured_points, file: lines.csv}
  s: {type: section_area, plane: {normal: [0, 0, 2], at: 0.5}, target: 0.1}
fit: [t, p, s]
optimize: {loss: cauchy, loss_scale: 0.5, icp_iterations: 2}
)",
        minimal() + "quantities: {t: {type: thickness, at: lines.csv}}\nobjective: {maximize: t.1}\n"};
    folder.write("lines.csv", "0.2,0.2,0.1,0,0,1,0.5\n");
    for (const std::string& yaml : cases) {
        const Case c = load(yaml);
        const std::filesystem::path run = folder.path() / "runs" / "wing 1";
        const std::string resolved = resolved_case(c, run);
        const Case again = load_case(folder.write("runs/wing 1/case.yaml", resolved));
        EXPECT_EQ(resolved_case(again, run), resolved);
        const auto same = [](const std::filesystem::path& a, const std::filesystem::path& b) {
            return a.lexically_normal() == b.lexically_normal();
        };
        EXPECT_TRUE(same(again.surface, c.surface)) << again.surface;
        EXPECT_TRUE(same(again.output.dir, c.output.dir)) << again.output.dir;
        EXPECT_EQ(again.quantities.size(), c.quantities.size());
        EXPECT_NE(resolved.find("evaluations: 60"), std::string::npos) << "defaults are written";
        EXPECT_EQ(again.regions.size(), c.regions.size());
        if (const auto* external = std::get_if<ExternalEntry>(&again.quantities[0].what)) {
            EXPECT_EQ(external->command[2], "a \"b\"\n#c");
        }
    }
}

TEST(Schema, EveryDefaultIsLegalAndEveryKeyIsDescribed) {
    for (const Key& key : schema()) {
        EXPECT_GT(key.doc.size(), 5u) << key.path;
        EXPECT_EQ(key.doc.back(), '.') << key.path;
        EXPECT_FALSE(key.required && !key.fallback.empty()) << key.path;
    }
}

TEST(Schema, ReferencePageIsTheGeneratedOne) {
    std::ifstream in(STRAKE_SOURCE_DIR "/docs/cases.md");
    std::stringstream page;
    page << in.rdbuf();
    EXPECT_EQ(page.str(), schema_reference()) << "run: strake schema > docs/cases.md";
}

}  // namespace
}  // namespace strake
