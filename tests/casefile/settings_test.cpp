#include "casefile/read/resolved_case.hpp"
#include "tests/casefile/build_fixture.hpp"

/// Keys of a case that the command line sets.
namespace strake {
namespace {

using Settings = std::vector<std::string>;

class SetKeys : public testing::Test {
protected:
    Folder folder;
    std::string yaml = R"(surface: {file: wing.obj}
regions: {nose: {box: [[0, 0, 0], [1, 1, 1]]}}
loads: [{region: nose, traction: [0, 0, 1]}]
parameters: {max_displacement: 3%, levels: [20deg, 10deg], freeze: [p1]}
quantities: {aero: {type: newtonian, mach: 6}}
objective: {minimize: aero.drag}
constraints: {aero.lift: {min: 1}}
)";
    SetKeys() { folder.write("wing.obj", tetrahedron_obj); }
    Case with(const Settings& settings) { return load_case(folder.write("wing.yaml", yaml), Purpose::any, settings); }
    std::string error(const Settings& settings) {
        try {
            with(settings);
        } catch (const CaseError& e) {
            return e.what();
        }
        return "";
    }
    static bool contains(const std::string& all, const std::string& part) {
        return all.find(part) != std::string::npos;
    }
};

TEST_F(SetKeys, ReplacesAddsAndAppends) {
    const Case c = with({"optimize.budget.evaluations=7", "parameters.levels[1]=5deg", "loads[0].traction=[0, 0, 2]",
                         "loads[1]={region: nose, spring: 3}", "case=other", "regions.nose.box[1][2]=0.5",
                         "output={paraview: none}"});
    EXPECT_EQ(c.optimize.max_evaluations, 7);
    EXPECT_EQ(c.parameters.levels_deg, (std::vector<double>{20, 5}));
    ASSERT_EQ(c.loads.size(), 2U);
    EXPECT_EQ(c.loads[0].traction->z(), 2);
    EXPECT_EQ(c.loads[1].spring, 3);
    EXPECT_EQ(c.name, "other");
    EXPECT_EQ(std::get<BoxShape>(c.regions[0].shape).max.z(), 0.5);
    EXPECT_EQ(c.output.paraview, ParaView::none);
}

/// One that is stated is one: the run goes back to none.
TEST_F(SetKeys, ANumberOfStartsIsKept) {
    EXPECT_FALSE(with({}).optimize.ignores_waves);
    EXPECT_FALSE(with({"optimize.starts=auto"}).optimize.ignores_waves);
    EXPECT_EQ(with({"optimize.starts=auto"}).optimize.starts, 1);
    for (const int starts : {1, 3}) {
        const OptimizeOptions options = with({"optimize.starts=" + std::to_string(starts)}).optimize;
        EXPECT_EQ(options.starts, starts);
        EXPECT_TRUE(options.ignores_waves);
    }
    EXPECT_TRUE(contains(error({"optimize.starts=some"}), "optimize.starts = some must be"))
        << error({"optimize.starts=some"});
}

TEST_F(SetKeys, NamesMayHoldDots) {
    const Case c = with({"constraints.aero.lift.min=2", "constraints.aero.pitch.max=3",
                         "constraints.\"aero.side\".max=4", "constraints.area={max: 5}"});
    ASSERT_EQ(c.constraints.size(), 4U);
    EXPECT_EQ(c.constraints[0].constraint.min, 2);
    EXPECT_EQ(c.constraints[1].constraint.quantity, "aero.pitch");
    EXPECT_EQ(c.constraints[1].constraint.max, 3);
    EXPECT_EQ(c.constraints[2].constraint.quantity, "aero.side");
    EXPECT_EQ(c.constraints[3].constraint.max, 5);
}

TEST_F(SetKeys, ThePresentNameReplacesAnOldOne) {
    EXPECT_EQ(with({"parameters.frozen=[p2]"}).parameters.frozen.at(0).name, "p2");
}

TEST_F(SetKeys, IsCheckedAsTheFileIsAndNamesTheSetting) {
    EXPECT_EQ(error({"optimize.budget.evaluations=abc"}),
              "--set optimize.budget.evaluations=abc: optimize.budget.evaluations = abc must be an integer");
    EXPECT_TRUE(contains(error({"optimize.bugdet.time=1h"}), "--set optimize.bugdet.time=1h: unknown key 'bugdet'"));
    EXPECT_TRUE(contains(error({"fixed=[tail]"}), "--set fixed=[tail]: region 'tail' is not declared"));
    EXPECT_TRUE(contains(error({"shell.thickness="}), "--set shell.thickness=: shell.thickness has no value"));
    EXPECT_TRUE(contains(error({"shell.thickness=[1"}), "--set shell.thickness=[1: the value is not valid YAML: "));
    EXPECT_TRUE(contains(error({"case=a\x01"}), "--set case=a\\x01: "));
}

TEST_F(SetKeys, KeysThatLeadNowhere) {
    for (const char* wrong : {"", "optimize", "=3", "a..b=1", "a.=1", "a[x]=1", "a[1=1", "\"a=1", "a[]=1"})
        EXPECT_TRUE(contains(error({wrong}), std::string("--set ") + wrong + ": ")) << wrong << ": " << error({wrong});
    EXPECT_TRUE(contains(error({"parameters.max_displacement.nose=1%"}), "is '3%', which has no keys below it"));
    EXPECT_TRUE(contains(error({"loads[2].spring=1"}), "a list of 1; [1] appends, [2] is beyond its end"));
    EXPECT_TRUE(contains(error({"loads.region=nose"}), "'loads' is a list of 1; its entries are [0]"));
    EXPECT_TRUE(contains(error({"parameters[0]=1"}), "'parameters' is a map, not a list"));
    std::string deep = "a";
    for (int i = 0; i < 100; ++i) deep += ".a";
    EXPECT_TRUE(contains(error({deep + "=1"}), "more than 64 parts"));
}

TEST_F(SetKeys, StandsInTheCaseOfTheRun) {
    const std::string resolved = resolved_case(with({"optimize.budget.evaluations=7"}), folder.path());
    EXPECT_TRUE(contains(resolved, "evaluations: 7")) << resolved;
    const Case again = load_case(folder.write("again.yaml", resolved));
    EXPECT_EQ(again.optimize.max_evaluations, 7);
}

TEST_F(SetKeys, TwoSettingsOfOneKey) {
    EXPECT_EQ(with({"optimize.budget.evaluations=7", "optimize.budget.evaluations=8"}).optimize.max_evaluations, 8);
}

}  // namespace
}  // namespace strake
