#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <nlohmann/json.hpp>

/// `strake gradient-check` as a program: tables, JSON, exit status, external programs.
namespace strake {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class GradientCheckProgram : public testing::Test {
protected:
    TempFolder folder;

    GradientCheckProgram() { write_surface(folder / "s.obj", ellipsoid({1, 0.6, 0.4}, 2), SurfaceFormat::obj); }
    std::string yaml(const std::string& goal) const {
        return folder
            .write("case.yaml",
                   "case: t\nsurface: {file: s.obj}\nregions: {a: {box: [[-2, -1, -1], [-0.6, 1, 1]]}}\n"
                   "fixed: [a]\nshell: {thickness: 5%}\n"
                   "parameters: {levels: auto, patches_per_level: [2, 4], variables: [load]}\n" +
                       goal)
            .string();
    }
};

TEST_F(GradientCheckProgram, PassesAndPrintsATable) {
    const ProgramRun run = run_strake(
        {"gradient-check", yaml("objective: {maximize: volume}\nconstraints: {area: {max: 1.1, relative: true}}\n")});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.out.find("level 2"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("remainder"), std::string::npos);
    EXPECT_EQ(run.out.find("FAIL"), std::string::npos) << run.out;
    EXPECT_NE(run.err.find("7 evaluations"), std::string::npos) << run.err;
}

TEST_F(GradientCheckProgram, AWrongExternalGradientFailsWithItsFactor) {
    // The height of the centroid, with gradients that are twice what they should be.
    const fs::path program = folder.write("height.py", R"(#!/usr/bin/env python3
import json, sys
z = [line.split()[3] for line in open(sys.argv[1]) if line.startswith("v ")]
n = len(z)
json.dump({"values": {"height": sum(map(float, z)) / n}, "gradients": {"height": "g.csv"}}, open(sys.argv[2], "w"))
with open("g.csv", "w") as out:
    for i in range(n):
        out.write(f"{i},0,0,{2 / n}\n")
)");
    ::chmod(program.c_str(), 0700);
    const std::string goal =
        "quantities: {q: {command: [./height.py, '{surface}', '{result}'], outputs: [height], format: obj}}\n"
        "objective: {minimize: q.height}\n";
    const ProgramRun run = run_strake(
        {"gradient-check", yaml(goal), "--json", "--seed", "3", "--level", "1", "--out", (folder / "w").string()});
    EXPECT_EQ(run.status, 1) << run.err;
    ASSERT_FALSE(run.out.empty()) << run.err;
    const Json told = Json::parse(run.out);
    EXPECT_EQ(told["status"], "failed");
    EXPECT_EQ(told["level"], 1);
    EXPECT_NEAR(double(told["tests"][0]["slope"]) / double(told["tests"][0]["differences_slope"]), 2, 1e-3);
    EXPECT_TRUE(fs::exists(folder / "w" / "evaluations" / "000007"));
}

TEST_F(GradientCheckProgram, RefusesWhatItCannotCheck) {
    const std::string good = "objective: {maximize: volume}\n";
    EXPECT_EQ(run_strake({"gradient-check", yaml(good), "--at", "end"}).status, 2);
    EXPECT_EQ(run_strake({"gradient-check", yaml(good), "--level", "9"}).status, 2);
    const ProgramRun nothing = run_strake({"gradient-check", yaml("")});
    EXPECT_EQ(nothing.status, 2);
    EXPECT_NE(nothing.err.find("no objective"), std::string::npos) << nothing.err;
}

}  // namespace
}  // namespace strake
