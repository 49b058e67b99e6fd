#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "surfaces.hpp"
#include "tests/core/planform/lofted_wing.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace strake {
namespace {

TEST(Info, JsonHasTheKeysThatProgramsRelyOn) {
    const TempFolder folder;
    write_surface(folder / "box.off", box_surface({1, 2, 3}), SurfaceFormat::off);
    const ProgramRun run = run_strake({"info", (folder / "box.off").string(), "--json"});
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(run.err, "");
    const auto j = nlohmann::json::parse(run.out);
    EXPECT_EQ(j.at("vertices"), 8);
    EXPECT_EQ(j.at("triangles"), 12);
    EXPECT_EQ(j.at("components"), 1);
    for (const char* key : {"boundary_loops", "nonmanifold_edges", "nonmanifold_vertices", "misoriented_edges",
                            "duplicate_triangles", "degenerate_triangles", "self_intersections"})
        EXPECT_EQ(j.at(key), 0) << key;
    EXPECT_EQ(j.at("closed"), true);
    EXPECT_EQ(j.at("box"), nlohmann::json::parse("[[0, 0, 0], [1, 2, 3]]"));
    EXPECT_DOUBLE_EQ(j.at("diagonal"), std::sqrt(14.0));
    EXPECT_DOUBLE_EQ(j.at("area"), 22);
    EXPECT_DOUBLE_EQ(j.at("volume"), 6);
}

TEST(Info, ThePlanformIsListedBesideThatOfTheStart) {
    const TempFolder folder;
    Loft loft;
    const TriMesh start = lofted(loft);
    TriMesh now = start;
    now.vertices.col(0) *= 1.1;  // chords grow by 10 %, and the wing becomes thinner for it
    write_surface(folder / "start.ply", start, SurfaceFormat::ply_binary);
    write_surface(folder / "now.ply", now, SurfaceFormat::ply_binary);
    const std::vector<std::string> ask{"info",  "--planform", (folder / "now.ply").string(),  "--stations",
                                       "0,0.5", "--start",    (folder / "start.ply").string()};
    std::vector<std::string> json = ask, drawn = ask;
    json.push_back("--json");
    drawn.insert(drawn.end(), {"--sections", (folder / "both.svg").string()});
    const ProgramRun run = run_strake(json);
    ASSERT_EQ(run.status, 0) << run.err;
    const auto wing = nlohmann::json::parse(run.out).at("planform");
    for (const int k : {0, 1}) {
        const auto &after = wing.at("stations")[k], &before = wing.at("start").at("stations")[k];
        // Sections of a few straight pieces find the leading edge to 3e-4 of the chord.
        EXPECT_NEAR(after.at("chord").get<double>() / before.at("chord").get<double>(), 1.1, 5e-4);
        EXPECT_NEAR(after.at("thickness_to_chord").get<double>() * 1.1, before.at("thickness_to_chord"), 5e-4);
    }
    EXPECT_NEAR(wing.at("panels")[0].at("width").get<double>(), 1.5, 1e-6);
    EXPECT_NEAR(std::tan(wing.at("panels")[1].at("sweep").get<double>()),
                1.1 * std::tan(wing.at("start").at("panels")[1].at("sweep").get<double>()), 1e-3);
    const ProgramRun words = run_strake(drawn);
    ASSERT_EQ(words.status, 0) << words.err;
    for (const char* part : {"0.500 start", "0.500 now", "(start ", "0.000-0.500 start", "0.500-1.000 now"})
        EXPECT_NE(words.out.find(part), std::string::npos) << words.out;
    const std::string picture = bytes_of(folder / "both.svg");
    EXPECT_NE(picture.find("LE radius"), std::string::npos);
    EXPECT_NE(picture.find("#999"), std::string::npos) << "the start";
    write_surface(folder / "other.off", box_surface({1, 2, 3}), SurfaceFormat::off);
    const ProgramRun other =
        run_strake({"info", "--planform", (folder / "now.ply").string(), "--start", (folder / "other.off").string()});
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("both need the same triangles"), std::string::npos) << other.err;
}

