#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "core/volume/volume_file.hpp"
#include "tests/kinds_of_shape.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

/// Runs whose designs keep a kind of shape, with fields and patches, from the case to what is done with them.
namespace strake {
namespace {

constexpr int around = 24, rings = 4;  ///< of the two-dimensional mesh: cells around the section and away from it

class KindsProgram : public testing::Test {
protected:
    static inline TempFolder* folder = nullptr;
    static inline std::string run;

    static std::string case_text() {
        return "case: t\nsurface: {file: s.obj}\nregions: {front: {box: [[-9, -9, -9], [-0.3, 9, 9]]}}\n"
               "fixed: [front]\ninvariance: {extrude: y}\nshell: {thickness: 5%}\nobjective: {maximize: volume}\n"
               "constraints: {area: {max: 1.02, relative: true}}\n"
               "parameters: {fields: 9, levels: auto, patches_per_level: [2], variables: [normal]}\n"
               "optimize: {budget: {evaluations: 9}}\n";
    }
    static void SetUpTestSuite() {
        folder = new TempFolder;
        write_surface(*folder / "s.obj", extruded_section(around, 1), SurfaceFormat::obj);
        const std::string yaml = folder->write("case.yaml", case_text()).string();
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

int point(int i, int k, int layer) { return layer * around * (rings + 1) + k * around + i % around; }

std::string foam_file(const std::string& kind, const std::string& object, const std::string& content) {
    return "FoamFile\n{\n    version 2.0;\n    format ascii;\n    class " + kind + ";\n    object " + object +
           ";\n}\n" + content;
}

struct Face {
    std::array<int, 4> at;
    int owner, neighbour;
};

int cell(int i, int k) { return k * around + i % around; }

std::vector<Face> inner_faces() {
    std::vector<Face> inner;
    for (int k = 0; k < rings; ++k)
        for (int i = 0; i < around; ++i) {
            const std::array<int, 4> out{point(i, k + 1, 0), point(i, k + 1, 1), point(i + 1, k + 1, 1),
                                         point(i + 1, k + 1, 0)};
            if (k + 1 < rings) inner.push_back({out, cell(i, k), cell(i, k + 1)});
            std::array<int, 4> next{point(i + 1, k, 0), point(i + 1, k + 1, 0), point(i + 1, k + 1, 1),
                                    point(i + 1, k, 1)};
            if (i + 1 == around) std::reverse(next.begin(), next.end());
            inner.push_back({next, std::min(cell(i, k), cell(i + 1, k)), std::max(cell(i, k), cell(i + 1, k))});
        }
    return inner;
}

/// The wall, then the far boundary, then both sides.
std::vector<Face> outer_faces() {
    std::vector<Face> outer;
    for (int i = 0; i < around; ++i)
        outer.push_back({{point(i, 0, 0), point(i + 1, 0, 0), point(i + 1, 0, 1), point(i, 0, 1)}, cell(i, 0), -1});
    for (int i = 0; i < around; ++i)
        outer.push_back({{point(i, rings, 0), point(i, rings, 1), point(i + 1, rings, 1), point(i + 1, rings, 0)},
                         cell(i, rings - 1),
                         -1});
    for (const int layer : {0, 1})
        for (int k = 0; k < rings; ++k)
            for (int i = 0; i < around; ++i) {
                std::array<int, 4> side{point(i, k, layer), point(i, k + 1, layer), point(i + 1, k + 1, layer),
                                        point(i + 1, k, layer)};
                if (layer == 1) std::reverse(side.begin(), side.end());
                outer.push_back({side, cell(i, k), -1});
            }
    return outer;
}

/// One layer of hexahedra between y = 0 and 1, sections that grow away from the body; empty sides.
void write_two_dimensional(const std::filesystem::path& mesh, const TriMesh& body) {
    std::ostringstream points, faces, owner, neighbour;
    points << 2 * around * (rings + 1) << "\n(\n";
    points.precision(17);
    const double scale[] = {1, 1.3, 1.8, 2.8, 5};
    for (const int layer : {0, 1})
        for (const double grown : scale)
            for (int i = 0; i < around; ++i)
                points << '(' << grown * body.vertices(i, 0) << ' ' << layer << ' '
                       << grown * body.vertices(i, 2) * (grown > 1 ? 1.5 : 1) << ")\n";
    points << ")\n";
    const std::vector<Face> inner = inner_faces(), outer = outer_faces();
    const std::size_t count = inner.size() + outer.size();
    faces << count << "\n(\n", owner << count << "\n(\n", neighbour << inner.size() << "\n(\n";
    for (const auto* list : {&inner, &outer})
        for (const Face& face : *list) {
            faces << "4(" << face.at[0] << ' ' << face.at[1] << ' ' << face.at[2] << ' ' << face.at[3] << ")\n";
            owner << face.owner << '\n';
            if (face.neighbour >= 0) neighbour << face.neighbour << '\n';
        }
    faces << ")\n", owner << ")\n", neighbour << ")\n";
    std::filesystem::create_directories(mesh);
    const auto write = [&](const char* name, const std::string& text) {
        std::ofstream(mesh / name, std::ios::binary) << text;
    };
    write("points", foam_file("vectorField", "points", points.str()));
    write("faces", foam_file("faceList", "faces", faces.str()));
    write("owner", foam_file("labelList", "owner", owner.str()));
    write("neighbour", foam_file("labelList", "neighbour", neighbour.str()));
    std::ostringstream boundary;
    const std::size_t wall = inner.size(), far = wall + around, sides = far + around;
    boundary << "3\n(\nwall { type wall; nFaces " << around << "; startFace " << wall
             << "; }\nfar { type patch; nFaces " << around << "; startFace " << far
             << "; }\nsides { type empty; nFaces " << 2 * around * rings << "; startFace " << sides << "; }\n)\n";
    write("boundary", foam_file("polyBoundaryMesh", "boundary", boundary.str()));
}

TEST_F(KindsProgram, ARunKeepsTheSection) {
    const TriMesh start = read_surface(path("s.obj")).mesh, best = read_surface(run + "/best.obj").mesh;
    const ShapeKind kind{ShapeKind::Type::extruded, Eigen::Vector3d::UnitY(), {0, 0, 0}, 1};
    EXPECT_LT(off_kind(best, kind), 1e-12 * box_diagonal(best));
    EXPECT_GT((best.vertices - start.vertices).cwiseAbs().maxCoeff(), 1e-3);
    EXPECT_EQ(best.vertices.col(1), start.vertices.col(1)) << "nothing moves along the axis";
}

TEST_F(KindsProgram, ATwoDimensionalMeshStaysOne) {
    const std::filesystem::path mesh = path("flow/constant/polyMesh"), moved = path("moved/constant/polyMesh");
    write_two_dimensional(mesh, read_surface(path("s.obj")).mesh);
    const ProgramRun applied = run_strake({"apply", run, mesh.string(), "-o", moved.string(), "--json"});
    ASSERT_EQ(applied.status, 0) << applied.err;
    const auto told = nlohmann::json::parse(applied.out);
    EXPECT_EQ(told["cells"]["checked"], around * rings);
    EXPECT_EQ(told["cells"]["newly_bad"], 0);
    const Points before = read_volume(mesh).mesh.points, after = read_volume(moved).mesh.points;
    ASSERT_EQ(after.rows(), 2 * around * (rings + 1));
    const Eigen::Index layer = after.rows() / 2;
    EXPECT_EQ(after.col(1), before.col(1)) << "the empty sides stay flat, by every bit";
    EXPECT_LT((after.topRows(layer) - after.bottomRows(layer)).leftCols(1).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LT((after.topRows(layer) - after.bottomRows(layer)).rightCols(1).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_GT((after - before).cwiseAbs().maxCoeff(), 1e-3);
}

TEST_F(KindsProgram, DesignsAreSteppedMixedSweptAndContinued) {
    const std::string designs = run + "/levels/best.design";
    const ProgramRun mixed = run_strake({"mix", run, run, "--weight", "0.5", "-o", path("mixed.obj")});
    EXPECT_EQ(mixed.status, 0) << mixed.err;
    if (mixed.status == 0) {
        const TriMesh best = read_surface(run + "/best.obj").mesh;
        EXPECT_LT((read_surface(path("mixed.obj")).mesh.vertices - best.vertices).cwiseAbs().maxCoeff(), 1e-9);
    }
    std::string text = case_text();
    text.replace(text.find("evaluations: 9"), 14, "evaluations: 2");
    text.replace(text.find("optimize: {"), 11, "optimize: {start_from: run, ");
    const std::string yaml = folder->write("again.yaml", text).string();
    const ProgramRun again = run_strake({"run", yaml, "--out", path("again"), "-q"});
    EXPECT_EQ(again.status, 0) << again.err;
    const ProgramRun names = run_strake({"check", path("case.yaml"), "--json"});
    ASSERT_EQ(names.status, 0) << names.err;
    const auto told = nlohmann::json::parse(names.out);
    const std::string field = told["fields"][1];
    const ProgramRun sweep = run_strake(
        {"sweep", path("case.yaml"), "--variable", field, "--from", "-0.3", "--to", "0.3", "--steps", "3", "--json"});
    EXPECT_EQ(sweep.status, 0) << sweep.err;
    EXPECT_NE(sweep.out.find("volume"), std::string::npos);
    EXPECT_FALSE(told["can_make"]["motions"].empty());
    EXPECT_TRUE(told["border"].contains("turn_by_fields_deg"));
    EXPECT_TRUE(told["border"]["kept_deg"].is_null());
    EXPECT_EQ(run_strake({"check", path("case.yaml")}).status, 0);
}

TEST_F(KindsProgram, AnotherBodyIsRefusedWithPlaceAndDeviation) {
    write_surface(*folder / "ball.obj", body_of_revolution(16, 8), SurfaceFormat::obj);
    std::string text = case_text();
    text.replace(text.find("s.obj"), 5, "ball.obj");
    const ProgramRun refused = run_strake({"check", folder->write("ball.yaml", text).string()});
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find("the surface is not extruded along y: triangle "), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("it is off by "), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace strake
