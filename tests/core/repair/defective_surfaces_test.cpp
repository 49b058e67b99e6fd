#include "../../cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "defective.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

/// Each defect that users meet: `info` counts it right, `repair` mends it so that `patches` and `deform` take the
/// result, or says why not.
namespace strake {
namespace {

using namespace defective;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

struct Defective {
    std::string name;
    TriMesh mesh;
    Json defects;  ///< info's numbers; those of the list below that are not named are 0
    Words options;
    Json after;            ///< the same after repair with these options
    std::string why = {};  ///< what repair says when something stays
    bool usable = true;    ///< for patches and deform, after repair
};

constexpr const char* counted[] = {"boundary_loops",     "nonmanifold_edges",   "nonmanifold_vertices",
                                   "misoriented_edges",  "duplicate_triangles", "degenerate_triangles",
                                   "inverted_triangles", "isolated_vertices",   "duplicate_vertices",
                                   "inward_components",  "self_intersections",  "adjacent_intersections"};

const Json closed_sphere{{"components", 1}, {"closed", true}, {"vertices", 162}, {"triangles", 320}};

TriMesh sphere() { return icosphere(2); }

std::vector<Defective> with_open_edges() {
    const TriMesh ball = sphere();
    const Json torn{{"components", 2}, {"boundary_loops", 2}, {"self_intersections", "any"}};
    std::vector<Defective> list;
    list.push_back({"unwelded",
                    unwelded(ball),
                    {{"components", 320}, {"boundary_loops", 320}, {"duplicate_vertices", 960 - 162}},
                    {"--weld", "0"},
                    closed_sphere});
    list.push_back({"crack", cracked(ball, 1e-6), torn, {"--cracks", "1e-5"}, closed_sphere});
    list.push_back({"weldedCrack", cracked(ball, 1e-6), torn, {"--weld", "1e-4%"}, closed_sphere});
    list.push_back({"flatHole",
                    without(box_surface({1, 1, 1}, 4), [](int t) { return t >= 10 && t < 12; }),
                    {{"components", 1}, {"boundary_loops", 1}},
                    {"--holes", "0.5"},
                    {{"components", 1}, {"closed", true}, {"triangles", 192}}});
    const TriMesh cap_off = without(ball, [&](int t) { return centroid(ball, t).z() > 0.7; });
    list.push_back({"curvedHole",
                    cap_off,
                    {{"components", 1}, {"boundary_loops", 1}, {"isolated_vertices", 15}},
                    {"--holes", "all", "--fill", "smooth", "--isolated"},
                    {{"components", 1}, {"closed", true}}});
    list.push_back({"severalHoles",
                    without(ball, [](int t) { return t % 100 == 7; }),
                    {{"components", 1}, {"boundary_loops", 4}},
                    {"--holes", "30%"},
                    closed_sphere});
    list.push_back({"tJunction",
                    with_t_junction(ball),
                    {{"components", 1}, {"boundary_loops", 1}},
                    {"--cracks", "1e-9"},
                    {{"components", 1}, {"closed", true}, {"vertices", 163}, {"triangles", 322}}});
    list.push_back({"holeBeyondTheLimit",
                    cap_off,
                    {{"components", 1}, {"boundary_loops", 1}, {"isolated_vertices", 15}},
                    {"--holes", "0.1", "--isolated"},
                    {{"components", 1}, {"boundary_loops", 1}},
                    "larger than the limit"});
    return list;
}

std::vector<Defective> with_wrong_orientation() {
    const TriMesh ball = sphere();
    std::vector<Defective> list;
    list.push_back({"flippedTriangle",
                    turned(ball, [](int t) { return t == 5; }),
                    {{"components", 1}, {"misoriented_edges", 3}},
                    {"--orient"},
                    closed_sphere});
    list.push_back({"flippedHalf",
                    turned(box_surface(), [](int t) { return t < 6; }),
                    {{"components", 1}, {"misoriented_edges", 8}},
                    {"--orient"},
                    {{"components", 1}, {"closed", true}, {"volume", 1.0}}});
    list.push_back({"flippedComponent",
                    joined(ball, turned(moved(ball, {3, 0, 0}), [](int) { return true; })),
                    {{"components", 2}, {"closed", true}, {"inward_components", 1}},
                    {"--orient"},
                    {{"components", 2}, {"closed", true}}});
    list.push_back({"insideOut",
                    turned(ball, [](int) { return true; }),
                    {{"components", 1}, {"closed", true}, {"inward_components", 1}},
                    {"--orient"},
                    closed_sphere});
    list.push_back({"void",
                    joined(ball, turned(moved(ball, {0, 0, 0}, 0.5), [](int t) { return t != 3; })),
                    {{"components", 2}, {"misoriented_edges", 3}},
                    {"--orient"},
                    {{"components", 2}, {"closed", true}, {"inward_components", 1}}});
    list.push_back({"moebius",
                    twisted_band(24, 1),
                    {{"components", 1}, {"boundary_loops", 1}, {"orientable", false}, {"misoriented_edges", 1}},
                    {"--orient"},
                    {{"components", 1}, {"boundary_loops", 1}, {"orientable", false}, {"misoriented_edges", 1}},
                    "not orientable"});
    const Json klein{{"components", 1},
                     {"orientable", false},
                     {"misoriented_edges", "some"},
                     {"self_intersections", "some"},
                     {"adjacent_intersections", "any"}};
    list.push_back({"klein", klein_bottle(24, 12), klein, {"--orient"}, klein, "not orientable", false});
    return list;
}

std::vector<Defective> with_bad_triangles() {
    const TriMesh ball = sphere();
    const auto a = ball.triangles(7, 0), b = ball.triangles(7, 1), c = ball.triangles(7, 2);
    std::vector<Defective> list;
    TriMesh twice = ball;
    add_triangle(twice, a, b, c);
    list.push_back(
        {"duplicate",
         twice,
         {{"components", 1}, {"duplicate_triangles", 1}, {"nonmanifold_edges", 3}, {"nonmanifold_vertices", 3}},
         {"--duplicates"},
         closed_sphere});
    TriMesh opposite = ball;
    opposite.triangles.row(7) << a, c, b;  // the copy that comes first is the wrong one
    add_triangle(opposite, a, b, c);
    list.push_back(
        {"duplicateOpposite",
         opposite,
         {{"components", 1}, {"duplicate_triangles", 1}, {"nonmanifold_edges", 3}, {"nonmanifold_vertices", 3}},
         {"--duplicates"},
         closed_sphere});
    TriMesh flap = ball;
    const int tip = add_vertex(flap, {0, 0, 2});
    add_triangle(flap, a, b, tip);
    add_triangle(flap, b, a, tip);
    list.push_back(
        {"flap",
         flap,
         {{"components", 1}, {"duplicate_triangles", 1}, {"nonmanifold_edges", 1}, {"nonmanifold_vertices", 2}},
         {"--duplicates"},
         closed_sphere});
    list.push_back({"needles",
                    with_needles(ball),
                    {{"components", 1}, {"closed", true}, {"degenerate_triangles", 2}},
                    {"--degenerate"},
                    closed_sphere});
    list.push_back({"cap",
                    with_cap(ball),
                    {{"components", 1}, {"closed", true}, {"degenerate_triangles", 1}},
                    {"--degenerate"},
                    {{"components", 1}, {"closed", true}, {"vertices", 163}, {"triangles", 322}}});
    return list;
}

std::vector<Defective> with_bad_connections() {
    const TriMesh ball = sphere();
    const auto a = ball.triangles(7, 0), b = ball.triangles(7, 1), c = ball.triangles(7, 2);
    std::vector<Defective> list;
    TriMesh bow_tie = joined(ball, moved(ball, -ball.vertices.row(0)));
    bow_tie = joined(ball, moved(ball, 2 * ball.vertices.row(0)));
    int touching = -1;
    for (int v = 162; v < 324; ++v)
        if ((bow_tie.vertices.row(v) - ball.vertices.row(0)).norm() < 1e-12) touching = v;
    bow_tie.triangles = bow_tie.triangles.unaryExpr([&](int v) { return v == touching ? 0 : v; }).eval();
    list.push_back({"bowTie",
                    bow_tie,
                    {{"components", 2},
                     {"closed", true},
                     {"nonmanifold_vertices", 1},
                     {"isolated_vertices", 1},
                     {"duplicate_vertices", 1}},
                    {"--split", "--isolated"},
                    {{"components", 2}, {"closed", true}, {"duplicate_vertices", 1}, {"vertices", 324}}});
    TriMesh fin = ball;
    add_triangle(fin, a, b, add_vertex(fin, 2 * ball.vertices.row(c)));
    list.push_back({"threeAtAnEdge",
                    fin,
                    {{"components", 1}, {"nonmanifold_edges", 1}, {"nonmanifold_vertices", 2}, {"boundary_loops", 1}},
                    {"--split", "--components", "largest=1"},
                    closed_sphere});
    TriMesh boxes = joined(box_surface(), moved(box_surface(), {1, 1, 0}));
    for (int i = 0; i < boxes.triangles.size(); ++i)
        for (int v = 0; v < 8; ++v)
            if (boxes.triangles.data()[i] >= 8 &&
                boxes.vertices.row(v) == boxes.vertices.row(boxes.triangles.data()[i]))
                boxes.triangles.data()[i] = v;
    list.push_back({"fourAtAnEdge",
                    boxes,
                    {{"components", 1},
                     {"nonmanifold_edges", 1},
                     {"nonmanifold_vertices", 2},
                     {"isolated_vertices", 2},
                     {"duplicate_vertices", 2}},
                    {"--split", "--isolated"},
                    {{"components", 2}, {"closed", true}, {"duplicate_vertices", 2}, {"volume", 2.0}}});
    TriMesh lonely = ball;
    add_vertex(lonely, {0, 0, 0.5});
    add_vertex(lonely, {0, 0.5, 0});
    list.push_back({"isolatedVertices",
                    lonely,
                    {{"components", 1}, {"closed", true}, {"isolated_vertices", 2}},
                    {"--isolated"},
                    closed_sphere});
    list.push_back({"debris",
                    joined(ball, moved(icosphere(0), {2, 0, 0}, 1e-3)),
                    {{"components", 2}, {"closed", true}},
                    {"--components", "min_area=1%"},
                    closed_sphere});
    return list;
}

std::vector<Defective> that_stay() {
    const TriMesh ball = sphere();
    std::vector<Defective> list;
    list.push_back({"interpenetrating",
                    joined(ball, moved(ball, {0.7, 0.1, 0.2})),
                    {{"components", 2}, {"closed", true}, {"self_intersections", "some"}},
                    {"--all"},
                    {{"components", 2}, {"closed", true}, {"self_intersections", "some"}},
                    "no repair removes intersections"});
    TriMesh sheet = strip(4, 4, 4, 4, 0);
    for (int v = 0; v < sheet.num_vertices(); ++v)
        if ((sheet.vertices.row(v) - Eigen::RowVector3d(2, 2, 0)).norm() < 1e-9) sheet.vertices.row(v) << 3.2, 2.6, 0;
    const Json folded{{"components", 1},
                      {"boundary_loops", 1},
                      {"inverted_triangles", "some"},
                      {"self_intersections", "any"},
                      {"adjacent_intersections", "some"}};
    list.push_back({"foldOver", sheet, folded, {"--orient", "--degenerate"}, folded, "no repair unfolds them"});
    return list;
}

std::vector<Defective> all_of_them() {
    std::vector<Defective> list;
    for (auto part :
         {with_open_edges(), with_wrong_orientation(), with_bad_triangles(), with_bad_connections(), that_stay()})
        list.insert(list.end(), part.begin(), part.end());
    return list;
}

void expect_info(const std::filesystem::path& file, const Json& expected) {
    const ProgramRun run = run_strake({"info", file.string(), "--json"});
    ASSERT_EQ(run.status, 0) << run.err;
    const Json found = Json::parse(run.out);
    for (const char* key : counted) {
        const Json wanted = expected.contains(key) ? expected[key] : Json(0);
        if (wanted == "some") {
            EXPECT_GT(found.at(key), 0) << key;
        } else if (wanted != "any") {
            EXPECT_EQ(found.at(key), wanted) << key;
        }
    }
    EXPECT_EQ(found.at("closed"), expected.value("closed", false));
    EXPECT_EQ(found.at("orientable"), expected.value("orientable", true));
    for (const char* key : {"components", "vertices", "triangles"})
        if (expected.contains(key)) {
            EXPECT_EQ(found.at(key), expected[key]) << key;
        }
    if (expected.contains("volume")) {
        EXPECT_NEAR(found.at("volume"), expected["volume"], 1e-12);
    }
}

class Surface : public testing::TestWithParam<Defective> {};

TEST_P(Surface, IsToldAndMendedOrSaidWhyNot) {
    const Defective& d = GetParam();
    const TempFolder folder;
    const std::string file = (folder / "in.off").string(), mended = (folder / "out.off").string();
    write_surface(file, d.mesh, SurfaceFormat::off);
    expect_info(file, d.defects);
    Words command{"repair", file, "--out", mended};
    command.insert(command.end(), d.options.begin(), d.options.end());
    const ProgramRun run = run_strake(command);
    ASSERT_EQ(run.status, 0) << run.err;
    if (!d.why.empty()) {
        EXPECT_NE(run.out.find(d.why), std::string::npos) << run.out;
    }
    expect_info(mended, d.after);
    if (!d.usable) return;  // it passes through itself, and any load makes new places of that
    const ProgramRun patches = run_strake({"patches", mended, "--angle", "auto", "--json"});
    EXPECT_EQ(patches.status, 0) << patches.err;
    folder.write("case.yaml",
                 "case: mended\nsurface: {file: out.off}\nregions: {all: {sphere: {center: [0, 0, 0], radius: 100}}}\n"
                 "shell: {thickness: 10%}\nloads:\n  - {region: all, traction: [0, 0, 0.001], spring: 1}\n");
    const ProgramRun deform =
        run_strake({"deform", (folder / "case.yaml").string(), "-o", (folder / "d.off").string()});
    EXPECT_EQ(deform.status, 0) << deform.err << deform.out;
}

INSTANTIATE_TEST_SUITE_P(Defective, Surface, testing::ValuesIn(all_of_them()),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace strake
