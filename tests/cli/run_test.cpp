#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// `run` and `deform` as programs: what is told and left behind when there is no design.
namespace strake {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const char* one_patch = "parameters: {levels: [80deg], variables: [normal]}\n";

class Run : public testing::Test {
protected:
    TempFolder folder;
    std::string path(const std::string& name) const { return (folder / name).string(); }
    std::string yaml(const std::string& text) const { return folder.write("case.yaml", text).string(); }
    void surface(const TriMesh& mesh) const { write_surface(folder / "s.obj", mesh, SurfaceFormat::obj); }
};

/// Two spheres, of which a case can hold one.
TriMesh two_spheres() {
    TriMesh both = icosphere(0);
    const int n = both.num_vertices(), m = both.num_triangles();
    both.vertices.conservativeResize(2 * n, 3);
    both.vertices.bottomRows(n) = both.vertices.topRows(n).rowwise() + Eigen::RowVector3d(5, 0, 0);
    both.triangles.conservativeResize(2 * m, 3);
    both.triangles.bottomRows(m) = both.triangles.topRows(m).array() + n;
    return both;
}

const std::string unheld =
    "surface: {file: s.obj}\nshell: {thickness: 1}\nregions: {a: {box: [[-1, -1, -1], [0.6, 1, 1]]}}\nfixed: [a]\n" +
    std::string(one_patch);

TEST_F(Run, AnUnheldPartIsToldInJsonAndLeavesNoFolder) {
    surface(two_spheres());
    const std::string head = "quantities: {t: {type: target_shape, file: s.obj}}\n";
    for (const std::string command : {"run", "fit"}) {
        const std::string goal = command == "fit" ? "fit: [t]\n" : "objective: {maximize: area}\n";
        const ProgramRun run =
            run_strake({command, yaml(unheld + head + goal), "--json", "--out", path("runs/deep/x")});
        EXPECT_EQ(run.status, 1) << run.err;
        const Json told = Json::parse(run.out);
        EXPECT_EQ(told["status"], "unheld");
        EXPECT_NE(std::string(told["reason"]).find("connected parts"), std::string::npos) << told;
        EXPECT_EQ(told["objective"], nullptr);
        EXPECT_FALSE(fs::exists(folder / "runs")) << "all that was made is gone";
    }
    const ProgramRun deform = run_strake({"deform", yaml(unheld), "--json", "-o", path("o.obj")});
    EXPECT_EQ(deform.status, 1);
    EXPECT_EQ(Json::parse(deform.out)["status"], "unheld");
}

TEST_F(Run, OnlyWhatTheRunMadeIsRemoved) {
    surface(two_spheres());
    fs::create_directories(folder / "mine");
    const std::string file = yaml(unheld + "objective: {maximize: area}\n");
    EXPECT_EQ(run_strake({"run", file, "-q", "--out", path("mine")}).status, 1);
    EXPECT_TRUE(fs::is_empty(folder / "mine")) << "an empty folder was there before";
    // So the corrected run may use the same folder.
    const std::string corrected =
        "surface: {file: s.obj}\nshell: {thickness: 1, spring: 1}\nregions: {a: {component: 0}}\nfixed: [a]\n";
    const ProgramRun again = run_strake(
        {"run", yaml(corrected + one_patch + "objective: {maximize: area}\noptimize: {budget: {evaluations: 1}}\n"),
         "-q", "--out", path("mine")});
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_TRUE(fs::exists(folder / "mine/history.csv"));
}

TEST_F(Run, AFailedRunTellsOnlyWhatThereIs) {
    surface(icosphere(0));
    const std::string file = yaml(
        "surface: {file: s.obj}\nshell: {thickness: 1, spring: 1}\nquantities: {q: {command: [\"false\"]}}\nobjective: "
        "{minimize: q}\n" +
        std::string(one_patch));
    const ProgramRun run = run_strake({"run", file, "-q", "--out", path("x")});
    EXPECT_EQ(run.status, 5) << run.err;
    EXPECT_EQ(run.out.find("nan"), std::string::npos) << run.out;
    EXPECT_EQ(run.out.find("series.pvd"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("no design"), std::string::npos) << run.out;
    EXPECT_TRUE(fs::exists(folder / "x/evaluations/000001")) << "what was evaluated is kept";
}

TEST_F(Run, TwoProgramsHaveAFolderEach) {
    surface(icosphere(0));
    const std::string program =
        "{command: [sh, \"-c\", 'echo \"{\\\"value\\\": 1}\" > result.json'], gradients: false}";
    const std::string file =
        yaml("surface: {file: s.obj}\nshell: {thickness: 1, spring: 1}\nquantities:\n  one: " + program +
             "\n  two: " + program +
             "\nobjective: {minimize: one}\noptimize: {method: cobyla, budget: {evaluations: 1}}\n" + one_patch);
    const ProgramRun run = run_strake({"run", file, "-q", "--out", path("x")});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_TRUE(fs::exists(folder / "x/evaluations/000001/one/result.json")) << run.out;
    EXPECT_TRUE(fs::exists(folder / "x/evaluations/000001/two/result.json"));
}

TEST_F(Run, DeformRefusesASurfaceThatPassesThroughItself) {
    surface(box_surface(Eigen::Vector3d(4, 4, 1), 4));
    // The lid pushed through the floor: an equilibrium, but no surface that can be handed on.
    const std::string file = yaml(
        "surface: {file: s.obj}\nshell: {thickness: 1}\nregions:\n  floor: {box: [[0, 0, 0], [4, 4, 0]]}\n"
        "  lid: {box: [[1, 1, 1], [3, 3, 1]]}\nfixed: [floor]\nstrains: [{region: lid, translate: [0, 0, -1.3]}]\n");
    const ProgramRun run = run_strake({"deform", file, "--json", "-o", path("o.obj")});
    EXPECT_EQ(run.status, 1) << run.err;
    const Json told = Json::parse(run.out);
    EXPECT_EQ(told["status"], "invalid") << told;
    EXPECT_NE(std::string(told["reason"]).find("triangle"), std::string::npos) << told;
    EXPECT_FALSE(fs::exists(folder / "o.obj"));
    const ProgramRun linear = run_strake({"deform", file, "--linear", "--json", "-o", path("o.obj")});
    EXPECT_EQ(linear.status, 0) << linear.err;
    EXPECT_NE(linear.err.find("warning: the linear response is not a valid surface"), std::string::npos) << linear.err;
    EXPECT_TRUE(fs::exists(folder / "o.obj"));
}

}  // namespace
}  // namespace strake
