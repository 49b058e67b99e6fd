#include "core/planform/planform_motion.hpp"
#include "optimize/check/start_check.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <map>

/// Bodies by their length, under `planform`.
namespace strake {
namespace {

class Bodies : public BuildProblem {
protected:
    Bodies() { surface(ellipsoid({4, 1, 0.8}, 4)); }
    static std::string frame(const std::string& rest) {
        return "hold: none\nshell: none\nplanform:\n  hull: {length: x, stations: [0, 0.3, 0.7, 1], values: "
               "[height@0.7]}\n" +
               rest;
    }
};

TEST_F(Bodies, HaveValuesAndVariables) {
    const BuiltProblem built =
        build(frame("parameters:\n  planform:\n    hull.length: {range: [-5%, 5%]}\n"
                    "    hull.width: {by: station, range: [-10%, 10%]}\n    hull.camber@0.3: {range: [-2%, 2%]}\n"
                    "objective: {minimize: hull.length / hull.width@0.3}\n"
                    "constraints: {hull.width@0.7: {min: 0.9, relative: true}}\n"));
    ASSERT_TRUE(built.problem.parameters.planform);
    std::string names;
    for (const auto& v : built.problem.parameters.planform->variables()) names += v.name + " ";
    EXPECT_EQ(names, "hull.delta_length hull.delta_width@0.3 hull.delta_width@0.7 hull.delta_camber@0.3 ");
    std::map<std::string, double> found;
    for (const auto& quantity : check_start(built.problem).quantities)
        for (const auto& value : quantity.values) found[value.name] = value.value;
    EXPECT_NEAR(found.at("hull.length") / found.at("hull.width@0.3"), 4 / std::sqrt(0.84), 0.05);
    EXPECT_NEAR(found.at("hull.height@0.7") / found.at("hull.width@0.7"), 0.8, 0.01);
}

/// `deform` looks for patches only where the case names one.
TEST_F(Bodies, MayBeAPatch) {
    surface(box_surface({4, 1, 0.5}, 8));
    const std::string rest = "parameters: {fields: {number: 4}}\nobjective: {minimize: area}\n";
    const auto on = [&](const std::string& name) {
        return "hold: none\nshell: none\nplanform: {hull: {on: " + name + ", length: x}}\n" + rest;
    };
    const std::string patch = build(on("all")).problem.tree.levels.back().patches.back().name;
    EXPECT_EQ(error(on(patch), Purpose::deform), "") << patch;
    EXPECT_TRUE(contains(error(on("no" + patch), Purpose::deform), "is no region, part of the surface file or patch"));
}

TEST_F(Bodies, WhatIsWrongIsSaidWhereItStands) {
    const std::string goal = "objective: {minimize: area}\nparameters:\n  planform:\n    ";
    for (const auto& [line, words] : std::vector<std::pair<std::string, std::string>>{
             {"hull.twist: {range: [-1deg, 1deg]}", "hull.twist is a change of wings"},
             {"hull.width@0.4: {range: [-1%, 1%]}", "there is no such station; stations: 0, 0.3, 0.7, 1"},
             {"hull.width: {range: [-1, 1]}", "needs a unit: a percentage"},
             {"hul.width: {range: [-1%, 1%]}",
              "no wing or body 'hul' is declared under planform; did you mean 'hull'?"}})
        EXPECT_TRUE(contains(error(frame(goal + line + "\n")), words)) << error(frame(goal + line + "\n"));
    const std::string of_another = "parameters: {fields: auto}\nobjective: {minimize: hul.width@0.5}\n";
    EXPECT_TRUE(contains(error(frame(of_another)), "no wing or body 'hul' is declared under planform; declared: hull"));
    const std::string rest = "parameters: {fields: auto}\nobjective: {minimize: area}\n";
    for (const auto& [entry, words] : std::vector<std::pair<std::string, std::string>>{
             {"{length: x, span: y}", "has span and length; a wing has a span, a body a length"},
             {"{stations: [0, 1]}", "planform.hull.span is missing; a body has length in its place"},
             {"{length: z}", "its length and up must be perpendicular"},
             {"{length: x, keep: none}", "planform.hull.keep"},
             {"{length: x, on: tail}", "tail"},
             {"{length: x, values: [with@0.5]}", "a body has no value 'with'"},
             {"{length: x, values: [width]}", "write 'width@0.5' with a fraction of the length"},
             {"{length: x, stations: [0.5, 0.2]}", "must be in [0, 1] and above the one before"}})
        EXPECT_TRUE(contains(error("hold: none\nshell: none\nplanform:\n  hull: " + entry + "\n" + rest), words))
            << error("hold: none\nshell: none\nplanform:\n  hull: " + entry + "\n" + rest);
}

}  // namespace
}  // namespace strake
