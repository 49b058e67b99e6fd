#include "casefile/read/resolved_case.hpp"
#include "cases/geometry/dirty_body.hpp"
#include "core/fields/displacement_fields.hpp"
#include "tests/casefile/build_fixture.hpp"

namespace strake {
namespace {

using CaseWithoutShell = BuildProblem;

const std::string dirty = R"(regions:
  nose: {box: [[-9, -9, -9], [-1.6, 9, 9]]}
fixed: [nose]
shell: none
objective: {maximize: volume}
constraints: {area: {max: 1.01, relative: true}}
)";

TEST_F(CaseWithoutShell, TakesDirtyBodiesWithAllFields) {
    // without_shell_test has all kinds; 192 fields of each take half a minute under sanitizers.
    for (const std::string kind : {"wing_through_body", "flipped_parts", "t_junctions"}) {
        const TriMesh mesh = example::dirty_body(kind);
        surface(mesh);
        if (kind == "t_junctions") {  // each panel by itself encloses nothing
            EXPECT_TRUE(contains(error(dirty), "encloses no volume")) << error(dirty);
            continue;
        }
        const Problem problem = build(dirty).problem;
        EXPECT_FALSE(problem.has_shell) << kind;
        EXPECT_EQ(problem.surface.triangles, mesh.triangles) << kind << ": nothing is mended";
        EXPECT_TRUE(problem.parameters.kinds.empty());
        ASSERT_NE(problem.parameters.fields, nullptr) << kind;
        EXPECT_EQ(problem.parameters.field_steps.front(), 27) << kind;
        EXPECT_EQ(problem.prism_height.size(), 0);
    }
}

/// Fields need no patches: they were cut all the same, for a quarter of the time of a short run.
TEST_F(CaseWithoutShell, IsCutIntoPatchesOnlyWhereTheCaseAsks) {
    surface(icosphere(2));
    const std::string yaml = "hold: none\nshell: none\nobjective: {maximize: volume}\nparameters: {fields: 6";
    const PatchHierarchy whole = build(yaml + "}\n").problem.tree;
    ASSERT_EQ(whole.levels.size(), 2);
    EXPECT_EQ(whole.levels[1].patches.size(), 1);
    const Case c = load_case(folder.write("whole.yaml", "surface: {file: s.obj}\n" + yaml + "}\n"));
    EXPECT_EQ(resolved_case(c, folder.path()).find("patches_per_level"), std::string::npos) << "would read as stated";
    const PatchHierarchy asked = build(yaml + ", patches_per_level: [4]}\n").problem.tree;
    ASSERT_GT(asked.levels[1].patches.size(), 1);
    const std::string named = "}\nregions: {top: {patch: \"" + asked.levels[1].patches[0].name + "\"}}\n";
    EXPECT_GT(build(yaml + named).problem.tree.levels[1].patches.size(), 1);
}

TEST_F(CaseWithoutShell, OfACleanBodyMeasuresTheSame) {
    surface(icosphere(2));
    const std::string yaml =
        "regions: {low: {box: [[-9, -9, -9], [-0.7, 9, 9]]}}\nfixed: [low]\n"
        "parameters: {fields: 6, variables: []}\nobjective: {maximize: volume}\n";
    const Problem with = build(yaml).problem, without = build(yaml + "shell: none\n").problem;
    EXPECT_EQ(with.quantities[0].evaluate({with.surface, false, 1, 0, {}}).values,
              without.quantities[0].evaluate({without.surface, false, 1, 0, {}}).values);
    EXPECT_EQ(with.parameters.fields->field(3), without.parameters.fields->field(3));
}

TEST_F(CaseWithoutShell, RefusesWhatNeedsAShellWithItsLine) {
    surface(example::dirty_body("crossing_boxes"));
    const auto refusal = [&](const std::string& words) { return error(dirty + words); };
    EXPECT_TRUE(contains(refusal("parameters: {variables: [normal]}\n"),
                         "case.yaml:9:25: parameters.variables need an elastic shell, and shell: none leaves it out"))
        << refusal("parameters: {variables: [normal]}\n");
    EXPECT_TRUE(contains(refusal("loads: [{region: nose, spring: 2}]\n"), "loads need an elastic shell"));
    EXPECT_TRUE(contains(refusal("strains: [{region: nose, rotate: [0, 0, 1]}]\n"), "strains need an elastic shell"));
    EXPECT_TRUE(contains(refusal("attach: [{part: cabin, to: hull}]\n"), "attach needs an elastic shell"));
    EXPECT_TRUE(contains(refusal("parameters: {given: [{name: n, region: nose, load: normal}]}\n"),
                         "parameters.given 'n' needs an elastic shell"));
    EXPECT_TRUE(contains(refusal("parameters: {fields: none}\n"), "write parameters: {fields: auto}"))
        << refusal("parameters: {fields: none}\n");
    EXPECT_TRUE(contains(error("shell: nothing\n"), "case.yaml:3:8: shell = nothing"));
}

TEST_F(CaseWithoutShell, ARoughCutIsSnappedWhenAsked) {
    const TriMesh rough = example::dirty_body("rough_cut");
    surface(rough);
    const std::string half = dirty + "symmetry: {plane: y, at: 0";
    const std::string refused = error(half + "}\n");
    EXPECT_TRUE(contains(refused, "symmetry: {snap: 0.0")) << refused;
    const BuiltProblem built = build(half + ", snap: 0.01%}\n");
    EXPECT_TRUE(built.is_prepared);
    const TriMesh& mesh = built.problem.surface;
    double farthest = 0;
    int on_plane = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        farthest = std::max(farthest, (mesh.vertices.row(v) - rough.vertices.row(v)).norm());
        on_plane += mesh.vertices(v, 1) == 0;
    }
    EXPECT_GT(on_plane, 30);
    EXPECT_GT(farthest, 1e-5);
    EXPECT_LT(farthest, 1e-4 * 4.3);
    EXPECT_TRUE(std::any_of(built.notes.begin(), built.notes.end(), [](const std::string& note) {
        return note.find("moved onto the plane, by at most") != std::string::npos;
    }));
    const Points u =
        built.problem.parameters.fields->displacement(Eigen::VectorXd::Ones(built.problem.parameters.fields->size()));
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (mesh.vertices(v, 1) == 0) {
            EXPECT_EQ(u(v, 1), 0) << "the cut stays planar";
        }
}

TEST_F(CaseWithoutShell, RefusesWhatHasNoTrianglesOrArea) {
    TriMesh needle;
    needle.vertices.resize(3, 3);
    needle.vertices << 0, 0, 0, 1, 0, 0, 2, 0, 0;
    needle.triangles.resize(1, 3);
    needle.triangles << 0, 1, 2;
    surface(needle);
    EXPECT_TRUE(contains(error("shell: none\nobjective: {minimize: area}\n"), "the surface has no area"));
}

}  // namespace
}  // namespace strake
