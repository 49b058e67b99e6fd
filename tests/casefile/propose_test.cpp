#include "casefile/propose/propose_parts.hpp"
#include "casefile/propose/trial.hpp"
#include "cases/geometry/dirty_body.hpp"
#include "core/mesh/geometry.hpp"
#include "core/parallel.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <cmath>
#include <numbers>

namespace strake {
namespace {

using proposing::PartRole;

/// Closed boxes, one group each.
struct Parts {
    TriMesh mesh;
    std::vector<int> component;

    void add(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& middle, int cells = 4) {
        const TriMesh box = box_surface(size, cells);
        const int n = mesh.num_vertices(), m = mesh.num_triangles();
        mesh.vertices.conservativeResize(n + box.num_vertices(), 3);
        mesh.vertices.bottomRows(box.num_vertices()) = box.vertices.rowwise() + (middle - 0.5 * size).transpose();
        mesh.triangles.conservativeResize(m + box.num_triangles(), 3);
        mesh.triangles.bottomRows(box.num_triangles()) = box.triangles.array() + n;
        mesh.group.insert(mesh.group.end(), static_cast<std::size_t>(box.num_triangles()),
                          static_cast<int>(mesh.group_names.size()));
        component.insert(component.end(), static_cast<std::size_t>(box.num_triangles()),
                         static_cast<int>(mesh.group_names.size()));
        mesh.group_names.push_back(name);
    }
    std::vector<PartRole> roles(const std::optional<SymmetryPlane>& mirror = {}) const {
        return proposing::part_roles(mesh, component, 10, mirror);
    }
};

TEST(PartRoles, WingsMoveNacellesHangSupportsAndWhatIsFarAreHeld) {
    Parts parts;
    parts.add("Fuselage", {6, 0.6, 0.6}, {0, 0, 0});
    parts.add("Wing", {1, 5, 0.1}, {0, 0, 0.1});
    parts.add("Nacelle", {1, 0.4, 0.4}, {0.2, 1, -0.3});  // near the wing, with a twentieth of the fuselage's area
    parts.add("sting", {3, 0.5, 0.5}, {4.5, 0, 0});
    parts.add("", {0.1, 0.1, 0.1}, {0, 0, 0.36});
    parts.add("ship 2", {1, 1, 1}, {0, 30, 0});
    const std::vector<PartRole> roles = parts.roles();
    ASSERT_EQ(roles.size(), 6U);
    const PartRole::Kind wanted[] = {PartRole::Kind::main, PartRole::Kind::moves,    PartRole::Kind::attached,
                                     PartRole::Kind::held, PartRole::Kind::attached, PartRole::Kind::held};
    for (std::size_t p = 0; p < roles.size(); ++p) EXPECT_EQ(roles[p].role, wanted[p]) << p;
    EXPECT_EQ(roles[2].host, 1) << "the wing is nearer than the fuselage";
    EXPECT_NEAR(roles[2].gap, 0.15, 1e-12);
    EXPECT_EQ(roles[4].host, 0);
    EXPECT_EQ(roles[1].name, "wing");
    EXPECT_EQ(roles[4].name, "part_4") << "the file does not name it";
    EXPECT_EQ(roles[5].name, "ship_2");
}

TEST(PartRoles, LeftAndRightAreAPairOfOneRole) {
    Parts parts;
    parts.add("body", {6, 0.6, 0.6}, {0, 0, 0});
    parts.add("a", {1, 2, 0.1}, {0, 1.4, 0.1});
    parts.add("b_mount", {1, 2, 0.1}, {0, -1.4, 0.1});  // a name that holds it, were it not for the other one
    parts.add("c", {1, 2, 0.1}, {1.5, -1.4, 0.1});
    const SymmetryPlane plane{{0, 1, 0}, 0};
    EXPECT_EQ(parts.roles()[2].role, PartRole::Kind::held);
    const std::vector<PartRole> roles = parts.roles(plane);
    EXPECT_EQ(roles[1].image, 2);
    EXPECT_EQ(roles[2].image, 1);
    EXPECT_EQ(roles[2].role, PartRole::Kind::moves);
    EXPECT_EQ(roles[3].image, -1);
    EXPECT_EQ(roles[0].image, -1);
}

class Proposed : public BuildProblem {
protected:
    ProposedCase proposed(const TriMesh& mesh) {
        write_surface(folder.path() / "body.obj", mesh, SurfaceFormat::obj);
        return propose_case(folder.path() / "body.obj", folder.path() / "new.yaml");
    }
};

TEST_F(Proposed, AWingBesideItsBodyMovesAndASmallPartIsAttached) {
    Parts parts;
    parts.add("body", {6, 0.6, 0.6}, {0, 0, 0}, 8);
    parts.add("wing", {1, 3, 0.1}, {0, 1.9, 0}, 8);
    parts.add("pod", {0.3, 0.1, 0.1}, {0, 2, -0.15});
    const ProposedCase proposal = proposed(parts.mesh);
    EXPECT_TRUE(contains(proposal.yaml, "  wing_root: {box: ")) << proposal.yaml;
    EXPECT_FALSE(contains(proposal.yaml, "component: 1}")) << "the wing is not held as a whole\n" << proposal.yaml;
    EXPECT_TRUE(contains(proposal.yaml, "  - {part: 2, to: 1, how: rigid}")) << proposal.yaml;
    const BuiltProblem built =
        build_problem(load_case(folder.write("new.yaml", proposal.yaml), Purpose::run), Purpose::run);
    EXPECT_EQ(built.problem.attached.size(), 1U);
    const std::vector<int>& held = region(built, "wing_root");
    const auto of_wing =
        std::ranges::count_if(held, [&](int t) { return parts.component[static_cast<std::size_t>(t)] == 1; });
    const auto wing = std::ranges::count(parts.component, 1);
    EXPECT_GT(of_wing, 0);
    EXPECT_LT(of_wing, wing / 3);
    EXPECT_FALSE(proposal.ties_parts);
}

/// A surface of revolution about z by heights and radii, closed at the bottom and open at the top.
TriMesh vessel(const std::vector<std::pair<double, double>>& profile) {
    constexpr int around = 24;
    const int rings = static_cast<int>(profile.size());
    TriMesh mesh;
    mesh.vertices.resize(rings * around + 1, 3);
    mesh.triangles.resize((2 * (rings - 1) + 1) * around, 3);
    int t = 0;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < around; ++j) {
            const auto [z, r] = profile[static_cast<std::size_t>(i)];
            const double angle = 2 * std::numbers::pi * j / around;
            const int a = i * around + j, b = i * around + (j + 1) % around;
            mesh.vertices.row(a) << r * std::cos(angle), r * std::sin(angle), z;
            if (i == 0)
                mesh.triangles.row(t++) << b, a, rings * around;
            else
                mesh.triangles.row(t++) << a - around, b - around, b, mesh.triangles.row(t++) << a - around, b, a;
        }
    mesh.vertices.row(rings * around) << 0, 0, profile[0].first;
    return mesh;
}

TEST_F(Proposed, TheMouthOfABottleIsNoSymmetryPlane) {
    const std::vector<std::pair<double, double>> body{{0, 3}, {2, 3.5}, {5, 3.5}, {8, 3.5}, {11, 3.5}};
    std::vector<std::pair<double, double>> bottle = body;
    for (const auto& ring : {std::pair(13., 2.5), std::pair(15., 1.2), std::pair(18., 1.2)}) bottle.push_back(ring);
    const std::string open = proposed(vessel(bottle)).yaml;
    EXPECT_FALSE(contains(open, "symmetry: {plane")) << open;
    EXPECT_TRUE(contains(open, "  base: {plane: {normal: [0, 0, 1]")) << open;
    const std::string half = proposed(vessel(body)).yaml;  // as wide at the opening as anywhere
    EXPECT_TRUE(contains(half, "symmetry: {plane: z, at: 11}")) << half;
}

TEST_F(Proposed, ACarStandsOnItsFloorAndItsRoofIsUp) {
    Parts parts;
    parts.add("body", {4.4, 1.8, 1.2}, {2.2, 0, 0.8}, 8);
    for (const double x : {0.9, 3.5})
        for (const double y : {-0.85, 0.85}) parts.add("wheel", {0.6, 0.2, 0.6}, {x, y, 0.33}, 2);
    for (int v = 0; v < parts.mesh.num_vertices(); ++v)  // the roof is narrower than the floor
        if (parts.mesh.vertices(v, 2) > 1.3) parts.mesh.vertices(v, 0) = 2.2 + 0.7 * (parts.mesh.vertices(v, 0) - 2.2);
    const std::string car = proposed(parts.mesh).yaml;
    EXPECT_TRUE(contains(car, "  base: {plane: {normal: [0, 0, 1], at: 0.2")) << car;
    EXPECT_TRUE(contains(car, "axes: {downstream: +x, up: +z}")) << car;
}

TEST_F(Proposed, ADeckIsNotWhatAHullStandsOn) {
    TriMesh hull = box_surface({24, 4, 3}, 8);
    for (int v = 0; v < hull.num_vertices(); ++v) {  // a wedge with its edge below
        hull.vertices(v, 1) = 2 + (hull.vertices(v, 1) - 2) * (0.05 + 0.95 * hull.vertices(v, 2) / 3);
        hull.vertices(v, 2) += 0.02 * (hull.vertices(v, 0) - 12) * (3 - hull.vertices(v, 2));
    }
    const std::string yaml = proposed(hull).yaml;
    EXPECT_TRUE(contains(yaml, "up: +z}")) << yaml;
}

TEST_F(Proposed, ABandAlongThePlaneOfSymmetryHoldsSomethingWhereTrianglesAreLong) {
    std::vector<std::pair<double, double>> rings;
    for (int i = 1; i < 30; ++i)
        rings.emplace_back(-std::cos(std::numbers::pi * i / 30), 0.25 * std::sin(std::numbers::pi * i / 30));
    TriMesh pod = vessel(rings);
    const int n = pod.num_vertices(), m = pod.num_triangles();
    pod.vertices.conservativeResize(n + 3, 3);
    pod.vertices.bottomRows(3) << 0.1, 0.4, -0.5, 0.1, 0.4, -0.496, 0.102, 0.403, -0.5;  // debris
    pod.triangles.conservativeResize(m + 1, 3);
    pod.triangles.row(m) << n, n + 1, n + 2;
    const std::string yaml = proposed(pod).yaml;
    EXPECT_NO_THROW(build_problem(load_case(folder.write("new.yaml", yaml), Purpose::run), Purpose::run)) << yaml;
}

TEST_F(Proposed, AFlapAlongAWingIsTied) {
    Parts parts;
    parts.add("wing", {2, 5, 0.2}, {0, 0, 0}, 8);
    parts.add("flap", {0.3, 5, 0.1}, {1.2, 0, 0}, 8);
    EXPECT_TRUE(proposed(parts.mesh).ties_parts);
}

TEST_F(Proposed, HalvesWithAGapAreNotLeftToShellsOfTheirOwn) {
    EXPECT_TRUE(proposed(example::dirty_body("gaps")).ties_parts);
}

/// A small triangle of its own.
void add_stray(TriMesh& mesh, const Eigen::RowVector3d& at, double size = 0.01) {
    const int n = mesh.num_vertices(), m = mesh.num_triangles();
    mesh.vertices.conservativeResize(n + 3, 3);
    mesh.vertices.bottomRows(3) << at, at + size * Eigen::RowVector3d(1, 0.2, 0),
        at + size * Eigen::RowVector3d(0, 1, 0.3);
    mesh.triangles.conservativeResize(m + 1, 3);
    mesh.triangles.row(m) << n, n + 1, n + 2;
}

/// As far as its thickness allows, not a share of its length: 2 V / A is 0.2, 5 % of which are the mean motion.
TEST_F(Proposed, ALongThinBodyMayMoveAFewTimesItsMeanMotion) {
    surface(box_surface({1000, 0.4, 0.4}, 4));
    const std::string yaml = propose_case(folder.path() / "s.obj", folder.path() / "new.yaml",
                                          {60, ProposedHold::band, ProposedWay::fields, ""})
                                 .yaml;
    EXPECT_TRUE(contains(yaml, "max_displacement: 0.004%")) << yaml;
}

TEST_F(Proposed, StrayTrianglesSayNothingAboutTheBody) {
    const TriMesh clean = ellipsoid({2, 0.6, 0.4}, 3);
    TriMesh mesh = clean;
    add_stray(mesh, {0.5, 3, 1});
    add_stray(mesh, {1, 2.5, 0.3});
    add_stray(mesh, {-1, 0.1, 2});
    const std::string without = proposed(clean).yaml, with = proposed(mesh).yaml;
    const std::string dropped =
        "repair:\n  components: {min_area: 0.002%}" + std::string(30, ' ') + "# 3 triangles in 3 stray pieces of ";
    EXPECT_TRUE(contains(with, dropped)) << with;
    EXPECT_FALSE(contains(without, "repair:"));
    // Everything else is as for the body alone.
    const auto rest = [](const std::string& yaml) { return yaml.substr(yaml.find("\n# Regions that do not move")); };
    EXPECT_EQ(rest(with), rest(without));
    EXPECT_TRUE(contains(with, "maximize: volume") && contains(with, "mirror: true")) << with;
    const BuiltProblem built = build_problem(load_case(folder.write("new.yaml", with), Purpose::run), Purpose::run);
    EXPECT_EQ(built.problem.surface.num_triangles(), clean.num_triangles());
    for (const ProposedWay way : {ProposedWay::wrap, ProposedWay::fields})
        EXPECT_TRUE(contains(
            propose_case(folder.path() / "body.obj", folder.path() / "new.yaml", {60, ProposedHold::band, way, ""})
                .yaml,
            dropped));
}

TEST(Debris, IsFewTrianglesAwayFromTheRest) {
    TriMesh mesh = ellipsoid({2, 0.6, 0.4}, 3);
    EXPECT_FALSE(proposing::debris(mesh));
    TriMesh beside = mesh;
    add_stray(beside, {0, 0, 0.401});
    EXPECT_FALSE(proposing::debris(beside)) << "it may be a piece of the skin";
    TriMesh fin = mesh;
    add_stray(fin, {1, 1, 1}, 0.3);
    EXPECT_FALSE(proposing::debris(fin)) << "it has area";
    TriMesh soup;  // each triangle a piece of its own
    soup.vertices.resize(3 * mesh.num_triangles(), 3);
    soup.triangles.resize(mesh.num_triangles(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            soup.vertices.row(3 * t + k) = mesh.vertices.row(mesh.triangles(t, k));
            soup.triangles(t, k) = 3 * t + k;
        }
    add_stray(soup, {1, 1, 1});
    EXPECT_FALSE(proposing::debris(soup)) << "a limit would drop the body";
    add_stray(mesh, {1, 1, 1});
    const std::optional<proposing::Debris> found = proposing::debris(mesh);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->pieces, 1);
    EXPECT_EQ(found->triangles, 1);
    EXPECT_GT(found->min_area_percent, 2.9 * 100 * found->share);
    EXPECT_LT(found->min_area_percent, 7 * 100 * found->share);
}

/// A hexagonal tube without ends, 12 triangles.
TriMesh tube(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius) {
    constexpr int around = 6;
    const Eigen::Vector3d u = (to - from).unitOrthogonal(), w = (to - from).normalized().cross(u);
    TriMesh out;
    out.vertices.resize(2 * around, 3);
    out.triangles.resize(2 * around, 3);
    for (int k = 0; k < around; ++k) {
        const double a = 2 * std::numbers::pi * k / around;
        const Eigen::Vector3d off = radius * (std::cos(a) * u + std::sin(a) * w);
        out.vertices.row(k) = (from + off).transpose();
        out.vertices.row(k + around) = (to + off).transpose();
        const int next = (k + 1) % around;
        out.triangles.row(2 * k) << k, next, next + around;
        out.triangles.row(2 * k + 1) << k, next + around, k + around;
    }
    return out;
}

TriMesh beside(TriMesh mesh, const TriMesh& other) {
    const int n = mesh.num_vertices(), m = mesh.num_triangles();
    mesh.vertices.conservativeResize(n + other.num_vertices(), 3);
    mesh.vertices.bottomRows(other.num_vertices()) = other.vertices;
    mesh.triangles.conservativeResize(m + other.num_triangles(), 3);
    mesh.triangles.bottomRows(other.num_triangles()) = other.triangles.array() + n;
    return mesh;
}

TEST(Debris, PartsOfFewTrianglesAreNone) {
    const TriMesh body = ellipsoid({2, 0.6, 0.4}, 3);
    const TriMesh antenna = tube({0, 0, 0.3}, {0, 0, 0.6}, 0.004), pitot = tube({-2.3, 0, 0}, {-2.05, 0, 0}, 0.004);
    EXPECT_FALSE(proposing::debris(beside(body, antenna))) << "through the skin, with no vertex near it";
    const TriMesh above = tube({0, 0, 0.5}, {0, 0, 0.8}, 0.004);
    EXPECT_TRUE(proposing::debris(beside(body, above))) << "the same away from it";
    TriMesh named = beside(body, pitot);
    EXPECT_TRUE(proposing::debris(named));
    named.group.assign(static_cast<std::size_t>(named.num_triangles()), 0);
    named.group_names = {"fuselage", "pitot"};
    EXPECT_TRUE(proposing::debris(named)) << "of the same name as the body";
    std::fill(named.group.end() - pitot.num_triangles(), named.group.end(), 1);
    EXPECT_FALSE(proposing::debris(named));
    named.group_names[1] = "12";
    EXPECT_TRUE(proposing::debris(named)) << "a number is no name";
}

TEST(Debris, TrianglesOfZeroAreaAreForAnotherRepair) {
    TriMesh line;
    line.vertices.resize(3, 3);
    line.vertices << 0, 3, 0, 0.1, 3, 0, 0.2, 3, 0;
    line.triangles.resize(1, 3);
    line.triangles << 0, 1, 2;
    TriMesh mesh = beside(ellipsoid({2, 0.6, 0.4}, 3), line);
    EXPECT_FALSE(proposing::debris(mesh)) << "no limit on the area drops it";
    add_stray(mesh, {1, 1, 1});
    EXPECT_TRUE(proposing::debris(mesh));
}

TEST_F(Proposed, WhatIsSoundButForItsNeedlesMayGetNewTriangles) {
    EXPECT_TRUE(proposed(example::dirty_body("cad_slivers")).may_remesh);
    EXPECT_FALSE(proposed(example::dirty_body("crossing_boxes")).may_remesh);
    EXPECT_FALSE(proposed(ellipsoid({2, 0.6, 0.4}, 3)).may_remesh);
}

/// The mean edge of needles is 7 % of the diagonal: triangles of that length lose 2 to 4 % of the volume, and the plane
/// of symmetry.
TEST_F(Proposed, NewTrianglesOfNeedlesKeepTheShape) {
    for (const unsigned seed : {1U, 2U, 5U}) {
        SCOPED_TRACE(seed);
        const TriMesh body = example::dirty_body("cad_slivers", seed);
        proposed(body);  // writes body.obj
        const std::string yaml = propose_case(folder.path() / "body.obj", folder.path() / "new.yaml",
                                              {60, ProposedHold::band, ProposedWay::remeshed_shell, ""})
                                     .yaml;
        EXPECT_TRUE(contains(yaml, "fields: auto")) << yaml;
        EXPECT_TRUE(contains(yaml, "mirror: true")) << yaml;
        const BuiltProblem built = build_problem(load_case(folder.write("new.yaml", yaml), Purpose::run), Purpose::run);
        EXPECT_NE(built.problem.surface.num_triangles(), body.num_triangles());
        EXPECT_NEAR(enclosed_volume(built.problem.surface), enclosed_volume(body), 0.01 * enclosed_volume(body));
    }
}

TEST_F(Proposed, TestDeformationsAreCutShortByWorkNotByTime) {
    surface(box_surface({4, 1, 1}, 6));
    const BuiltProblem built = build(
        "regions: {end: {plane: {normal: [1, 0, 0], at: 0.1}, side: below}}\nfixed: [end]\n"
        "parameters: {levels: auto, patches_per_level: [4], variables: [normal]}\nobjective: {maximize: volume}\n",
        Purpose::run);
    const double triangles = built.problem.surface.num_triangles();
    const Trial whole = try_deformations(built.problem, 1e9);
    EXPECT_EQ(whole.tried, 6);
    EXPECT_EQ(whole.failed, 0) << whole.reason;
    EXPECT_TRUE(whole.is_sound());
    const Trial none = try_deformations(built.problem, 0.5 * triangles);
    EXPECT_EQ(none.tried, 0);
    EXPECT_TRUE(none.is_cut_short);
    EXPECT_FALSE(none.is_sound());
    const int before = num_threads();
    int tried[2];
    for (const int threads : {1, 2}) {
        set_num_threads(threads);
        tried[threads - 1] = try_deformations(built.problem, 12 * triangles).tried;
    }
    set_num_threads(before);
    EXPECT_EQ(tried[0], tried[1]);
    EXPECT_GT(tried[0], 0);
    EXPECT_LT(tried[0], 6);
}

/// A wing of long triangles through a body of long triangles.
Parts pierced_body(double wing_at = 0) {
    Parts parts;
    parts.add("body", {6, 0.6, 0.6}, {0, 0, 0}, 2);
    parts.add("wing", {1, 5, 0.1}, {0.1, 0, wing_at}, 2);
    return parts;
}

TEST_F(Proposed, ShorterEdgesAtJointsAreOfferedWhereABendShowsThatTheyCloseThem) {
    const TriMesh mesh = pierced_body().mesh;
    const auto tried = proposing::tried_joints(mesh, intersections(mesh));
    ASSERT_TRUE(tried);
    EXPECT_GT(tried->before, 1e-3);
    EXPECT_LT(tried->after, 0.1 * tried->before);
    surface(mesh);
    for (const ProposedWay way : {ProposedWay::wrap, ProposedWay::fields}) {
        ProposalOptions options{60, ProposedHold::band, way, ""};
        const ProposedCase as_it_is = propose_case(folder.path() / "s.obj", folder.path() / "new.yaml", options);
        EXPECT_TRUE(contains(as_it_is.yaml, "\n# repair: {joints: 1%}")) << as_it_is.yaml;
        EXPECT_FALSE(as_it_is.has_new_vertices);
        EXPECT_EQ(as_it_is.num_triangles, mesh.num_triangles()) << "new vertices are the user's decision";
        EXPECT_TRUE(std::ranges::any_of(as_it_is.found, [](const auto& s) { return contains(s, "init --joints"); }));
        options.joints = true;
        const ProposedCase halved = propose_case(folder.path() / "s.obj", folder.path() / "new.yaml", options);
        EXPECT_TRUE(contains(halved.yaml, "\nrepair:\n  joints: 1%")) << halved.yaml;
        EXPECT_TRUE(halved.has_new_vertices);
        EXPECT_EQ(halved.num_triangles, tried->triangles);
        const BuiltProblem built =
            build_problem(load_case(folder.write("new.yaml", halved.yaml), Purpose::run), Purpose::run);
        EXPECT_EQ(built.problem.surface.num_triangles(), tried->triangles) << "what was measured is what the case has";
        EXPECT_FALSE(proposing::tried_joints(built.problem.surface, intersections(built.problem.surface)))
            << "its joints stay closed";
        EXPECT_LT(try_deformations(built.problem, 1e9).failed, 1);
    }
}

TEST_F(Proposed, NoEdgesAreHalvedWherePartsDoNotMeetOrShellsHoldThem) {
    const TriMesh apart = pierced_body(2).mesh, pierced = pierced_body().mesh;
    EXPECT_FALSE(proposing::tried_joints(apart, intersections(apart)));
    EXPECT_FALSE(proposing::tried_joints(pierced, {})) << "the pairs are not known";
    surface(apart);
    ProposalOptions options{60, ProposedHold::band, ProposedWay::fields, ""};
    options.joints = true;
    EXPECT_FALSE(contains(propose_case(folder.path() / "s.obj", folder.path() / "new.yaml", options).yaml, "joints"));
}

TEST(Trial, OneFailureOfSixIsNotSound) {
    Trial trial;
    EXPECT_FALSE(trial.is_sound()) << "nothing was tried";
    trial.tried = 6;
    EXPECT_TRUE(trial.is_sound());
    trial.failed = 1;
    EXPECT_FALSE(trial.is_sound());
}

}  // namespace
}  // namespace strake