TEST(Info, ABodyIsListedAlongItsLength) {
    const TempFolder folder;
    const TriMesh start = box_surface({4, 1, 2});
    TriMesh now = start;
    now.vertices.col(1) *= 1.1;
    write_surface(folder / "start.ply", start, SurfaceFormat::ply_binary);
    write_surface(folder / "now.ply", now, SurfaceFormat::ply_binary);
    const std::string file = (folder / "now.ply").string();
    const std::vector<std::string> ask{
        "info", "--planform", file, "--length", "-x", "--start", (folder / "start.ply").string()};
    std::vector<std::string> json = ask, drawn = ask;
    json.push_back("--json");
    drawn.insert(drawn.end(), {"--sections", (folder / "body.svg").string()});
    const ProgramRun run = run_strake(json);
    ASSERT_EQ(run.status, 0) << run.err;
    const auto body = nlohmann::json::parse(run.out).at("body");
    EXPECT_EQ(body.at("length_direction"), nlohmann::json::parse("[-1.0, 0.0, 0.0]"));
    EXPECT_DOUBLE_EQ(body.at("length"), 4);
    EXPECT_EQ(body.at("half"), false) << "it is closed";
    ASSERT_EQ(body.at("stations").size(), 5U);
    for (const auto& station : body.at("stations")) {
        EXPECT_NEAR(station.at("width"), 1.1, 1e-6);
        EXPECT_NEAR(station.at("height"), 2, 1e-6);
        EXPECT_NEAR(station.at("camber"), 0, 1e-6);
    }
    EXPECT_NEAR(body.at("start").at("stations")[2].at("width"), 1, 1e-6);
    const ProgramRun words = run_strake(drawn);
    ASSERT_EQ(words.status, 0) << words.err;
    for (const char* part : {"the whole surface", "length -x, up +z", "4 (start 4)", "0.500 start", "0.500 now"})
        EXPECT_NE(words.out.find(part), std::string::npos) << words.out;
    const std::string picture = bytes_of(folder / "body.svg");
    EXPECT_NE(picture.find("camber, %"), std::string::npos);
    EXPECT_NE(picture.find("#999"), std::string::npos) << "the start";
    const ProgramRun across = run_strake({"info", "--planform", file, "--length", "w"});
    EXPECT_EQ(across.status, 2);
    EXPECT_NE(across.err.find("--length w: must be x, y or z"), std::string::npos) << across.err;
    write_surface(folder / "wing.ply", lofted(Loft()), SurfaceFormat::ply_binary);
    const ProgramRun wing = run_strake({"info", "--planform", (folder / "wing.ply").string(), "--length", "x"});
    EXPECT_EQ(wing.status, 2);
    EXPECT_NE(wing.err.find("wing.ply: the wing that is found is the whole surface"), std::string::npos) << wing.err;
}

TEST(Info, HalfABodyHasTheWidthOfBothSides) {
    const TempFolder folder;
    TriMesh half = box_surface({4, 1, 2});
    std::vector<int> kept;
    for (int t = 0; t < half.num_triangles(); ++t)
        if ((half.vertices(half.triangles.row(t), 1).array() > half.vertices.col(1).minCoeff() + 1e-9).any())
            kept.push_back(t);
    half.triangles = Triangles(half.triangles(kept, Eigen::all));
    write_surface(folder / "half.ply", half, SurfaceFormat::ply_binary);
    const std::string file = (folder / "half.ply").string();
    const ProgramRun run = run_strake({"info", "--planform", file, "--length", "x", "--json"});
    ASSERT_EQ(run.status, 0) << run.err;
    const auto body = nlohmann::json::parse(run.out).at("body");
    EXPECT_EQ(body.at("half"), true);
    for (const auto& station : body.at("stations")) EXPECT_NEAR(station.at("width"), 2, 1e-6);
    const ProgramRun words = run_strake({"info", "--planform", file, "--length", "x"});
    EXPECT_NE(words.out.find("half a body"), std::string::npos) << words.out;
}

