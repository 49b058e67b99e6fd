#include "cli/run_strake.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/patches/segmentation.hpp"
#include "shapes.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

using namespace strake;

namespace {

/// A folder with a box of 6 x 32 triangles.
struct PatchesProgram : testing::Test {
    TempFolder folder;
    TriMesh mesh = box_surface({3, 2, 1}, 4);
    std::string surface = (folder / "box.off").string();
    void SetUp() override { write_surface(surface, mesh, SurfaceFormat::off); }
    ProgramRun run(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), "patches");
        return run_strake(arguments);
    }
};

}  // namespace

TEST_F(PatchesProgram, JsonAndLabelsAgreeWithTheLibrary) {
    const std::string labels = (folder / "l.csv").string(), vtp = (folder / "p.vtp").string();
    const ProgramRun r =
        run({"--angle", "40", "--angle", "20", surface, "--json", "--labels", labels, "-o", vtp, "--min-size", "1%"});
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(r.err, "");
    const auto json = nlohmann::json::parse(r.out);
    const PatchHierarchy tree = segment(mesh, adjacency(mesh), {40, 20}, {.min_patch_percent = 1});
    ASSERT_EQ(json["levels"].size(), 2u);
    for (int l = 1; l <= 2; ++l) {
        const auto& level = json["levels"][l - 1];
        EXPECT_EQ(level["angle_deg"], tree.levels[l].angle_deg);
        ASSERT_EQ(level["patches"].size(), 6u);
        for (const Patch& p : tree.levels[l].patches) {
            const auto& patch = level["patches"][p.id];
            EXPECT_EQ(patch["id"], p.id);
            EXPECT_EQ(patch["name"], p.name);
            EXPECT_EQ(patch["parent"], p.parent);
            EXPECT_EQ(patch["class"], "smooth");
            EXPECT_EQ(patch["triangles"], 32);
            EXPECT_DOUBLE_EQ(patch["area"], p.area);
        }
    }
    std::istringstream csv(bytes_of(labels));
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(line, "level_1,level_2");
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        ASSERT_TRUE(std::getline(csv, line));
        EXPECT_EQ(line, text(tree.levels[1].label[t], ",", tree.levels[2].label[t]));
    }
    EXPECT_FALSE(std::getline(csv, line));
    for (const char* name : {"level_1", "level_2", "theta_deg", "class"})
        EXPECT_NE(bytes_of(vtp).find(name), std::string::npos) << name;
}

TEST_F(PatchesProgram, AutomaticLevelsAndTheTable) {
    const ProgramRun r = run({surface, "--angle", "auto", "--patches-per-level", "6,12"});
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_NE(r.out.find("level 1: 8 patches"), std::string::npos) << r.out;
    EXPECT_NE(r.out.find("level 2: "), std::string::npos) << r.out;
    EXPECT_NE(r.out.find(" p4.1 "), std::string::npos) << r.out;
}

TEST_F(PatchesProgram, SplitChoosesPatches) {
    for (const char* split : {"all", "largest:2", "containing:3", "containing:3,100"})
        EXPECT_EQ(run({surface, "--angle", "20", "--split", split}).status, 0) << split;
}

TEST_F(PatchesProgram, WrongOptionsExitWith2AndSayValueAndLimit) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
        {{"--angle", "0"}, "(0, 90]"},
        {{"--angle", "91"}, "91"},
        {{"--angle", "nan"}, "nan"},
        {{"--angle", "steep"}, "steep"},
        {{"--angle", "10", "--angle", "20"}, "must be less than"},
        {{"--angle", "auto", "--angle", "20"}, "auto"},
        {{"--angle", "20", "--min-size", "100%"}, "[0, 100)"},
        {{"--angle", "20", "--min-size", "few"}, "few"},
        {{"--angle", "20", "--split", "largest:0"}, "N >= 1"},
        {{"--angle", "20", "--split", "some"}, "largest:N"},
        {{"--angle", "20", "--split", "containing:192"}, "0 to 191"},
        {{"--angle", "20", "--patches-per-level", "4"}, "--angle auto"},
        {{"--angle", "auto", "--patches-per-level", "4,2"}, "not falling"},
        {{"--angle", "20", "-o", "p.stl"}, ".vtp"},
        {{}, "--angle"}};
    for (auto [arguments, words] : wrong) {
        arguments.push_back(surface);
        const ProgramRun r = run(arguments);
        EXPECT_EQ(r.status, 2) << words;
        EXPECT_EQ(r.out, "") << words;
        EXPECT_NE(r.err.find(words), std::string::npos) << r.err;
    }
}

TEST_F(PatchesProgram, WrongFilesExitWith3And4) {
    EXPECT_EQ(run({(folder / "none.stl").string(), "--angle", "20"}).status, 3);
    EXPECT_EQ(run({surface, "--angle", "20", "--labels", (folder / "no" / "such" / "l.csv").string()}).status, 4);
    EXPECT_EQ(run({surface, "--angle", "20", "-o", (folder / "no" / "such" / "p.vtp").string()}).status, 4);
}
