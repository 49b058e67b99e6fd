#include "casefile/read/resolved_case.hpp"
#include "cases/geometry/dirty_body.hpp"
#include "core/mesh/topology.hpp"
#include "core/wrap/alpha_wrap.hpp"
#include "core/wrap/halves.hpp"
#include "core/wrap/wrap_map.hpp"
#include "optimize/check/gradient_check.hpp"
#include "optimize/space/rest_facts.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <algorithm>
#include <set>

namespace strake {
namespace {

class CaseWithWrap : public BuildProblem {
protected:
    void SetUp() override {
        if (!has_alpha_wrap())
            GTEST_SKIP() << "built without the alpha wrap (-DSTRAKE_GPL=OFF)";  // it is CGAL's, under the GPL
    }
};

const std::string held = R"(regions:
  nose: {box: [[-9, -9, -9], [-1.6, 9, 9]]}
  tail: {box: [[1, -9, -9], [9, 9, 9]]}
fixed: [nose]
)";
const std::string wrapped = held + "wrap: auto\n";

TEST_F(CaseWithWrap, StandsOnTheWrapAndMeasuresTheBody) {
    const TriMesh mesh = example::dirty_body("wing_through_body");
    surface(mesh);
    const BuiltProblem built =
        build(wrapped +
              "parameters: {levels: auto, patches_per_level: [4], fields: 6, variables: [normal]}\n"
              "loads: [{region: tail, displacement: 2%, direction: [0, 0, 1]}]\nobjective: {maximize: volume}\n");
    const Problem& problem = built.problem;
    ASSERT_NE(problem.wrap, nullptr);
    const TriMesh& around = problem.wrap->mesh();
    EXPECT_EQ(problem.surface.triangles, mesh.triangles) << "nothing is mended";
    EXPECT_EQ(elastic_surface(problem).num_triangles(), around.num_triangles());
    EXPECT_EQ(problem.prism_height.size(), around.num_vertices());
    EXPECT_EQ(problem.tree.levels[1].label.size(), static_cast<std::size_t>(around.num_triangles()));
    EXPECT_EQ(problem.given_traction.rows(), around.num_triangles());
    EXPECT_EQ(problem.fixed, region(built, "nose"));
    // The wrap is held beyond what of the body is.
    const Points c = triangle_centroids(around);
    for (int t = 0; t < around.num_triangles(); ++t)
        if (c(t, 0) < -1.7) {
            EXPECT_TRUE(std::ranges::binary_search(problem.supports, t)) << c(t, 0);
        } else if (c(t, 0) > -0.5) {
            EXPECT_FALSE(std::ranges::binary_search(problem.supports, t)) << c(t, 0);
        }
    for (int t = 0; t < around.num_triangles(); ++t)
        if (c(t, 0) < 0.5) {
            EXPECT_TRUE(problem.given_traction.row(t).isZero(0)) << c(t, 0);
        }
    EXPECT_FALSE(problem.given_traction.isZero(0));
    EXPECT_NO_THROW(rest_facts(problem));
    ASSERT_FALSE(built.notes.empty());
    EXPECT_TRUE(contains(built.notes.back(), "wrap: ")) << built.notes.back();
}

TEST_F(CaseWithWrap, MotionsTurnAboutTheBodysRegion) {
    const TriMesh mesh = example::dirty_body("wing_through_body");
    surface(mesh);
    const BuiltProblem built =
        build(held + "wrap: {alpha: 4%}\n" +
              "parameters: {levels: auto, patches_per_level: [4], variables: [normal], "
              "given: [{name: tilt, region: tail, rotate: [0, 1, 0]}]}\nobjective: {maximize: volume}\n");
    ASSERT_EQ(built.problem.parameters.user_variables.size(), 1u);
    const Eigen::Vector3d about = built.problem.parameters.user_variables[0].motion.about,
                          of_body = area_centroid(mesh, region(built, "tail")),
                          of_wrap = area_centroid(elastic_surface(built.problem),
                                                  built.problem.parameters.user_variables[0].triangles);
    EXPECT_EQ(about, of_body);
    EXPECT_GT((of_wrap - of_body).norm(), 1e-3) << "the test can fail";
}

TEST_F(CaseWithWrap, IsStatedForRunsThatGoOn) {
    surface(example::dirty_body("crossing_boxes"));
    const std::string rest =
        "parameters: {levels: auto, patches_per_level: [4], variables: [normal]}\n"
        "objective: {maximize: volume}\n";
    const BuiltProblem built = build(wrapped + rest);
    const Case the_case = load_case(folder.path() / "case.yaml", Purpose::any);
    const std::string resolved = resolved_case(the_case, folder.path(), built.wrap);
    EXPECT_EQ(stated_wrap(resolved), built.wrap) << resolved;
    EXPECT_EQ(stated_wrap(resolved_case(the_case, folder.path())), "");
    const BuiltProblem again = build_problem(load_case(folder.write("again.yaml", resolved), Purpose::any));
    ASSERT_NE(again.problem.wrap, nullptr);
    EXPECT_EQ(again.problem.wrap->mesh().vertices, built.problem.wrap->mesh().vertices) << "the same bits";
    EXPECT_EQ(again.wrap, built.wrap);
    const BuiltProblem coarse = build(held + "wrap: {alpha: 4%}\n" + rest);
    EXPECT_LT(coarse.problem.wrap->mesh().num_triangles(), built.problem.wrap->mesh().num_triangles() / 2);
}

TEST_F(CaseWithWrap, HalfBodiesAndMirroredOnes) {
    const TriMesh whole = example::dirty_body("crossing_cylinders");
    surface(clipped(whole, {{0, 1, 0}, 0}, 1e-9));
    const std::string rest =
        "hold: point\nparameters: {levels: auto, patches_per_level: [4], variables: [normal]}\n"
        "objective: {maximize: area}\nwrap: auto\n";
    const BuiltProblem half = build(rest + "symmetry: {plane: y}\n");
    const TriMesh& around = half.problem.wrap->mesh();
    EXPECT_GE(around.vertices.col(1).minCoeff(), 0);
    EXPECT_FALSE(topology(around, adjacency(around)).closed);
    EXPECT_EQ(half.problem.supports.size(), 1u) << "one triangle of the wrap, in however many parts the body is";
    TriMesh mirrored = with_mirror_image(clipped(whole, {{0, 1, 0}, 0}, 1e-9), {{0, 1, 0}, 0}, 0).mesh;
    surface(mirrored);
    const BuiltProblem both = build(
        "hold: point\nparameters: {levels: auto, patches_per_level: [4], variables: [normal], mirror: true}\n"
        "objective: {maximize: area}\nwrap: auto\n");
    EXPECT_TRUE(rest_facts(both.problem)->mirror.has_value());
}

TEST_F(CaseWithWrap, RefusesWhatStandsOnTheBodysTriangles) {
    surface(example::dirty_body("crossing_boxes"));
    const std::string goal = "objective: {maximize: volume}\n";
    EXPECT_TRUE(contains(error(held + "wrap: auto\nshell: none\nparameters: {fields: 6}\n" + goal),
                         "wrap: with shell: none nothing is elastic"));
    EXPECT_TRUE(contains(error(wrapped + "attach: [{part: cabin, to: tail}]\n" + goal),
                         "attach: the wrap carries all parts of the body"));
    EXPECT_TRUE(contains(error(wrapped + "invariance: {extrude: y}\n" + goal), "invariance: a wrap is no exactly"));
    EXPECT_TRUE(contains(error(held + "wrap: {alpha: 0}\n" + goal), "wrap.alpha"));
    EXPECT_TRUE(contains(error(held + "wrap: {offset: 1%}\n" + goal), "alpha"));
    EXPECT_TRUE(contains(error(held + "wrap: some\n" + goal), "none"));
}

TEST_F(CaseWithWrap, SaysWhereTheBodyIsThin) {
    TriMesh plate = ellipsoid({2, 1, 0.01}, 3);
    surface(plate);
    const BuiltProblem built = build(
        "hold: point\nwrap: auto\nparameters: {variables: [normal]}\n"
        "objective: {maximize: area}\n");
    EXPECT_TRUE(std::ranges::any_of(built.warnings, [](const std::string& words) {
        return contains(words, "of the body's area is thinner than alpha");
    }));
}

TEST(CaseWithoutGpl, SaysSoAndWhatToDo) {
    if (has_alpha_wrap()) GTEST_SKIP() << "built with the alpha wrap";  // about the other build
    EXPECT_THROW(wrap_around(icosphere(2)), InvalidInput);
}

/// Functionals that are defined on a dirty body, as objective and limits.
const std::string functionals = R"(axes: {downstream: +x, up: +z}
objective: {maximize: volume}
quantities:
  change: {type: displacement}
  long: {type: extent, direction: [1, 0, 0], smoothing: 0.05}
  front: {type: projected_area}
  hyper: {type: newtonian, mach: 8}
constraints:
  area: {max: 1.01, relative: true}
  change: {max: 0.01}
  long.length: {max: 1.1, relative: true}
  front: {max: 1.1, relative: true}
  hyper.drag: {max: 2, relative: true}
)";