TEST(Info, WordsNameEveryDefectWithCountAndFirstIds) {
    const TempFolder folder;
    const auto file = folder.write(
        "bad.off",
        "OFF\n11 8 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 -1 0\n0.2 0.2 -1\n0.2 0.2 1\n0.9 0.9 0\n5 5 5\n5 5 5\n2 0 0\n"
        "3 0 1 2\n3 1 0 3\n3 0 1 4\n3 5 6 7\n3 2 1 0\n3 0 1 10\n3 5 6 8\n3 1 1 2\n");
    const ProgramRun run = run_strake({"info", file.string()});
    ASSERT_EQ(run.status, 0) << run.err;
    for (const char* defect :
         {"open boundary loop(s): ", "non-manifold edge(s)", "0-1", "non-manifold vertex(es)",
          "1 edge(s) whose two triangles disagree in orientation, vertices: 5-6",
          "1 duplicate triangle(s), same vertices as an earlier one, triangles: 4",
          "2 degenerate triangle(s), area below 1e-14 diagonal^2, triangles: 5, 7",
          "1 isolated vertex(es), in no triangle, vertices: 9",
          "1 duplicate vertex(es), at the place of an earlier one, vertices: 9", "pair(s) of triangles intersect"})
        EXPECT_NE(run.out.find(defect), std::string::npos) << defect << "\nnot in\n" << run.out;
}

TEST(Info, TrianglesThatLieOnOneAnotherAreNotSaidToPassThrough) {
    const TempFolder folder;
    const std::string cube =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\n"
        "f 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
    const auto told = [&](const std::string& more) {
        const ProgramRun run = run_strake({"info", folder.write("cube.obj", cube + more).string()});
        EXPECT_EQ(run.status, 0) << run.err;
        return run.out;
    };
    const std::string on = told("v 0.2 0.2 1\nv 0.8 0.2 1\nv 0.8 0.8 1\nf 9 10 11\n");
    EXPECT_NE(on.find("overlap in one plane (bodies that touch, or a face that is there twice), triangles: 2 and 12"),
              std::string::npos)
        << on;
    EXPECT_NE(on.find("delete one of the two faces"), std::string::npos) << on;
    EXPECT_EQ(on.find("pass through"), std::string::npos) << on;
    const std::string through = told("v 0.2 0.2 0.5\nv 0.8 0.2 0.5\nv 0.8 0.8 1.5\nf 9 10 11\n");
    EXPECT_NE(through.find("intersect (they pass through each other, or touch), triangles: "), std::string::npos)
        << through;
    EXPECT_EQ(through.find("in one plane"), std::string::npos) << through;
}

TEST(Info, NamesInwardOrientationAndTheWeld) {
    const TempFolder folder;
    TriMesh mesh = icosphere(1);
    for (int t = 0; t < mesh.num_triangles(); ++t) mesh.triangles.row(t).reverseInPlace();
    write_surface(folder / "in.stl", mesh, SurfaceFormat::stl_binary);
    const ProgramRun run = run_strake({"info", (folder / "in.stl").string()});
    EXPECT_NE(run.out.find("42 (240 corners welded where coordinates are equal, tolerance 0)"), std::string::npos);
    EXPECT_NE(run.out.find("oriented inward"), std::string::npos);
}

TEST(Info, NamesCracksAndTheWeldThatClosesThem) {
    const TempFolder folder;
    const auto file = folder.write("crack.off",
                                   "OFF\n6 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1e-8 0\n1 1 0\n0 1.00000001 0\n3 0 1 2\n"
                                   "3 3 4 5\n");
    const ProgramRun run = run_strake({"info", file.string()});
    EXPECT_NE(run.out.find("cracks: 4 boundary vertices lie within 1e-5 diagonal of another"), std::string::npos)
        << run.out;
}

TEST(Info, FileNamesAreBytes) {
    const TempFolder folder;
    for (const std::string name : {"-a b'\"$(echo).off", "line\nbreak.off", "\xff\xfe.off"}) {
        write_surface(folder / name, icosphere(0), SurfaceFormat::off);
        const ProgramRun run = run_strake({"info", (folder / name).string()});
        EXPECT_EQ(run.status, 0) << name << run.err;
        EXPECT_EQ(run.out.find(".off (OFF)\n"), run.out.find('\n') - 10) << run.out;
    }
}

TEST(Info, UsageErrorsHaveStatusTwo) {
    EXPECT_EQ(run_strake({"info"}).status, 2);
    EXPECT_EQ(run_strake({"info", "a.off", "--jsn"}).status, 2);
}

}  // namespace
}  // namespace strake
