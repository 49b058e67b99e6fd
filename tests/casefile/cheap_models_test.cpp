#include "tests/casefile/build_fixture.hpp"

/// quantities.*.low_fidelity in a case file.
namespace strake {
namespace {

class CheapModels : public BuildProblem {
protected:
    CheapModels() { surface(ellipsoid({2, 1, 0.6}, 2)); }
    static std::string with(const std::string& low_fidelity, const std::string& more = "",
                            const std::string& optimize = "finite_differences: true") {
        return "axes: {downstream: +x, up: +z}\nregions: {nose: {box: [[-3, -2, -2], [-1.5, 2, 2]]}}\nfixed: [nose]\n"
               "parameters: {patches_per_level: [4], variables: [normal]}\n"
               "quantities:\n"
               "  flow: {command: [sh, -c, exit], outputs: [drag, lift], gradients: false, low_fidelity: " +
               low_fidelity +
               "}\n  newton: {type: newtonian, mach: 6}\n  wave: {type: wave_drag}\n"
               "  half: {expression: \"newton.drag / 2\"}\n  twice: {expression: \"2 * flow.drag\"}\n" +
               more + "objective: {minimize: flow.drag}\noptimize: {" + optimize + "}\n";
    }
    std::vector<std::string> models(const std::string& yaml) {
        std::vector<std::string> all;
        for (const CheapModel& m : build(yaml).problem.cheap_models) all.push_back(m.value + " by " + m.low);
        return all;
    }
};

using Words = std::vector<std::string>;

TEST_F(CheapModels, AreReadAsAQuantityOrByValue) {
    EXPECT_EQ(models(with("newton")), (Words{"flow.drag by newton.drag", "flow.lift by newton.lift"}));
    EXPECT_EQ(models(with("{drag: half}")), (Words{"flow.drag by half"}));
    EXPECT_EQ(models(with("{drag: wave, lift: newton.lift}")),
              (Words{"flow.drag by wave", "flow.lift by newton.lift"}));
    EXPECT_EQ(models(with("{drag: area}")), (Words{"flow.drag by area"})) << "has no entry";
    const std::string coarse = "  coarse: {command: [sh, -c, exit], outputs: [drag], gradients: false}\n";
    EXPECT_EQ(models(with("coarse", coarse)), (Words{"flow.drag by coarse.drag"}));
    const BuiltProblem built = build(with("coarse", coarse));
    ASSERT_EQ(built.problem.cheap_programs.size(), 1u);
    EXPECT_EQ(built.problem.cheap_programs[0].names, Words{"coarse.drag"});
    EXPECT_TRUE(build(with("newton")).problem.cheap_programs.empty());
}

/// Neither would be used.
TEST_F(CheapModels, AChainAndOneThatNobodyAsksForAreRefused) {
    const std::string coarse =
        "  coarse: {command: [sh, -c, exit], outputs: [drag], gradients: false, low_fidelity: {drag: wave}}\n";
    const std::string chain = error(with("coarse", coarse));
    EXPECT_TRUE(contains(chain,
                         "quantities.coarse.low_fidelity: 'coarse' is itself the cheap model of 'flow.drag', and "
                         "a chain of cheap models is not used; remove this one"))
        << chain;
    const std::string idle = error(with("newton", coarse));
    EXPECT_TRUE(contains(idle, "quantities.coarse.low_fidelity: neither the objective nor a constraint takes 'coarse'"))
        << idle;
    EXPECT_EQ(error(with("newton", coarse + "  both: {expression: flow.drag + coarse.drag}\n") +
                    "constraints: {both: {max: 3}}\n"),
              "");
}

TEST_F(CheapModels, WhatIsNoneIsRefusedWithItsPlace) {
    EXPECT_TRUE(contains(error(with("newtn")), "quantities.flow.low_fidelity: quantity 'newtn' is not known"))
        << error(with("newtn"));
    EXPECT_TRUE(contains(error(with("{drag: wavy}")), "did you mean 'wave'?")) << error(with("{drag: wavy}"));
    EXPECT_TRUE(contains(error(with("newtn")), "did you mean 'newton'?")) << error(with("newtn"));
    EXPECT_TRUE(contains(error(with("{}")), "low_fidelity: names nothing")) << error(with("{}"));
    EXPECT_TRUE(contains(error(with("{drgg: wave}")), "the program has no output 'drgg'; outputs: drag, lift"))
        << error(with("{drgg: wave}"));
    EXPECT_TRUE(contains(error(with("wave")), "'wave' has no value of the same name as one of drag, lift"))
        << error(with("wave"));
    EXPECT_TRUE(contains(error(with("newton.drag")), "'newton.drag' is one value, and the program has 2"))
        << error(with("newton.drag"));
    EXPECT_TRUE(contains(error(with("flow")), "'flow.drag' depends on 'flow' itself")) << error(with("flow"));
    EXPECT_TRUE(contains(error(with("{drag: twice}")), "'twice' depends on 'flow' itself"))
        << error(with("{drag: twice}"));
    EXPECT_TRUE(contains(error(with("newton", "", "method: cobyla")), "low_fidelity needs optimize.method: sqp"))
        << error(with("newton", "", "method: cobyla"));
}

}  // namespace
}  // namespace strake
