#include "cli/run_strake.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/formats/npy.hpp"
#include "core/volume/volume_file.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// `strake apply` as a program: other meshes move as the surface of a run did.
namespace strake {
namespace {

class ApplyProgram : public testing::Test {
protected:
    static inline TempFolder* folder = nullptr;
    static inline std::string run;

    static void SetUpTestSuite() {
        folder = new TempFolder;
        write_surface(*folder / "s.obj", ellipsoid({1, 0.6, 0.4}, 2), SurfaceFormat::obj);
        const std::string yaml =
            folder
                ->write("case.yaml",
                        "case: t\nsurface: {file: s.obj}\nregions: {a: {box: [[-2, -1, -1], [-0.6, 1, 1]]}}\n"
                        "fixed: [a]\nshell: {thickness: 5%}\nobjective: {maximize: volume}\n"
                        "parameters: {levels: auto, patches_per_level: [2], variables: [normal]}\n"
                        "optimize: {budget: {evaluations: 4}}\n")
                .string();
        run = (*folder / "run").string();
        const ProgramRun made = run_strake({"run", yaml, "--out", run, "-q"});
        ASSERT_EQ(made.status, 0) << made.err;
    }
    static void TearDownTestSuite() {
        delete folder;
        folder = nullptr;
    }
    std::string path(const std::string& name) const { return (*folder / name).string(); }
};

TEST_F(ApplyProgram, TheRunsOwnSurfaceGoesWhereItsBestIs) {
    const ProgramRun applied = run_strake({"apply", run, path("s.obj"), "-o", path("own.obj")});
    ASSERT_EQ(applied.status, 0) << applied.err;
    EXPECT_EQ(bytes_of(path("own.obj")), bytes_of(run + "/best.obj"));
}

TEST_F(ApplyProgram, AFinerSurfaceAndListsOfPointsMoveAlike) {
    const TriMesh fine = refined(ellipsoid({1, 0.6, 0.4}, 2));
    write_surface(*folder / "fine.ply", fine, SurfaceFormat::ply_binary);
    folder->write("fine.npy", npy_bytes(fine.vertices));
    const ProgramRun surface = run_strake({"apply", run, path("fine.ply"), "-o", path("moved.ply"), "--json"});
    ASSERT_EQ(surface.status, 0) << surface.err;
    const auto told = nlohmann::json::parse(surface.out);
    EXPECT_EQ(told["points"], fine.num_vertices());
    EXPECT_EQ(told["on_surface"], fine.num_vertices());
    EXPECT_GT(told["max_displacement"], 0.001);
    const TriMesh moved = read_surface(path("moved.ply")).mesh;
    EXPECT_EQ(moved.triangles, fine.triangles);
    ASSERT_EQ(run_strake({"apply", run, path("fine.npy"), "-o", path("moved.npy")}).status, 0);
    EXPECT_EQ(parse_npy(bytes_of(path("moved.npy"))), moved.vertices);
    ASSERT_EQ(run_strake({"apply", run, path("fine.npy"), "-o", path("moved.csv")}).status, 0);
    ASSERT_EQ(run_strake({"apply", run, path("moved.csv"), "-o", path("again.csv")}).status, 0);
    const Points best = read_surface(run + "/best.obj").mesh.vertices;
    EXPECT_EQ(moved.vertices.topRows(best.rows()), best) << "vertices that the two share";
}

TEST_F(ApplyProgram, AnotherEvaluationComesFromTheSeries) {
    ASSERT_EQ(run_strake({"apply", run, path("s.obj"), "-o", path("first.npy"), "--evaluation", "1"}).status, 0);
    const Points start = read_surface(path("s.obj")).mesh.vertices;
    EXPECT_LT((parse_npy(bytes_of(path("first.npy"))) - start).cwiseAbs().maxCoeff(), 1e-9);
    const ProgramRun none = run_strake({"apply", run, path("s.obj"), "-o", path("n.npy"), "--evaluation", "99"});
    EXPECT_EQ(none.status, 2);
    EXPECT_NE(none.err.find("evaluation 99 was not kept"), std::string::npos) << none.err;
}

TEST_F(ApplyProgram, SensitivitiesGoTheOtherWay) {
    const TriMesh fine = refined(ellipsoid({1, 0.6, 0.4}, 2));
    write_surface(*folder / "fine.ply", fine, SurfaceFormat::ply_binary);
    Points g(fine.num_vertices(), 3);
    for (int v = 0; v < fine.num_vertices(); ++v) g.row(v) << 1, 0.5 * v, -v;
    folder->write("g.npy", npy_bytes(g));
    const ProgramRun back =
        run_strake({"apply", run, path("fine.ply"), "--sensitivities", path("g.npy"), "-o", path("back.npy")});
    ASSERT_EQ(back.status, 0) << back.err;
    const Points at_vertices = parse_npy(bytes_of(path("back.npy")));
    EXPECT_EQ(at_vertices.rows(), read_surface(run + "/best.obj").mesh.num_vertices());
    EXPECT_LT((at_vertices.colwise().sum() - g.colwise().sum()).norm(), 1e-9 * g.norm()) << "translations are kept";
    folder->write("g.npy", npy_bytes(g.topRows(5)));
    const ProgramRun few =
        run_strake({"apply", run, path("fine.ply"), "--sensitivities", path("g.npy"), "-o", path("b.csv")});
    EXPECT_EQ(few.status, 3);
    EXPECT_NE(few.err.find("5 rows, OTHER has"), std::string::npos) << few.err;
}

/// An O-grid between the ellipsoid and a sphere of radius 6, as an SU2 mesh of wedges.
std::string volume_about(const TriMesh& surface, int layers) {
    std::string out = text("NDIME= 3\nNELEM= ", surface.num_triangles() * layers, "\n");
    const int n = surface.num_vertices();
    for (int l = 0; l < layers; ++l)
        for (int t = 0; t < surface.num_triangles(); ++t) {
            out += "13";
            for (const int layer : {l, l + 1})
                for (int k = 0; k < 3; ++k) out += text(" ", layer * n + surface.triangles(t, k));
            out += "\n";
        }
    out += text("NPOIN= ", n * (layers + 1), "\n");
    for (int l = 0; l <= layers; ++l)
        for (int v = 0; v < n; ++v) {
            const double s = std::pow(static_cast<double>(l) / layers, 2);
            const Eigen::RowVector3d x = surface.vertices.row(v), p = (1 - s) * x + s * 6 * x.normalized();
            char line[120];
            std::snprintf(line, sizeof line, "%.17g %.17g %.17g %d\n", p[0], p[1], p[2], l * n + v);
            out += line;
        }
    out += text("NMARK= 1\nMARKER_TAG= far\nMARKER_ELEMS= ", surface.num_triangles(), "\n");
    for (int t = 0; t < surface.num_triangles(); ++t) {
        out += "5";
        for (int k = 0; k < 3; ++k) out += text(" ", layers * n + surface.triangles(t, k));
        out += "\n";
    }
    return out;
}

TEST_F(ApplyProgram, TheMeshOfAVolumeMovesAndItsCellsAreChecked) {
    const TriMesh start = read_surface(path("s.obj")).mesh;
    const Points best = read_surface(run + "/best.obj").mesh.vertices;
    folder->write("v.su2", volume_about(start, 6));
    const ProgramRun applied = run_strake({"apply", run, path("v.su2"), "-o", path("w.su2"), "--json"});
    ASSERT_EQ(applied.status, 0) << applied.err;
    const auto told = nlohmann::json::parse(applied.out);
    EXPECT_EQ(told["cells"]["checked"], 6 * start.num_triangles());
    EXPECT_EQ(told["cells"]["newly_bad"], 0);
    EXPECT_GT(told["cells"]["smallest_ratio"], 0.3);
    const Points moved = read_volume(path("w.su2")).mesh.points;
    EXPECT_EQ(moved.topRows(best.rows()), best) << "the wall is the surface";
    const Points was = read_volume(path("v.su2")).mesh.points;
    EXPECT_EQ(moved.bottomRows(best.rows()), was.bottomRows(best.rows())) << "the far boundary stays";
}

TEST_F(ApplyProgram, InvertedCellsAreRefusedUnlessForced) {
    const TriMesh start = read_surface(path("s.obj")).mesh;
    TriMesh far = start;
    far.vertices.col(0).array() += 0.5;
    write_surface(*folder / "far.obj", far, SurfaceFormat::obj);
    folder->write("v.su2", volume_about(start, 6));
    const std::vector<std::string> words{"apply", path("s.obj"), path("v.su2"), "--moved", path("far.obj"),
                                         "-o",    path("x.su2"), "--reach",     "0.1",     "--json"};
    const ProgramRun refused = run_strake(words);
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.err.find("nothing was written"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("the worst is cell"), std::string::npos) << refused.err;
    EXPECT_EQ(nlohmann::json::parse(refused.out)["status"], "inverted");
    EXPECT_FALSE(std::filesystem::exists(path("x.su2")));
    std::vector<std::string> forced = words;
    forced.push_back("--force");
    EXPECT_EQ(run_strake(forced).status, 0);
    EXPECT_TRUE(std::filesystem::exists(path("x.su2")));
}

TEST_F(ApplyProgram, HeldBoundariesStayHoweverNear) {
    const TriMesh start = read_surface(path("s.obj")).mesh;
    TriMesh wide = start;
    wide.vertices *= 1.05;
    write_surface(*folder / "wide.obj", wide, SurfaceFormat::obj);
    folder->write("v.su2", volume_about(start, 6));
    const std::vector<std::string> base{"apply",   path("s.obj"), path("v.su2"), "--moved", path("wide.obj"),
                                        "--reach", "9",           "--json",      "-o"};
    auto words = base;
    words.push_back(path("free.su2"));
    ASSERT_EQ(run_strake(words).status, 0);
    words = base;
    words.insert(words.end(), {path("held.su2"), "--hold", "far"});
    const ProgramRun held = run_strake(words);
    ASSERT_EQ(held.status, 0) << held.err;
    const Points was = read_volume(path("v.su2")).mesh.points, free = read_volume(path("free.su2")).mesh.points,
                 stays = read_volume(path("held.su2")).mesh.points;
    const int n = start.num_vertices();
    EXPECT_GT((free.bottomRows(n) - was.bottomRows(n)).norm(), 0.01);
    EXPECT_EQ(stays.bottomRows(n), was.bottomRows(n));
    EXPECT_EQ(stays.topRows(n), wide.vertices);
}

TEST_F(ApplyProgram, HoldSaysWhatIsWrongAndWhatToDo) {
    const TriMesh start = read_surface(path("s.obj")).mesh;
    folder->write("v.su2", volume_about(start, 6));
    folder->write("probes.csv", "x,y,z\n0,0,1\n");
    folder->write("one.vtu",
                  "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" "
                  "NumberOfCells=\"1\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">"
                  "0 0 1 1 0 1 0 1 1 0 0 2</DataArray></Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\" "
                  "format=\"ascii\">0 1 2 3</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4"
                  "</DataArray><DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells></Piece>"
                  "</UnstructuredGrid></VTKFile>");
    const auto refused = [&](const std::string& other, const std::string& out, const std::vector<std::string>& more,
                             const std::vector<std::string>& says) {
        std::vector<std::string> arguments{"apply", run, path(other), "-o", path(out)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const ProgramRun applied = run_strake(arguments);
        EXPECT_EQ(applied.status, 2) << applied.err;
        for (const std::string& words : says)
            EXPECT_NE(applied.err.find(words), std::string::npos) << words << " in: " << applied.err;
        EXPECT_FALSE(std::filesystem::exists(path(out)));
    };
    refused("v.su2", "n.su2", {"--hold", "fra"},
            {"--hold fra", "v.su2 has no boundary", "did you mean 'far'?", "Boundaries: far"});
    refused("v.su2", "n.su2", {"--hold", "far", "--hold", "inlet"}, {"--hold inlet", "Boundaries: far"});
    refused("v.su2", "n.su2", {"--hold", "far", "--undo"}, {"--undo cannot restore", "omit both"});
    refused("v.su2", "n.obj", {"--hold", "far"}, {"is not an .su2", "write an .su2"});
    refused("s.obj", "n.obj", {"--hold", "far"}, {"s.obj is a surface", "omit --hold"});
    refused("probes.csv", "n.csv", {"--hold", "far"}, {"probes.csv is a list of points", "omit --hold"});
    refused("probes.csv", "n.csv", {"--hold", "far", "--sensitivities", path("g.csv")}, {"is a list of points"});
    refused("one.vtu", "n.vtu", {"--hold", "far"}, {"one.vtu names no boundaries", "--reach"});
}

TEST_F(ApplyProgram, WarnsWhereNothingMoves) {
    folder->write("far.csv", "x,y,z\n900,0,0\n0,1000,0\n");
    folder->write("near.csv", "x,y,z\n0,0,0.5\n");
    folder->write("held.csv", "x,y,z\n-1,0,0\n");
    const auto warned = [&](const std::string& other, const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"apply", run, path(other), "-o", path("n.csv")};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const ProgramRun applied = run_strake(arguments);
        EXPECT_EQ(applied.status, 0) << applied.err;
        return applied.err;
    };
    const std::string far = warned("far.csv", {});
    EXPECT_NE(far.find("warning: nothing of"), std::string::npos) << far;
    EXPECT_NE(far.find("899 away"), std::string::npos) << far;
    EXPECT_NE(far.find("unit and position"), std::string::npos) << far;
    const std::string start = warned("near.csv", {"--evaluation", "1"});
    EXPECT_NE(start.find("the start shape itself; choose another with --evaluation"), std::string::npos) << start;
    const std::string held = warned("held.csv", {});
    EXPECT_NE(held.find("the design moves only parts of the surface that are too far away"), std::string::npos) << held;
    EXPECT_EQ(warned("near.csv", {}).find("nothing of"), std::string::npos);
}

/// The surface of another run, or in another unit: it would be moved without meaning.
TEST_F(ApplyProgram, ASurfaceOfAnotherBodyIsRefused) {
    TriMesh other = ellipsoid({1, 0.6, 0.4}, 2);
    other.vertices *= 1.2;
    write_surface(*folder / "other.obj", other, SurfaceFormat::obj);
    const std::vector<std::string> arguments{"apply", run, path("other.obj"), "-o", path("n.obj")};
    const ProgramRun refused = run_strake(arguments);
    EXPECT_EQ(refused.status, 2) << refused.err;
    EXPECT_NE(refused.err.find("none of its 162 vertices lies on the start surface"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(path("n.obj")));
    std::vector<std::string> forced = arguments;
    forced.push_back("--force");
    EXPECT_EQ(run_strake(forced).status, 0);
}

/// A vertex that happens to touch makes no surface of the run; a part of which some vertices touch may be attached.
TEST_F(ApplyProgram, AFewVerticesThatTouchAreTold) {
    const TriMesh body = ellipsoid({1, 0.6, 0.4}, 2);
    TriMesh other = body;
    for (int v = 1; v < other.num_vertices(); ++v) other.vertices.row(v) *= 1.2;
    write_surface(*folder / "touches.obj", other, SurfaceFormat::obj);
    const ProgramRun refused = run_strake({"apply", run, path("touches.obj"), "-o", path("n.obj")});
    EXPECT_EQ(refused.status, 2) << refused.err;
    EXPECT_NE(refused.err.find("only 1 of its 162 vertices lies on the start surface"), std::string::npos)
        << refused.err;
    for (int v = 1; v < 30; ++v) other.vertices.row(v) = body.vertices.row(v);
    write_surface(*folder / "part.obj", other, SurfaceFormat::obj);
    const ProgramRun told = run_strake({"apply", run, path("part.obj"), "-o", path("n.obj")});
    EXPECT_EQ(told.status, 0) << told.err;
    EXPECT_NE(told.err.find("warning: only 30 of the 162 vertices"), std::string::npos) << told.err;
    const ProgramRun same = run_strake({"apply", run, path("s.obj"), "-o", path("same.obj")});
    EXPECT_EQ(same.status, 0) << same.err;
    EXPECT_EQ(same.err.find("warning: only"), std::string::npos) << same.err;
}

TEST_F(ApplyProgram, ColumnsOfAListStayAsTheyAre) {
    folder->write("rows.csv", "name,y,x, z ,\"p\",PointID\r\nprobe 1,0,0,0.5,1.250e-3,7\r\n,0.1,0.2,0.6,, 3\r\n");
    const ProgramRun kept = run_strake({"apply", run, path("rows.csv"), "-o", path("rows_moved.csv")});
    ASSERT_EQ(kept.status, 0) << kept.err;
    EXPECT_EQ(kept.err, "");
    const std::string text = bytes_of(path("rows_moved.csv"));
    EXPECT_EQ(text.substr(0, text.find('\n')), "name,y,x, z ,\"p\",PointID\r");
    EXPECT_NE(text.find("\nprobe 1,"), std::string::npos) << text;
    EXPECT_NE(text.find(",1.250e-3,7\r\n,"), std::string::npos) << text;
    EXPECT_TRUE(text.ends_with(",, 3\r\n")) << text;
    ASSERT_EQ(run_strake({"apply", run, path("rows_moved.csv"), "--undo", "-o", path("rows_back.csv")}).status, 0);
    folder->write("plain.npy", npy_bytes((Points(2, 3) << 0, 0, 0.5, 0.2, 0.1, 0.6).finished()));
    ASSERT_EQ(run_strake({"apply", run, path("plain.npy"), "-o", path("plain_moved.npy")}).status, 0);
    const ProgramRun lost = run_strake({"apply", run, path("rows.csv"), "-o", path("rows_moved.npy")});
    EXPECT_NE(lost.err.find("the columns name, \"p\" are lost"), std::string::npos) << lost.err;
    const Points moved = parse_npy(bytes_of(path("rows_moved.npy")));
    EXPECT_EQ(moved, parse_npy(bytes_of(path("plain_moved.npy")))) << "the columns are taken by their names";
    ASSERT_EQ(run_strake({"apply", run, path("rows_moved.csv"), "--undo", "-o", path("back.npy")}).status, 0);
    const Points back = parse_npy(bytes_of(path("back.npy")));
    EXPECT_LT((back - (Points(2, 3) << 0, 0, 0.5, 0.2, 0.1, 0.6).finished()).norm(), 1e-12);
}

TEST_F(ApplyProgram, UndoGoesBackToTheStart) {
    const TriMesh start = read_surface(path("s.obj")).mesh;
    TriMesh bent = start;
    for (int v = 0; v < bent.num_vertices(); ++v)
        bent.vertices(v, 2) += 0.3 * bent.vertices(v, 0) * bent.vertices(v, 0);
    write_surface(*folder / "bent.obj", bent, SurfaceFormat::obj);
    folder->write("v.su2", volume_about(start, 6));
    const auto apply = [&](const std::string& from, const std::string& to, bool back) {
        std::vector<std::string> words{"apply", path("s.obj"), path(from), "--moved", path("bent.obj"), "-o", path(to)};
        if (back) words.push_back("--undo");
        return run_strake(words);
    };
    ASSERT_EQ(apply("v.su2", "there.su2", false).status, 0);
    const ProgramRun back = apply("there.su2", "back.su2", true);
    ASSERT_EQ(back.status, 0) << back.err;
    const Points was = read_volume(path("v.su2")).mesh.points, there = read_volume(path("there.su2")).mesh.points,
                 is = read_volume(path("back.su2")).mesh.points;
    EXPECT_GT((there - was).cwiseAbs().maxCoeff(), 0.2);
    EXPECT_LT((is - was).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_EQ(is.topRows(start.num_vertices()), start.vertices) << "vertices get their very bits";
}

/// Both ways, with the place where it is largest.
TEST_F(ApplyProgram, CompareTellsDistancesVolumesAndPatches) {
    const ProgramRun own = run_strake({"compare", run, "--json", "--vtp", path("d.vtp")});
    ASSERT_EQ(own.status, 0) << own.err;
    const auto told = nlohmann::json::parse(own.out);
    const Points start = read_surface(path("s.obj")).mesh.vertices,
                 best = read_surface(run + "/best.obj").mesh.vertices;
    EXPECT_NEAR(told["displacement"]["max"], (best - start).rowwise().norm().maxCoeff(), 1e-14);
    EXPECT_LE(told["distance"]["max"], told["displacement"]["max"]);
    EXPECT_GT(told["distance"]["max"], 0);
    EXPECT_GT(told["volume"]["b"], told["volume"]["a"]);
    EXPECT_GE(told["patches"].size(), 2U);
    EXPECT_TRUE(std::filesystem::exists(path("d.vtp")));
    TriMesh bigger = read_surface(path("s.obj")).mesh;
    bigger.vertices *= 1.1;
    write_surface(*folder / "bigger.stl", bigger, SurfaceFormat::stl_ascii);
    const auto other = nlohmann::json::parse(run_strake({"compare", path("s.obj"), path("bigger.stl"), "--json"}).out);
    EXPECT_NEAR(other["distance"]["b_to_a"]["max"], 0.1, 1e-3);
    EXPECT_NEAR(std::abs(other["distance"]["b_to_a"]["at"][0].get<double>()), 1.1, 1e-6);
    EXPECT_NEAR(other["volume"]["b"].get<double>() / other["volume"]["a"].get<double>(), 1.331, 1e-9);
    EXPECT_EQ(run_strake({"compare", path("s.obj")}).status, 2);
    EXPECT_EQ(run_strake({"compare", run}).status, 0);
}

TEST_F(ApplyProgram, MixIsAnEquilibriumBetweenDesigns) {
    const std::string other = path("other");
    std::string yaml = bytes_of(*folder / "case.yaml");
    yaml.replace(yaml.find("evaluations: 4"), 14, "evaluations: 2");
    ASSERT_EQ(run_strake({"run", folder->write("less.yaml", yaml).string(), "--out", other, "-q"}).status, 0);
    const Points a = read_surface(run + "/best.obj").mesh.vertices, b = read_surface(other + "/best.obj").mesh.vertices;
    const auto mix = [&](const std::string& w, const std::vector<std::string>& more = {}) {
        std::vector<std::string> words{"mix", run, other, "--weight", w, "-o", path("mix.obj"), "--json"};
        words.insert(words.end(), more.begin(), more.end());
        const ProgramRun made = run_strake(words);
        EXPECT_EQ(made.status, 0) << made.err;
        return std::pair(nlohmann::json::parse(made.out), read_surface(path("mix.obj")).mesh.vertices);
    };
    EXPECT_EQ(mix("0").second, a);
    EXPECT_EQ(mix("1").second, b);
    const auto [told, third] = mix("0.3");
    const Points straight = 0.7 * a + 0.3 * b;
    EXPECT_EQ(told["kind"], "equilibrium");
    EXPECT_LT((third - straight).norm(), 0.2 * (a - b).norm());
    EXPECT_EQ(mix("1e-12").first["kind"], "equilibrium");
    EXPECT_LT((mix("1e-12").second - a).cwiseAbs().maxCoeff(), 1e-6) << "demands at 0 are those of the design";
    EXPECT_LT((mix("0.3", {"--linear"}).second - straight).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_EQ(run_strake({"mix", run, path("s.obj"), "--weight", "nan", "-o", path("m.obj")}).status, 2);
    TriMesh few = read_surface(path("s.obj")).mesh;
    few.triangles.conservativeResize(few.num_triangles() - 1, 3);
    write_surface(*folder / "few.obj", few, SurfaceFormat::obj);
    const ProgramRun unlike = run_strake({"mix", run, path("few.obj"), "-o", path("m.obj")});
    EXPECT_EQ(unlike.status, 2);
    EXPECT_NE(unlike.err.find("have different triangles"), std::string::npos) << unlike.err;
}

TEST_F(ApplyProgram, SaysWhatCannotBe) {
    const auto refused = [&](const std::vector<std::string>& arguments, int status, const std::string& words) {
        const ProgramRun applied = run_strake(arguments);
        EXPECT_EQ(applied.status, status) << applied.err;
        EXPECT_NE(applied.err.find(words), std::string::npos) << applied.err;
    };
    folder->write("bad.csv", "x,y,z\n1,2,3\n1,nan,3\n");
    folder->write("p.csv", "1,2,3\n");
    refused({"apply", path("nowhere"), path("p.csv"), "-o", path("o.csv")}, 2, "no such folder");
    refused({"apply", run, path("missing.csv"), "-o", path("o.csv")}, 3, "missing.csv");
    refused({"apply", run, path("bad.csv"), "-o", path("o.csv")}, 3, "bad.csv:3");
    refused({"apply", run, path("p.csv"), "-o", path("o.obj")}, 2, "not a surface");
    refused({"apply", run, path("p.csv"), "-o", path("p.csv")}, 2, "overwrite");
    refused({"apply", run, path("p.csv"), "-o", path("o.csv"), "--reach", "0"}, 2, "reach = 0");
    refused({"apply", run, path("p.csv"), "-o", path("o.csv"), "--design", path("s.obj")}, 3, "s.obj");
    EXPECT_FALSE(std::filesystem::exists(path("o.csv")));
}

}  // namespace
}  // namespace strake