TEST_F(CaseWithWrap, GradientsOfFiveDirtyBodiesAreExactForEveryFunctional) {
    for (const char* kind : {"wing_through_body", "gaps", "crossing_boxes", "inner_walls", "holes"}) {
        surface(example::dirty_body(kind));
        Problem problem = build(
                              "repair: {orient: true}\nhold: point\nwrap: {alpha: 5%}\n"
                              "parameters: {levels: auto, patches_per_level: [4], fields: 6, variables: [normal], "
                              "max_displacement: 2%}\n" +
                                  functionals,
                              Purpose::run)
                              .problem;
        const GradientCheck check = check_gradients(problem);
        EXPECT_EQ(check.tests.size(), 6U) << kind;
        for (const TaylorTest& test : check.tests) EXPECT_TRUE(test.passed) << kind << ' ' << test.name << test.verdict;
        if (kind != std::string("gaps")) continue;
        for (Quantity& quantity : problem.quantities)
            quantity.evaluate = [exact = quantity.evaluate](const QuantityRequest& request) {
                QuantityResult result = exact(request);
                for (Points& gradient : result.dJ_dv) gradient *= 1.1;
                return result;
            };
        for (const TaylorTest& test : check_gradients(problem).tests) EXPECT_FALSE(test.passed) << test.name;
    }
}

}  // namespace
}  // namespace strake
