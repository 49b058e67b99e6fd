#include "core/fields/displacement_fields.hpp"
#include "tests/casefile/build_fixture.hpp"

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
    EXPECT_EQ(build(body).problem.parameters.fields, nullptr) << "none by default";
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

TEST_F(FieldsOfACase, WrongOnesAreErrorsWithTheirLine) {
    surface(box_surface({4, 1, 0.5}, 4));
    const auto refusal = [&](const std::string& words) {
        return error(std::string(body) + "parameters: {" + words + "}\n");
    };
    EXPECT_TRUE(contains(refusal("fields: 0"), "parameters.fields = 0 must be in [1, 600]")) << refusal("fields: 0");
    EXPECT_TRUE(contains(refusal("fields: many"), "case.yaml:8:")) << refusal("fields: many");
    EXPECT_TRUE(contains(refusal("fields: {axis: [0, 0, 0]}"), "parameters.fields.axis = [0, 0, 0] has no direction"));
    EXPECT_TRUE(contains(refusal("fields: {on: tpi}"), "parameters.fields.on: 'tpi' is not a declared region"));
    EXPECT_TRUE(contains(refusal("variables: []"), "nothing can change"));
}

}  // namespace
}  // namespace strake
