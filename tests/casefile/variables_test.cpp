#include "casefile/load_case.hpp"
#include "casefile/model/case.hpp"
#include "casefile/read/resolved_case.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <numbers>

/// `variables:`, `depends_on` and `start_from` in a case file.
namespace strake {
namespace {

class Variables : public BuildProblem {
protected:
    Variables() { surface(icosphere(1)); }
    static std::string with(const std::string& variables, const std::string& quantity = "",
                            const std::string& more = "") {
        return "shell: {thickness: 10%, spring: 1}\nparameters: {levels: auto, patches_per_level: [2]}\n"
               "variables:\n  " +
               variables + "\nquantities: {q: {command: [\"true\"]" + quantity + "}}\nobjective: {minimize: q}\n" +
               more;
    }
};

}  // namespace

TEST_F(Variables, DegreesAndRadiansAgree) {
    const Problem degrees = build(with("alpha: {start: 3deg, min: 0, max: 6deg}")).problem;
    const Problem radians =
        build(with("alpha: {start: 0.05235987755982989rad, min: 0rad, max: 0.10471975511965978rad}")).problem;
    ASSERT_EQ(degrees.program_parameters.size(), 1u);
    EXPECT_NEAR(degrees.program_parameters[0].start, std::numbers::pi / 60, 1e-16);
    EXPECT_EQ(degrees.program_parameters[0].start, radians.program_parameters[0].start);
    EXPECT_EQ(degrees.program_parameters[0].max, radians.program_parameters[0].max);
    EXPECT_TRUE(degrees.program_parameters[0].is_angle);
    const Problem number = build(with("mach: {start: 0.8, min: 0.7, max: 0.9}")).problem;
    EXPECT_FALSE(number.program_parameters[0].is_angle);
    EXPECT_EQ(number.program_parameters[0].start, 0.8);
}

TEST_F(Variables, TheResolvedCaseHoldsThem) {
    const Case c = load_case(folder.write(
        "case.yaml", "surface: {file: s.obj}\n" + with("alpha: {start: 3deg, min: 0, max: 6deg}",
                                                       ", depends_on: [alpha]", "optimize: {start_from: runs/a}\n")));
    const std::string resolved = resolved_case(c, folder.path());
    EXPECT_TRUE(contains(resolved, "variables:\n  alpha: {start: 3deg, min: 0, max: 6deg}\n")) << resolved;
    EXPECT_TRUE(contains(resolved, "depends_on: [alpha]")) << resolved;
    EXPECT_TRUE(contains(resolved, "start_from: \"runs/a\"")) << resolved;
    EXPECT_TRUE(contains(resolved_case(c, folder.path() / "runs/b"), "start_from: \"" + folder.path().string()))
        << "another folder sees it by its absolute path";
    EXPECT_EQ(load_case(folder.write("again.yaml", resolved)).variables.at(0).variable.max,
              c.variables[0].variable.max);
}

TEST_F(Variables, ErrorsNameThePlace) {
    const std::string ok = "alpha: {start: 3deg, min: 0, max: 6deg}";
    const std::pair<std::string, std::string> wrong[] = {
        {with("alpha: {start: 3, min: 0, max: 6deg}"),
         "case.yaml:6:18: variables.alpha.start = 3 must be an angle with a unit (deg or rad), like 6deg"},
        {with("alpha: {start: 7deg, min: 0, max: 6deg}"),
         "case.yaml:6:18: variables.alpha.start = 7deg must be in [0, 6deg]"},
        {with("alpha: {start: 3deg, min: 6deg, max: 0}"),
         "case.yaml:6:29: variables.alpha.min = 6deg must be < max = 0"},
        {with("alpha: {start: 3grad, min: 0, max: 1}"),
         "case.yaml:6:18: variables.alpha.start = 3grad must be a number, or an angle with a unit, for example 5deg or "
         "0.1rad"},
        {with("alpha: {start: 3deg, min: 0}"), "case.yaml:6:10: variables.alpha.max is missing"},
        {with("alpha: {start: 3deg, min: 0, mxa: 6deg}"), "case.yaml:6:32: unknown key 'mxa'"},
        {with("a.b: {start: 3, min: 0, max: 6}"), "case.yaml:6:3: variables.a.b must be a name"},
        {with("q: {start: 3, min: 0, max: 6}"), "case.yaml:6:3: variables.q: a quantity has the same name"},
        {with("level: {start: 3, min: 0, max: 6}"),
         "case.yaml:6:3: variables.level: this is a column of history.csv; choose another name"},
        {with(ok, ", depends_on: [alhpa]"),
         "variable 'alhpa' is not declared; did you mean 'alpha'?; variables: alpha"},
        {with(ok, ", depends_on: []"), "case.yaml:6:3: variables.alpha: no quantity depends on it"},
        {with(ok, "", "optimize: {start_from: nowhere}\n"), "case.yaml:9:24: optimize.start_from = "},
        {with(ok, "", "optimize: {start_from: nowhere}\n"), "nowhere: there is no such folder"},
        {with(ok, "", "optimize: {start_from: .}\n"), "no design is stored there"},
    };
    for (const auto& [yaml, message] : wrong) EXPECT_TRUE(contains(error(yaml), message)) << error(yaml) << message;
    EXPECT_EQ(error(with(ok)), "");
    const std::string fit =
        "variables: {a: {start: 0, min: 0, max: 1}}\nfit: [t]\nquantities: {t: {type: target_shape, "
        "file: s.obj}}\nshell: {thickness: 10%, spring: 1}\n";
    EXPECT_TRUE(contains(error(fit), "case.yaml:3:1: variables are not supported together with fit")) << error(fit);
}

TEST_F(Variables, TheShapeMayStayAsItIs) {
    const std::string none = "parameters: {variables: []}\nshell: {thickness: 10%, spring: 1}\n";
    const std::string program = "quantities: {q: {command: [\"true\"]}}\nobjective: {minimize: q}\n";
    const Problem problem = build(none + program + "variables: {mach: {start: 0.8, min: 0.7, max: 0.9}}\n").problem;
    EXPECT_TRUE(problem.parameters.kinds.empty());
    EXPECT_TRUE(contains(error(none + program), "case.yaml:3:25: parameters.variables is empty"))
        << error(none + program);
}

}  // namespace strake
