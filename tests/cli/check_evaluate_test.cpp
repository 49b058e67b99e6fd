#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <nlohmann/json.hpp>

/// `strake check --evaluate`, and programs whose gradients cost a program of their own, from the case to the end.
namespace strake {
namespace {

namespace fs = std::filesystem;

class Programs : public testing::Test {
protected:
    TempFolder folder;

    Programs() { write_surface(folder / "s.obj", ellipsoid({1, 0.6, 0.4}, 2), SurfaceFormat::obj); }
    std::string path(const std::string& name) const { return (folder / name).string(); }
    std::string yaml(const std::string& quantity, const std::string& more = "") const {
        return folder
            .write("case.yaml",
                   "case: t\nsurface: {file: s.obj}\nregions: {a: {box: [[-2, -1, -1], [-0.6, 1, 1]]}}\n"
                   "fixed: [a]\nshell: {thickness: 5%}\nquantities: {bulk: " +
                       quantity +
                       "}\nobjective: {maximize: bulk}\nconstraints: {area: {max: 1, relative: true}}\n"
                       "parameters: {levels: auto, patches_per_level: [2, 4], variables: [normal], "
                       "max_displacement: 40%}\n" +
                       more)
            .string();
    }
    static std::string both() { return "{command: [" EXAMPLE_DIR "/volume.py, \"{request}\", \"{result}\"]}"; }
    static std::string separate() {
        return "{command: [" EXAMPLE_DIR "/volume.py, \"{request}\", \"{result}\"], gradient_command: [" EXAMPLE_DIR
               "/volume.py, \"{request}\", \"{result}\"]}";
    }
    int count(const std::string& run, const std::string& name) const {
        int found = 0;
        for (const auto& entry : fs::recursive_directory_iterator(folder / run))
            found += entry.path().filename() == name;
        return found;
    }
};

TEST_F(Programs, CheckEvaluateTellsWhatItUnderstood) {
    for (const std::string& quantity : {both(), separate()}) {
        const ProgramRun check = run_strake({"check", yaml(quantity), "--evaluate", "--json"});
        ASSERT_EQ(check.status, 0) << check.err;
        const auto told = nlohmann::json::parse(check.out);
        EXPECT_EQ(told["status"], "ok");
        const auto& bulk = told["quantities"][0];
        EXPECT_EQ(bulk["values"][0]["name"], "bulk");
        EXPECT_NEAR(bulk["values"][0]["value"], 4.0 / 3 * 3.14159 * 0.24, 0.05);
        EXPECT_GT(bulk["values"][0]["gradient"]["norm"], 0.01);
        EXPECT_GT(bulk["seconds"], 0);
        EXPECT_EQ(bulk.contains("gradient_seconds"), quantity == separate());
        EXPECT_EQ(told["constraints"][0]["quantity"], "area");
        EXPECT_NEAR(told["constraints"][0]["scaled"], 0, 1e-12);
        const auto has_file = [&](const std::string& name) {
            return std::any_of(told["files"].begin(), told["files"].end(),
                               [&](const auto& file) { return file["name"] == "000001/" + name; });
        };
        EXPECT_TRUE(has_file("request.json") && has_file("surface.obj") && has_file("gradient.csv")) << told;
        EXPECT_FALSE(fs::exists(std::string(told["folder"])));
        EXPECT_FALSE(fs::exists(folder / "runs")) << "no run folder is made";
    }
    const ProgramRun words = run_strake({"check", yaml(both()), "--evaluate", "--out", path("kept")});
    EXPECT_NE(words.out.find("value       bulk = "), std::string::npos) << words.out;
    EXPECT_NE(words.out.find("gradient of norm"), std::string::npos) << words.out;
    EXPECT_TRUE(fs::exists(folder / "kept/evaluations/000001/result.json"));
}

TEST_F(Programs, CheckEvaluateTellsAFailureAndKeepsItsFolder) {
    const ProgramRun check =
        run_strake({"check", yaml("{command: [sh, \"-c\", \"echo diverged >&2; exit 3\"]}"), "--evaluate", "--json"});
    EXPECT_EQ(check.status, 5);
    const auto told = nlohmann::json::parse(check.out);
    EXPECT_EQ(told["status"], "quantity_failed");
    EXPECT_EQ(told["quantities"][0]["failure"]["kind"], "exit");
    EXPECT_NE(check.err.find("diverged"), std::string::npos);
    const fs::path kept = std::string(told["folder"]);
    EXPECT_TRUE(fs::exists(kept / "evaluations/000001/stderr.log"));
    fs::remove_all(kept);
}

TEST_F(Programs, CheckWithoutEvaluationSeesThatTheProgramsCanRun) {
    fs::permissions(folder.write("plain.txt", "#!/bin/sh\n"), fs::perms(0644));
    const ProgramRun mode = run_strake({"check", yaml("{command: [./plain.txt]}")});
    EXPECT_EQ(mode.status, 2);
    EXPECT_NE(mode.err.find("may not be executed (mode 644); chmod +x it"), std::string::npos) << mode.err;
    const ProgramRun path = run_strake({"check", yaml("{command: [\"true\"], gradient_command: [no-such-program]}")});
    EXPECT_EQ(path.status, 2);
    EXPECT_NE(path.err.find("'no-such-program' is not on PATH (searched: /"), std::string::npos) << path.err;
    const ProgramRun library = run_strake({"check", yaml("{plugin: {library: plain.txt}}")});
    EXPECT_EQ(library.status, 2);
    EXPECT_NE(library.err.find("plain.txt cannot be loaded"), std::string::npos) << library.err;
}

TEST_F(Programs, GradientsAreAskedForWhereTheSearchStaysAndChangeNothing) {
    const std::string budget = "optimize: {budget: {evaluations: 12}}\n";
    ASSERT_EQ(run_strake({"run", yaml(both(), budget), "--out", path("one"), "-q"}).status, 0);
    ASSERT_EQ(run_strake({"run", yaml(separate(), budget), "--out", path("two"), "-q"}).status, 0);
    EXPECT_EQ(bytes_of(path("one/history.csv")), bytes_of(path("two/history.csv")));
    EXPECT_EQ(bytes_of(path("one/best.obj")), bytes_of(path("two/best.obj")));
    EXPECT_EQ(count("one", "gradient.csv"), count("one", "result.json"));
    EXPECT_LT(count("two", "gradient.json"), count("two", "result.json")) << "some points were rejected";
    EXPECT_GT(count("two", "gradient.json"), 2);
}

TEST_F(Programs, ARunWithGradientCommandsGoesOn) {
    const std::string budget = "optimize: {budget: {evaluations: 10}}\n";
    ASSERT_EQ(run_strake({"run", yaml(separate(), budget), "--out", path("whole"), "-q"}).status, 0);
    fs::permissions(folder.write("adjoint.sh",
                                 "#!/bin/sh\necho >> \"$3/calls\"\n"
                                 "[ $(wc -l < \"$3/calls\") = 3 ] && exit 4\n"
                                 "exec " EXAMPLE_DIR "/volume.py \"$1\" \"$2\"\n"),
                    fs::perms(0755));
    const std::string failing = "{command: [" EXAMPLE_DIR
                                "/volume.py, \"{request}\", \"{result}\"], gradient_command: [./adjoint.sh, "
                                "\"{request}\", \"{result}\", \"{case_dir}\"]}";
    ASSERT_EQ(run_strake({"run", yaml(failing, budget), "--out", path("part"), "-q"}).status, 5);
    const ProgramRun resumed = run_strake({"resume", path("part"), "-q"});
    ASSERT_EQ(resumed.status, 0) << resumed.err;
    EXPECT_EQ(bytes_of(path("whole/history.csv")), bytes_of(path("part/history.csv")));
    EXPECT_EQ(count("part", "result.json"), count("whole", "result.json")) << "no value is paid for twice";
    EXPECT_EQ(count("part", "gradient.json") + count("part", "gradient-2.json"), count("whole", "gradient.json"));
    EXPECT_EQ(count("part", "gradient-2.json"), 1) << "the one that failed";
}

TEST_F(Programs, AGradientThatFailsEndsTheRunAsAnEvaluation) {
    const std::string quantity = "{command: [" EXAMPLE_DIR
                                 "/volume.py, \"{request}\", \"{result}\"], gradient_command: "
                                 "[sh, \"-c\", \"echo no adjoint >&2; exit 4\"]}";
    const ProgramRun run = run_strake({"run", yaml(quantity), "--out", path("r"), "-q"});
    EXPECT_EQ(run.status, 5) << run.err;
    EXPECT_NE(run.err.find("gradient: exit status 4"), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("no adjoint"), std::string::npos) << run.err;
}

/// A wing through a body: what is buried counts in both.
TEST(CheckEvaluate, TellsThatTheUnionOfPartsIsNotKnown) {
    const TempFolder folder;
    TriMesh both = ellipsoid({1, 0.3, 0.3}, 2), wing = ellipsoid({0.2, 1, 0.05}, 2);
    for (const bool pierces : {true, false}) {
        TriMesh mesh = both;
        if (!pierces) wing.vertices.col(2).array() += 2;
        mesh.vertices.conservativeResize(both.num_vertices() + wing.num_vertices(), 3);
        mesh.vertices.bottomRows(wing.num_vertices()) = wing.vertices;
        mesh.triangles.conservativeResize(both.num_triangles() + wing.num_triangles(), 3);
        mesh.triangles.bottomRows(wing.num_triangles()) = wing.triangles.array() + both.num_vertices();
        write_surface(folder / "s.obj", mesh, SurfaceFormat::obj);
        const auto file = folder.write("case.yaml",
                                       "case: t\nsurface: {file: s.obj}\nregions: {a: {box: [[-2, -1, -1], [-0.6, 1, "
                                       "1]]}}\nfixed: [a]\nshell: none\nobjective: {maximize: volume}\n");
        const ProgramRun check = run_strake({"check", file.string()});
        ASSERT_EQ(check.status, 0) << check.err;
        EXPECT_EQ(check.out.find("volume of the union is not known") != std::string::npos, pierces) << check.out;
    }
}

}  // namespace
}  // namespace strake
