#include "cli/run_strake.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/repair/defective.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

namespace strake {
namespace {

using namespace defective;

/// A sphere with a hole and a turned triangle.
std::filesystem::path torn_sphere(const TempFolder& folder) {
    TriMesh mesh = without(icosphere(2), [](int t) { return t == 100; });
    write_surface(folder / "torn.off", turned(mesh, [](int t) { return t == 7; }), SurfaceFormat::off);
    return folder / "torn.off";
}

TEST(RepairProgram, JsonCountsAndListsEveryRepair) {
    const TempFolder folder;
    const ProgramRun run = run_strake({"repair", torn_sphere(folder).string(), "--out", (folder / "whole.ply").string(),
                                       "--orient", "--holes", "20%", "--json", "--list", (folder / "l.csv").string()});
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(run.err, "");
    const auto j = nlohmann::json::parse(run.out);
    EXPECT_EQ(j.at("repairs").at("orient"), 1);
    EXPECT_EQ(j.at("repairs").at("hole"), 1);
    EXPECT_EQ(j.at("repairs").at("weld"), 0);
    EXPECT_EQ(j.at("before").at("misoriented_edges"), 3);
    EXPECT_EQ(j.at("after").at("misoriented_edges"), 0);
    EXPECT_EQ(j.at("before").at("boundary_loops"), 1);
    EXPECT_EQ(j.at("after").at("closed"), true);
    EXPECT_TRUE(j.at("remaining").empty());
    ASSERT_EQ(j.at("items").size(), 2u);
    EXPECT_EQ(j.at("items")[0].at("kind"), "orient");
    EXPECT_EQ(j.at("items")[0].at("triangle"), 7);
    EXPECT_EQ(j.at("items")[1].at("vertex").is_number(), true);
    const std::string list = bytes_of(folder / "l.csv");
    EXPECT_EQ(std::count(list.begin(), list.end(), '\n'), 3);
    EXPECT_EQ(read_surface(folder / "whole.ply").mesh.num_triangles(), 320);
}

TEST(RepairProgram, WordsNameWhatWasDoneAndWhatIsStillThere) {
    const TempFolder folder;
    const ProgramRun run =
        run_strake({"repair", torn_sphere(folder).string(), "-o", (folder / "o.stl").string(), "--orient"});
    ASSERT_EQ(run.status, 0) << run.err;
    for (const char* words :
         {"orient: 1\n", "1 of 319 connected triangles turned, the first is 7", "misoriented_edges              3 -> 0",
          "remaining: 1 open loop(s): not requested; --holes", ": open\n"})
        EXPECT_NE(run.out.find(words), std::string::npos) << words << "\nnot in\n" << run.out;
    const ProgramRun idle =
        run_strake({"repair", torn_sphere(folder).string(), "-o", (folder / "o.stl").string(), "--degenerate"});
    EXPECT_NE(idle.out.find("none of the requested repairs was needed"), std::string::npos) << idle.out;
    EXPECT_EQ(
        run_strake({"repair", torn_sphere(folder).string(), "-o", (folder / "o.stl").string(), "--all", "-q"}).out, "");
}

TEST(RepairProgram, ExitStatuses) {
    const TempFolder folder;
    const std::string in = torn_sphere(folder).string(), out = (folder / "o.off").string();
    for (const std::vector<std::string>& wrong :
         std::vector<std::vector<std::string>>{{"repair", in},
                                               {"repair", in, "-o", out},
                                               {"repair", in, "-o", in, "--orient"},
                                               {"repair", in, "-o", (folder / "o.xyz").string(), "--orient"},
                                               {"repair", in, "-o", out, "--weld", "-1"},
                                               {"repair", in, "-o", out, "--weld", "nan"},
                                               {"repair", in, "-o", out, "--weld", "1mm"},
                                               {"repair", in, "-o", out, "--cracks", "0"},
                                               {"repair", in, "-o", out, "--holes", ""},
                                               {"repair", in, "-o", out, "--holes", "0"},
                                               {"repair", in, "-o", out, "--holes", "5%", "--fill", "round"},
                                               {"repair", in, "-o", out, "--components", "largest=0"},
                                               {"repair", in, "-o", out, "--components", "largest=1.5"},
                                               {"repair", in, "-o", out, "--components", "min_area=100%"},
                                               {"repair", in, "-o", out, "--components", "min_area=1"},
                                               {"repair", in, "-o", out, "--components", "smallest=1"},
                                               {"repair", in, "-o", out, "--components", "min_triangles=1000"}}) {
        const ProgramRun run = run_strake(wrong);
        EXPECT_EQ(run.status, 2) << wrong.back() << run.out;
        EXPECT_FALSE(std::filesystem::exists(out)) << wrong.back();
    }
    EXPECT_EQ(run_strake({"repair", (folder / "none.off").string(), "-o", out, "--all"}).status, 3);
    folder.write("bad.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 nan\n3 0 1 2\n");
    EXPECT_EQ(run_strake({"repair", (folder / "bad.off").string(), "-o", out, "--all"}).status, 3);
    EXPECT_EQ(run_strake({"repair", in, "-o", (folder / "no/such/o.off").string(), "--all"}).status, 4);
}

/// All vertices at one place: a diagonal of zero.
TEST(RepairProgram, APointIsNoSurface) {
    const TempFolder folder;
    const auto in = folder.write("point.off", "OFF\n3 1 0\n1 1 1\n1 1 1\n1 1 1\n3 0 1 2\n");
    const ProgramRun run = run_strake({"repair", in.string(), "-o", (folder / "o.off").string(), "--all"});
    EXPECT_EQ(run.status, 2) << run.out << run.err;
    EXPECT_EQ(run_strake({"info", in.string()}).status, 0);
    for (const std::string command : {"patches", "remesh"}) {
        std::vector<std::string> words{command, in.string(), "-o", (folder / "o.vtp").string()};
        if (command == "patches") words.insert(words.end(), {"--angle", "auto"});
        const ProgramRun refused = run_strake(words);
        EXPECT_EQ(refused.status, 3) << command;
        EXPECT_EQ(refused.err, "strake: " + in.string() + ": 1 triangles of total area 0\n");
    }
}

/// Whatever reads a surface says which vertex is too far away.
TEST(RepairProgram, CoordinatesBeyondReckoningAreRefusedByAll) {
    const TempFolder folder;
    const auto in = folder.write("far.off", "OFF\n3 1 0\n0 0 0\n0 1e200 0\n1 1 1\n3 0 1 2\n");
    for (const std::string command : {"patches", "remesh", "repair", "info"}) {
        std::vector<std::string> words{command, in.string()};
        if (command != "info") words.insert(words.end(), {"-o", (folder / "o.vtp").string()});
        if (command == "repair") words.push_back("--all");
        if (command == "patches") words.insert(words.end(), {"--angle", "auto"});
        const ProgramRun refused = run_strake(words);
        EXPECT_EQ(refused.status, 3) << command;
        EXPECT_NE(refused.err.find("far.off: vertex 1: y = 1e+200 is beyond"), std::string::npos) << refused.err;
    }
}

TEST(RepairProgram, HugeAndTinySurfacesAreMendedAlike) {
    const TempFolder folder;
    for (const double scale : {1e-9, 1e12}) {
        TriMesh mesh = read_surface(torn_sphere(folder)).mesh;
        mesh.vertices *= scale;
        write_surface(folder / "s.off", mesh, SurfaceFormat::off);
        const ProgramRun run = run_strake({"repair", (folder / "s.off").string(), "-o", (folder / "o.off").string(),
                                           "--all", "--holes", "20%", "--json"});
        ASSERT_EQ(run.status, 0) << run.err;
        EXPECT_EQ(nlohmann::json::parse(run.out).at("after").at("closed"), true) << scale;
    }
}

TEST(RepairProgram, GroupsAreCarriedOver) {
    const TempFolder folder;
    TriMesh mesh = box_surface({1, 1, 1}, 2);
    mesh.group_names = {"low", "high"};
    for (int t = 0; t < mesh.num_triangles(); ++t) mesh.group.push_back(centroid(mesh, t).z() > 0.5);
    mesh.triangles = mesh.triangles.bottomRows(mesh.num_triangles() - 1).eval();
    mesh.group.erase(mesh.group.begin());
    write_surface(folder / "g.obj", mesh, SurfaceFormat::obj);
    ASSERT_EQ(
        run_strake({"repair", (folder / "g.obj").string(), "-o", (folder / "o.obj").string(), "--holes", "all"}).status,
        0);
    const TriMesh back = read_surface(folder / "o.obj").mesh;
    ASSERT_EQ(back.num_triangles(), 48);
    for (int t = 0; t < 48; ++t)
        EXPECT_EQ(back.group_names.at(back.group.at(t)), centroid(back, t).z() > 0.5 ? "high" : "low");
}

/// An STL of text stays one, with its names and all digits; where a format has no names, that is said.
TEST(RepairProgram, NamesOfPartsAreKeptOrTheirLossIsTold) {
    const TempFolder folder;
    TriMesh mesh = box_surface({1.0 / 3, 1, 1}, 2);
    mesh.group_names = {"low", "high side"};
    for (int t = 0; t < mesh.num_triangles(); ++t) mesh.group.push_back(centroid(mesh, t).z() > 0.5);
    write_surface(folder / "g.stl", mesh, SurfaceFormat::stl_ascii);
    const auto repaired = [&](const std::string& name) {
        return run_strake({"repair", (folder / "g.stl").string(), "-o", (folder / name).string(), "--orient"});
    };
    for (const std::string name : {"o.stl", "o.vtp", "o.msh"}) {
        const ProgramRun run = repaired(name);
        ASSERT_EQ(run.status, 0) << run.err;
        EXPECT_EQ(run.err, "");
        const TriMesh back = read_surface(folder / name).mesh;
        EXPECT_EQ(back.vertices.col(0).maxCoeff(), 1.0 / 3) << name;
        ASSERT_EQ(back.num_triangles(), 48);
        for (int t = 0; t < 48; ++t)
            EXPECT_EQ(back.group_names.at(back.group.at(t)), centroid(back, t).z() > 0.5 ? "high side" : "low") << name;
    }
    for (const std::string name : {"o.ply", "o.off", "o.vtk"}) {
        const ProgramRun run = repaired(name);
        EXPECT_EQ(run.status, 0);
        EXPECT_EQ(run.err, "strake: note: " + (folder / name).string() +
                               ": this format has no part names; the names of 2 part(s) are lost\n");
    }
}

/// The reason is that of this loop, not one of others.
TEST(RepairProgram, ALoneTriangleIsNotClosedByItsBack) {
    const TempFolder folder;
    folder.write("one.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    const ProgramRun run = run_strake(
        {"repair", (folder / "one.off").string(), "-o", (folder / "o.off").string(), "--holes", "all", "--orient"});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.out.find("1 open loop(s): their fill would pass through the surface or lie back to back"),
              std::string::npos)
        << run.out;
    EXPECT_EQ(run.out.find("orientation faults"), std::string::npos) << run.out;
}

TEST(RepairProgram, InfoMarksDefectsForParaView) {
    const TempFolder folder;
    const std::string in = torn_sphere(folder).string();
    ASSERT_EQ(run_strake({"info", in, "--vtp", (folder / "d.vtp").string()}).status, 0);
    const std::string vtp = bytes_of(folder / "d.vtp");
    for (const char* field : {"boundary_loop", "misoriented", "self_intersection", "degenerate", "component"})
        EXPECT_NE(vtp.find(text("Name=\"", field, "\"")), std::string::npos) << field;
    EXPECT_EQ(run_strake({"info", in, "--vtp", in}).status, 2);
    EXPECT_EQ(run_strake({"info", in, "--vtp", (folder / "no/such/d.vtp").string()}).status, 4);
}

TEST(RepairProgram, TheRunFolderHoldsTheSurfaceThatWasRun) {
    const TempFolder folder;
    torn_sphere(folder);
    folder.write("case.yaml",
                 "case: mended\nsurface: {file: torn.off}\nrepair: {all: true, holes: 20%}\n"
                 "regions: {low: {plane: {normal: [0, 0, 1], at: -0.5}, side: below}}\nfixed: [low]\n"
                 "parameters: {patches_per_level: [4]}\nobjective: {maximize: volume}\nconstraints:\n"
                 "  area: {max: 1.01, relative: true}\noptimize: {budget: {evaluations: 3}}\n");
    const ProgramRun run = run_strake({"run", (folder / "case.yaml").string(), "--out", (folder / "run").string()});
    ASSERT_EQ(run.status, 0) << run.err << run.out;
    EXPECT_NE(run.err.find("repair: 1 orient, 1 hole"), std::string::npos) << run.err;
    EXPECT_EQ(read_surface(folder / "run/start.off").mesh.num_triangles(), 320);
    EXPECT_NE(bytes_of(folder / "run/start-repairs.csv").find("\nhole,"), std::string::npos);
    EXPECT_EQ(read_surface(folder / "run/best.off").mesh.num_triangles(), 320);
    const ProgramRun again = run_strake({"resume", (folder / "run").string(), "--evaluations", "+2"});
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(run_strake({"apply", (folder / "run").string(), (folder / "run/start.off").string(), "-o",
                          (folder / "moved.off").string()})
                  .status,
              0);
    EXPECT_EQ(bytes_of(folder / "moved.off").empty(), false);
}

}  // namespace
}  // namespace strake
