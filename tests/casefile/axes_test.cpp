#include "core/mesh/weld.hpp"
#include "objectives/quantity/closed.hpp"
#include "optimize/check/start_check.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <map>

/// `axes` of a case, the keys of quantities that were there before, and the coefficients of half models.
namespace strake {
namespace {

class Axes : public BuildProblem {
protected:
    /// Values at the start, by name.
    std::map<std::string, double> values(const std::string& yaml) {
        const std::string rest =
            "regions: {root: {box: [[-9, -9, -9], [-1.5, 9, 9]]}}\nfixed: [root]\n"
            "parameters: {levels: auto, patches_per_level: [4], variables: [normal], max_displacement: 2%}\n";
        std::map<std::string, double> found;
        for (const auto& quantity : check_start(build(rest + yaml).problem).quantities)
            for (const auto& value : quantity.values) found[value.name] = value.value;
        return found;
    }
    static std::string goal(const std::string& keys, const std::string& goal = "aero.drag") {
        return "quantities:\n  aero: {type: newtonian, mach: 6" + keys + "}\nobjective: {minimize: " + goal + "}\n";
    }
    static TriMesh body() { return ellipsoid({2, 1, 0.6}, 3); }
    /// The side y >= 0 of the body.
    void half() {
        TriMesh whole = box_surface({4, 2, 1}, 4);
        whole.vertices.rowwise() -= Eigen::RowVector3d(2, 1, 0.5);
        for (int v = 0; v < whole.num_vertices(); ++v) {  // a nose, and no two sides alike
            const double x = whole.vertices(v, 0);
            whole.vertices(v, 1) *= 0.75 + 0.2 * x / 2;
            whole.vertices(v, 2) *= 0.6 + 0.3 * x / 2;
            whole.vertices(v, 2) += 0.05 * x * x;
        }
        surface(whole);
        whole_ = whole;
    }
    TriMesh whole_;
};

TEST_F(Axes, OneBlockIsWhatTheOldKeysSaid) {
    surface(body());
    const auto old = values(goal(", forward: [-1, 0, 0], up: [0, 1, 0], alpha: 5deg")),
               now = values("axes: {downstream: -x, up: +y}\n" + goal(", alpha: 5deg")),
               listed = values("axes: {downstream: [-3, 0, 0], up: [0, 2, 0]}\n" + goal(", alpha: 5deg"));
    ASSERT_EQ(old.size(), 7U);
    EXPECT_EQ(old, now);
    EXPECT_EQ(old, listed);
    EXPECT_NE(old.at("aero.lift"), values(goal(", alpha: 5deg")).at("aero.lift"));
}

TEST_F(Axes, WithoutAnyTheStreamGoesAlongX) {
    surface(body());
    EXPECT_EQ(values(goal(", alpha: 5deg")), values("axes: {downstream: +x, up: +z}\n" + goal(", alpha: 5deg")));
}

TEST_F(Axes, EveryQuantityWithAStreamUsesThem) {
    surface(body());
    for (const char* type : {"friction, reynolds: 1e6", "wave_drag", "projected_area", "newtonian, mach: 6"}) {
        const std::string q = std::string("quantities: {q: {type: ") + type + "}}\nobjective: {minimize: area}\n" +
                              "constraints: {" + (std::string(type).starts_with("newt") ? "q.drag" : "q") +
                              ": {max: 1e9}}\n";
        const auto along = values("axes: {downstream: +z, up: -x}\n" + q), without = values(q);
        const std::string name = std::string(type).starts_with("newt") ? "q.drag" : "q";
        EXPECT_GT(std::abs(along.at(name) - without.at(name)), 0.05 * std::abs(without.at(name))) << type;
    }
}

TEST_F(Axes, WrongBlocksAreRefused) {
    surface(body());
    const auto refused = [&](const std::string& axes) { return error("axes: " + axes + "\n" + goal("")); };
    EXPECT_TRUE(contains(refused("{downstream: +x, up: +x}"), "must be perpendicular; the angle between them is 0deg"));
    EXPECT_TRUE(contains(refused("{downstream: +x, up: [1, 0, 1]}"), "the angle between them is 45deg"));
    EXPECT_TRUE(contains(refused("{downstream: [0, 0, 0], up: +z}"), "axes.downstream = [0, 0, 0] has no direction"));
    EXPECT_TRUE(contains(refused("{downstream: +x}"), "axes.up is missing"));
    EXPECT_TRUE(contains(refused("{downstream: forward, up: +z}"), "axes.downstream = forward must be one of +x, -x"));
    // Rounded directions are taken, and made square.
    EXPECT_EQ(refused("{downstream: [0.9962, 0, 0.0872], up: [-0.0872, 0, 0.9962]}"), "");
    EXPECT_EQ(refused("{downstream: [0.9962, 0, 0.0873], up: [-0.0872, 0, 0.9962]}"), "");
}

TEST_F(Axes, OldKeysAreNotedAndMustAgree) {
    surface(body());
    const std::string block = "axes: {downstream: +x, up: +z}\n";
    EXPECT_EQ(error(block + goal(", forward: [2, 0, 0], up: [0.3, 0, 1]")), "");
    EXPECT_TRUE(contains(error(block + goal(", forward: [-1, 0, 0]")),
                         "quantities.aero.forward contradicts axes.downstream (line 3); remove it"));
    EXPECT_TRUE(contains(error(block + goal(", up: [0, 1, 0]")), "quantities.aero.up contradicts axes.up (line 3)"));
    const Case old =
        load_case(folder.write("case.yaml", "case: c\nsurface: {file: s.obj}\n" + goal(", forward: [-1, 0, 0]")));
    ASSERT_EQ(old.notes.size(), 1U);
    EXPECT_TRUE(contains(old.notes[0], "'quantities.aero.forward' is now called 'axes.downstream'")) << old.notes[0];
}

TEST_F(Axes, HalfModelsHaveNoSideForceRollOrYaw) {
    half();
    surface(half_above(whole_));
    const std::string plane = "symmetry: {plane: y, at: 0}\n";
    const auto at = values(plane + goal(", alpha: 5deg"));
    EXPECT_EQ(at.size(), 4U);
    EXPECT_TRUE(at.contains("aero.pitch") && at.contains("aero.lift_to_drag"));
    EXPECT_TRUE(contains(error(plane + goal("", "aero.side")),
                         "quantity 'aero.side' is left out: a half model at no sideslip has no side force"));
    EXPECT_EQ(values(plane + goal(", beta: 2deg")).size(), 7U) << "with sideslip, those of the half";
    EXPECT_EQ(values(plane + "axes: {downstream: +x, up: +y}\n" + goal("")).size(), 7U)
        << "not a left and a right half";
}

TEST_F(Axes, CoefficientsOfTheHalfOrTheWhole) {
    half();
    const std::string rest =
        "quantities:\n  aero: {type: newtonian, mach: 6, alpha: 5deg, reference_area: 3}\n"
        "  skin: {type: friction, reynolds: 1e6}\n  wave: {type: wave_drag, stations: 8}\n"
        "  front: {type: projected_area}\n"
        "objective: {minimize: aero.drag + skin + wave + front + volume}\n";
    const TriMesh side = half_above(whole_);
    surface(welded(whole_of(side, {Eigen::Vector3d::UnitY(), 0})));  // triangulated alike on both sides
    const auto all = values(rest);
    surface(side);
    const auto one = values("symmetry: {plane: y}\n" + rest),
               said = values("symmetry: {plane: y, coefficients: half}\n" + rest),
               two = values("symmetry: {plane: y, coefficients: whole}\n" + rest);
    EXPECT_EQ(one, said);
    for (const char* force : {"aero.drag", "aero.lift", "aero.pitch", "skin", "wave"}) {
        EXPECT_NEAR(two.at(force), 2 * one.at(force), 1e-12 * std::abs(two.at(force))) << force;
        EXPECT_NEAR(two.at(force), all.at(force), 1e-6 * std::abs(all.at(force))) << force;
    }
    EXPECT_NEAR(two.at("aero.lift_to_drag"), all.at("aero.lift_to_drag"), 1e-9);
    for (const char* area : {"front", "volume"}) EXPECT_EQ(two.at(area), one.at(area)) << area;
    const std::string whole = "symmetry: {plane: y, coefficients: whole}\n";
    EXPECT_TRUE(contains(error(whole + goal(", beta: 2deg")), "coefficients: whole needs a stream without sideslip"));
    EXPECT_TRUE(contains(error(whole + "axes: {downstream: +x, up: +y}\n" + goal("")), "lie in the symmetry plane"));
}

TEST_F(Axes, ARunOfBeforeKeepsItsValues) {
    half();
    surface(half_above(whole_));
    const auto outputs = [&](const std::string& symmetry) {
        const Case c = load_case(
            folder.write("case.yaml", "case: c\nsurface: {file: s.obj}\nsymmetry: " + symmetry + "\n" + goal("")),
            Purpose::run, folder.path());
        return c.quantities[0].value_names().size();
    };
    EXPECT_EQ(outputs("{plane: y, at: 0}"), 7U);
    EXPECT_EQ(outputs("{plane: y, at: 0, coefficients: half}"), 4U);
}

}  // namespace
}  // namespace strake
