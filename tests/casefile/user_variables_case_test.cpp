#include "core/mesh/geometry.hpp"
#include "optimize/space/design_space.hpp"
#include "optimize/space/user_variables.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <algorithm>
#include <numbers>

namespace strake {
namespace {

/// A box of 2 x 1 x 0.2, held at x = 0.
class Given : public BuildProblem {
protected:
    Given() {
        TriMesh box = box_surface({1, 1, 1}, 6);
        box.vertices.col(0) *= 2;
        box.vertices.col(2) *= 0.2;
        surface(box);
    }
    static std::string with(const std::string& given, const std::string& more = "variables: [load]") {
        return "regions:\n"
               "  root: {box: [[0, 0, 0], [0.4, 1, 0.2]]}\n"
               "  tip:  {box: [[1.6, 0, 0], [2, 1, 0.2]]}\n"
               "  end:  {box: [[1.3, 0, 0], [2, 1, 0.2]]}\n"
               "  top:  {plane: {normal: [0, 0, 1], at: 0.2}, side: above}\n"
               "fixed: [root]\n"
               "parameters:\n"
               "  levels: [20deg]\n  " +
               more +
               "\n"
               "  given:\n"
               "    - " +
               given +
               "\n"
               "objective: {maximize: volume}\n";
    }
};

const UserVariable& named(const BuiltProblem& built, const std::string& name) {
    for (const UserVariable& v : built.problem.parameters.user_variables)
        if (v.name == name) return v;
    throw std::out_of_range(name);
}

TEST_F(Given, LoadsAndMotionsAreBuiltAsStated) {
    const BuiltProblem built =
        build(with("{name: up, region: top, load: [0, 0, 3], max_displacement: 1%}\n"
                   "    - {name: out, region: top, load: normal}\n"
                   "    - {name: slide, region: tip, translate: [2, 0, 0]}\n"
                   "    - {name: hinge, region: tip, rotate: [0, 1, 0], about: [1.6, 0, 0.1], "
                   "max_angle: 10deg}"));
    ASSERT_EQ(built.problem.parameters.user_variables.size(), 4u);
    const UserVariable &up = named(built, "up"), &hinge = named(built, "hinge");
    EXPECT_EQ(up.triangles, region(built, "top"));
    EXPECT_TRUE(up.traction.row(0).isApprox(Eigen::RowVector3d(0, 0, 1)));
    EXPECT_NEAR(up.max_displacement, 0.01, 1e-12);
    EXPECT_LT((named(built, "out").traction - up.traction).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_EQ(named(built, "slide").motion.translation, Eigen::Vector3d(1, 0, 0));
    EXPECT_EQ(hinge.motion.rotation, Eigen::Vector3d(0, 1, 0));
    EXPECT_EQ(hinge.motion.about, Eigen::Vector3d(1.6, 0, 0.1));
    EXPECT_NEAR(hinge.unit, 10 * std::numbers::pi / 180, 1e-12);
    const DesignSpace space = design_space(rest_facts(built.problem), 1);
    EXPECT_EQ(space.variables[0].name, "up");
    // "out" does what "up" does.
    ASSERT_FALSE(space.dependent.empty());
    EXPECT_EQ(space.dependent[0].variable.name, "out");
}

TEST_F(Given, TwistHasAVariableForEveryStationThatIsNotHeld) {
    const BuiltProblem built = build(
        with("{name: twist, twist: [1, 0, 0], about: [0, 0.5, 0.1], stations: 3, max_angle: 3deg}", "variables: []"));
    ASSERT_EQ(built.problem.parameters.user_variables.size(), 2u);
    EXPECT_EQ(built.problem.parameters.user_variables[0].name, "twist.2");
    EXPECT_NEAR(built.problem.parameters.user_variables[1].unit, 3 * std::numbers::pi / 180, 1e-12);
    const auto held = [](const std::string& words) { return contains(words, "the section at station 1 (0) is held"); };
    EXPECT_EQ(std::count_if(built.warnings.begin(), built.warnings.end(), held), 1);
    const BuiltProblem listed =
        build(with("{name: t, region: top, twist: [1, 0, 0], about: [0, 0.5, 0.1], stations: [0, 1, 1.9]}"));
    EXPECT_EQ(listed.problem.parameters.user_variables.size(), 2u);
}

TEST_F(Given, SpringsStandUnderGivenLoads) {
    const std::string yaml = with("{name: up, region: top, load: normal}", "variables: []");
    const BuiltProblem built = build(yaml + "shell: {spring: 2}\n");
    ASSERT_GT(built.problem.spring_per_area.size(), 0);
    EXPECT_EQ(built.problem.spring_per_area[region(built, "top")[0]], 2);
    EXPECT_EQ(built.problem.spring_per_area[region(built, "root")[0]], 0);
}

TEST_F(Given, MistakesAreToldWithTheirPlace) {
    const std::pair<const char*, const char*> mistakes[] = {
        {"{name: a, region: tip}",
         "case.yaml:13:7: parameters.given[0] must have exactly one of load, translate, rotate, twist; it has none"},
        {"{name: a, region: tip, load: normal, rotate: [0, 1, 0]}",
         "case.yaml:13:7: parameters.given[0] must have exactly one of load, translate, rotate, twist; it has load, "
         "rotate"},
        {"{name: a, load: normal}", "case.yaml:13:7: parameters.given[0].region is missing"},
        {"{region: tip, load: normal}", "case.yaml:13:7: parameters.given[0].name is missing"},
        {"{name: a.b, region: tip, load: normal}", "case.yaml:13:14: parameters.given[0].name = a.b must be a name"},
        {"{name: a, region: tpi, load: normal}", "case.yaml:13:25: parameters.given: 'tpi' is not a declared region"},
        {"{name: a, region: tip, load: up}", "case.yaml:13:36: parameters.given[0].load = up must be"},
        {"{name: a, region: tip, load: [0, 0, 0]}", "case.yaml:13:36: parameters.given[0].load = [0, 0, 0] has no"},
        {"{name: a, region: tip, load: normal, about: [0, 0, 0]}",
         "case.yaml:13:44: parameters.given[0].about is only allowed with rotate or twist"},
        {"{name: a, region: tip, translate: [0, 0, 1], stations: 3}",
         "case.yaml:13:52: parameters.given[0].stations is only allowed with twist"},
        {"{name: a, twist: [1, 0, 0], about: [0, 0, 0], max_displacement: 1%}",
         "case.yaml:13:53: parameters.given[0].max_displacement is only allowed with load, translate or rotate"},
        {"{name: a, twist: [1, 0, 0]}", "case.yaml:13:7: parameters.given[0].about is missing"},
        {"{name: a, twist: [1, 0, 0], about: [0, 0, 0], stations: [0, 2, 1]}",
         "case.yaml:13:70: parameters.given[0].stations[2] = 1 must be > 2"},
        {"{name: a, twist: [1, 0, 0], about: [0, 0, 0], stations: [0, 7]}",
         "case.yaml:13:7: parameters.given: twist a: the station at 7 must lie in [0, 2]"},
        {"{name: a, region: tip, rotate: [0, 1, 0], max_displacement: 1%, max_angle: 5deg}",
         "case.yaml:13:7: parameters.given[0] must have only one of max_displacement, max_angle"},
        {"{name: a, region: tip, rotate: [0, 1, 0], max_angle: 5}", "case.yaml:13:60: parameters.given[0].max_angle"},
        {"{name: a, region: root, translate: [0, 0, 1]}",
         "case.yaml:13:25: parameters.given: 'root' is moved by 'a' and also under fixed; choose one"},
        {"{name: a, region: top, translate: [0, 0, 1]}", "triangles are also under fixed or strains"},
        {"{name: a, region: tip, translate: [0, 0, 1]}\n    - {name: b, region: end, rotate: [1, 0, 0]}",
         "case.yaml:14:25: parameters.given: 'b': "},
        {"{name: a, region: tip, translate: [0, 0, 1]}\n    - {name: b, region: tip, load: normal}",
         "case.yaml:13:25: parameters.given: 'tip' is moved by 'a' and also under parameters.given 'b' as a load"},
        {"{name: a, region: tip, load: normal}\n    - {name: a, region: top, load: normal}",
         "case.yaml:14:7: parameters.given names 'a' twice"},
    };
    for (const auto& [given, message] : mistakes) {
        const std::string told = error(with(given));
        EXPECT_TRUE(contains(told, message)) << given << "\n" << told;
    }
}

TEST_F(Given, ConflictsWithAutomaticVariablesAreToldWithTheirPlace) {
    const std::string tip = "{name: a, region: tip, translate: [0, 0, 1]}";
    EXPECT_TRUE(
        contains(error(with(tip, "variables_on: [tip]")),
                 "case.yaml:13:25: parameters.given: 'tip' is moved by 'a' and also under parameters.variables_on"));
    EXPECT_TRUE(contains(error(with("{name: a, region: end, translate: [0, 0, 1]}", "variables_on: [tip]")),
                         "leave nothing to load there"));
    EXPECT_TRUE(contains(error(with(tip, "frozen: [tip]")), "also under parameters.frozen"));
    EXPECT_TRUE(contains(error(with("{name: a, region: end, load: normal}", "frozen: [tip]")),
                         "triangles are under parameters.frozen"));
    EXPECT_TRUE(contains(error(with("{name: a, twist: [1, 0, 0], about: [0, 0, 0]}", "variables: [strain]")),
                         "case.yaml:13:7: parameters.given: 'a' is a twist by loads"));
    EXPECT_EQ(error(with(tip)), "");
}

}  // namespace
}  // namespace strake
