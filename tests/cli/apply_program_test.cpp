#include "cli/run_strake.hpp"
#include "core/mesh/io.hpp"
#include "core/mesh/npy.hpp"
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
                        "parameters: {levels: auto, patches_per_level: [2], variables: [load_normal]}\n"
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

TEST_F(ApplyProgram, SaysWhatCannotBe) {
    const auto refused = [&](const std::vector<std::string>& arguments, int status, const std::string& words) {
        const ProgramRun applied = run_strake(arguments);
        EXPECT_EQ(applied.status, status) << applied.err;
        EXPECT_NE(applied.err.find(words), std::string::npos) << applied.err;
    };
    folder->write("bad.csv", "x,y,z\n1,2,3\n1,nan,3\n");
    folder->write("p.csv", "1,2,3\n");
    refused({"apply", path("nowhere"), path("p.csv"), "-o", path("o.csv")}, 2, "holds no run");
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
