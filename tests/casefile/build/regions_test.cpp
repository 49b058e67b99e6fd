#include "casefile/build/region_formula.hpp"
#include "casefile/build/region_shapes.hpp"
#include "core/mesh/geometry.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <cmath>
#include <numbers>
#include <random>

namespace strake {
namespace {

using Regions = BuildProblem;

/// A random formula over three sets as text, and what it holds by its definition, for one triangle.
struct RandomFormula {
    std::mt19937 random;
    std::string words;
    int pick(int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); }

    TriangleMarks make(const std::vector<std::pair<std::string, TriangleMarks>>& sets, int depth) {
        if (depth == 0 || pick(4) == 0) {
            const auto& [name, marks] = sets[static_cast<std::size_t>(pick(static_cast<int>(sets.size())))];
            words += name;
            return marks;
        }
        const int sign = pick(3);
        words += "(";
        TriangleMarks left = make(sets, depth - 1);
        words += sign == 0 ? " + " : sign == 1 ? " - " : " & ";
        const TriangleMarks right = make(sets, depth - 1);
        words += ")";
        for (std::size_t t = 0; t < left.size(); ++t)
            left[t] = sign == 0   ? std::max(left[t], right[t])
                      : sign == 1 ? static_cast<char>(left[t] > right[t])
                                  : std::min(left[t], right[t]);
        return left;
    }
};

TriangleMarks marks_of(const std::vector<int>& triangles, int count) {
    TriangleMarks marks(static_cast<std::size_t>(count), 0);
    for (const int t : triangles) marks[static_cast<std::size_t>(t)] = 1;
    return marks;
}

TEST_F(Regions, AlgebraHoldsWhatSetsHold) {
    const TriMesh mesh = strip(4, 1, 16, 4);
    surface(mesh);
    const std::string sets = R"(regions:
  a: {box: [[0, 0, 0], [2.5, 1, 0]]}
  b: {box: [[1, 0, 0], [4, 0.5, 0]]}
  c: {sphere: {center: [2, 0.5, 0], radius: 1}}
)";
    const BuiltProblem known = build(sets, Purpose::deform);
    std::vector<std::pair<std::string, TriangleMarks>> named{{"all", TriangleMarks(mesh.num_triangles(), 1)}};
    for (const char* name : {"a", "b", "c"})
        named.emplace_back(name, marks_of(region(known, name), mesh.num_triangles()));
    int empty = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
        RandomFormula formula{std::mt19937(seed), ""};
        const TriangleMarks wanted = formula.make(named, 4);
        const std::string yaml = sets + "  made: " + formula.words + "\n";
        if (std::count(wanted.begin(), wanted.end(), 1) == 0) {
            ++empty;
            EXPECT_TRUE(contains(error(yaml, Purpose::deform), "region 'made' holds no triangle")) << formula.words;
        } else {
            EXPECT_EQ(marks_of(region(build(yaml, Purpose::deform), "made"), mesh.num_triangles()), wanted)
                << formula.words;
        }
    }
    EXPECT_LT(empty, 40);
}

TEST_F(Regions, IntersectionBindsCloserAndEqualSignsGoFromTheLeft) {
    const std::vector<std::pair<std::string, TriangleMarks>> sets{
        {"a", {1, 1, 0, 0}}, {"b-1", {0, 1, 1, 0}}, {"c (x)", {0, 0, 1, 1}}};
    const auto named = [&](const std::string& name) {
        for (const auto& [known, marks] : sets)
            if (known == name) return marks;
        throw InvalidInput("unknown " + name);
    };
    EXPECT_EQ(evaluate_formula("a + b-1 & \"c (x)\"", named), (TriangleMarks{1, 1, 1, 0}));
    EXPECT_EQ(evaluate_formula("(a + b-1) & \"c (x)\"", named), (TriangleMarks{0, 0, 1, 0}));
    EXPECT_EQ(evaluate_formula("a - b-1 + b-1", named), (TriangleMarks{1, 1, 1, 0}));
    EXPECT_EQ(evaluate_formula("a - (b-1 + b-1)", named), (TriangleMarks{1, 0, 0, 0}));
    EXPECT_EQ(names_in_formula("a +(b-1)"), (std::vector<std::string>{"a", "b-1"}));
    for (const char* wrong : {"", "a +", "+ a", "a b-1", "(a", "a)", "a & & b-1", "\"a", "()"})
        EXPECT_THROW(evaluate_formula(wrong, named), InvalidInput) << wrong;
    EXPECT_THROW(evaluate_formula(std::string(5000, '('), named), InvalidInput) << "no deep recursion";
}

TEST_F(Regions, NamesOfPartsAndPatchesServeAndCirclesAreToldWithTheirPath) {
    TriMesh cube = box_surface(Eigen::Vector3d::Ones(), 2);
    cube.group_names = {"lid", "the rest"};
    cube.group.assign(cube.num_triangles(), 1);
    cube.group[5] = cube.group[6] = 0;
    surface(cube);
    const std::string levels = "parameters: {levels: [20deg]}\n";
    const BuiltProblem built = build(levels + "regions: {most: all - lid, both: other + most, other: {solid: lid}}\n");
    EXPECT_EQ(region(built, "most").size(), static_cast<std::size_t>(cube.num_triangles() - 2));
    EXPECT_EQ(region(built, "both").size(), static_cast<std::size_t>(cube.num_triangles()));
    const Patch& patch = built.problem.tree.levels[1].patches[2];
    const BuiltProblem of_patch = build(levels + "regions: {p: '\"" + patch.name + "\" - lid'}\n", Purpose::deform);
    for (const int t : region(of_patch, "p"))
        EXPECT_TRUE(std::binary_search(patch.triangles.begin(), patch.triangles.end(), t));
    const std::string circle =
        error("regions: {a: b + c, b: {box: [[0, 0, 0], [1, 1, 1]]}, c: lid - d, d: {grow: {of: a, by: 1}}}\n");
    EXPECT_TRUE(contains(circle, "region 'a' is made of itself: a -> c -> d -> a")) << circle;
    std::string chain = "regions:\n";
    for (int k = 0; k < 600; ++k) chain += text("  r", k, ": r", k + 1, "\n");
    const std::string deep = error(chain + "  r600: lid\n");
    EXPECT_TRUE(contains(deep, "region 'r0' is made of more than 500 regions, one from another")) << deep;
    EXPECT_TRUE(contains(error("regions: {a: all - lit}\n"),
                         "'lit' is no region, part of the surface file or patch; did you mean 'lid'?"));
    EXPECT_TRUE(contains(error("regions: {a: all-lid}\n"), "put blanks around +, - and &"));
    EXPECT_TRUE(contains(error("regions: {a: all - all}\n"), "region 'a' holds no triangle"));
}

TEST_F(Regions, GrowingFollowsEdgesAndShrinkingGrowsTheRest) {
    const TriMesh mesh = strip(4, 1, 8, 2);  // cells of 0.5
    surface(mesh);
    const BuiltProblem built = build(R"(regions:
  left:  {box: [[0, 0, 0], [1, 1, 0]]}
  more:  {grow: {of: left, by: 1}}
  back:  {grow: {of: more, by: -1}}
  same:  {grow: {of: left, by: 0}}
  close: {near: {of: left, within: 1.2}}
  touch: {near: {of: left, within: 1.2}, touch: any}
)",
                                     Purpose::deform);
    const auto up_to = [&](double x) {
        std::vector<int> found;
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            double far = 0;
            for (int k = 0; k < 3; ++k) far = std::max(far, mesh.vertices(mesh.triangles(t, k), 0));
            if (far <= x + 1e-9) found.push_back(t);
        }
        return found;
    };
    EXPECT_EQ(region(built, "left"), up_to(1));
    EXPECT_EQ(region(built, "more"), up_to(2)) << "straight edges along the strip are the shortest way";
    EXPECT_EQ(region(built, "back"), up_to(1));
    EXPECT_EQ(region(built, "same"), up_to(1));
    EXPECT_EQ(region(built, "close"), up_to(2));
    EXPECT_EQ(region(built, "touch"), up_to(2.5)) << "one more row touches it";
}

/// A triangle as a sphere, a box or a half-space sees it: thousands of its points.
double min_excess(const RegionShape& shape, const TriMesh& mesh, int t) {
    double least = 1e300;
    constexpr int n = 60;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
            const Eigen::Vector3d x =
                (i * mesh.vertices.row(mesh.triangles(t, 0)) + j * mesh.vertices.row(mesh.triangles(t, 1)) +
                 (n - i - j) * mesh.vertices.row(mesh.triangles(t, 2))) /
                n;
            double excess = 0;
            if (const auto* box = std::get_if<BoxShape>(&shape))
                excess = std::max((box->min - x).maxCoeff(), (x - box->max).maxCoeff());
            else if (const auto* sphere = std::get_if<SphereShape>(&shape))
                excess = (x - sphere->center).norm() - sphere->radius.value;
            else
                excess = std::get<HalfSpace>(shape).offset - std::get<HalfSpace>(shape).normal.dot(x);
            least = std::min(least, excess);
        }
    return least;
}

TEST(RegionShapes, TouchingAsksEveryPointOfATriangleNotItsVertices) {
    TriMesh mesh = box_surface(Eigen::Vector3d::Ones(), 2);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> any(-0.3, 1.3), size(0.02, 0.4);
    int without_a_vertex = 0, missed = 0;
    for (int i = 0; i < 60; ++i) {
        const Eigen::Vector3d at(any(random), any(random), any(random));
        const double r = size(random);
        RegionShape shape = SphereShape{at, {r}};
        if (i % 3 == 1) shape = BoxShape{at, at + Eigen::Vector3d(r, 0.3 * r, 2 * r)};
        if (i % 3 == 2) shape = HalfSpace{at.normalized(), 1.5 * r};
        const std::vector<int> touching = triangles_in(shape, mesh, 1.7, true),
                               inside = triangles_in(shape, mesh, 1.7, false);
        double nearest = 1e300;
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const double least = min_excess(shape, mesh, t);  // of samples: up to their spacing too large
            const bool touches = std::binary_search(touching.begin(), touching.end(), t);
            const bool is_seen = least <= 0, may_be_seen = least <= 0.02;
            EXPECT_GE(touches, is_seen) << i;
            EXPECT_LE(touches, may_be_seen) << i;
            nearest = std::min(nearest, least);
        }
        EXPECT_TRUE(std::includes(touching.begin(), touching.end(), inside.begin(), inside.end()));
        without_a_vertex += inside.empty() && !touching.empty();
        const NearestMiss miss = nearest_miss(shape, mesh, 1.7, true);
        EXPECT_NEAR(miss.shortfall, std::max(0.0, nearest), 0.02) << i;
        missed += miss.shortfall > 0;
    }
    EXPECT_GT(without_a_vertex, 5);
    EXPECT_GT(missed, 5);
}

TEST_F(Regions, AnEmptyOneSaysWhatComesNearestAndWhatWouldHoldIt) {
    surface(strip(4, 1, 8, 2));  // cells of 0.5
    const auto words = [&](const std::string& shape) {
        return error("regions: {a: {" + shape + "}}\n", Purpose::deform);
    };
    // The corner (0, 0) of the triangle at it is inside; its farthest vertex is sqrt(0.5) away.
    const std::string sphere = words("sphere: {center: [0, 0, 0], radius: 0.1}");
    EXPECT_TRUE(contains(sphere, " comes nearest, and would be inside with a radius of")) << sphere;
    EXPECT_TRUE(contains(sphere, "(now 0.1)")) << sphere;
    EXPECT_TRUE(contains(sphere, "with touch: any, the region would hold")) << sphere;
    // What the message says is enough, typed in.
    const std::size_t at = sphere.find("radius of ") + 10;
    const std::string radius = sphere.substr(at, sphere.find(' ', at) - at);
    const auto held = [&](const std::string& shape) {
        return region(build("regions: {a: {" + shape + "}}\n", Purpose::deform), "a").size();
    };
    EXPECT_GE(held("sphere: {center: [0, 0, 0], radius: " + radius + "}"), 1u);
    EXPECT_GE(held("sphere: {center: [0, 0, 0], radius: 0.1}, touch: any"), 1u);
    // Within one triangle: no vertex, and yet it touches.
    EXPECT_EQ(held("sphere: {center: [0.2, 0.1, 0], radius: 0.02}, touch: any"), 1u);
    EXPECT_EQ(held("box: [[0.2, 0.1, -1], [0.21, 0.11, 1]], touch: any"), 1u);
    const std::string away = words("box: [[0, 0, 0.25], [4, 1, 1]], touch: any");
    EXPECT_TRUE(contains(away,
                         "nor does one touch it: triangle 0 comes nearest, and would touch it if each face of the box "
                         "were 0.25 farther out"))
        << away;
    const std::string beyond = words("plane: {normal: [1, 0, 0], at: 4.75}, side: above");
    EXPECT_TRUE(contains(beyond, "would be inside if the plane were moved by 1.25")) << beyond;
    EXPECT_FALSE(contains(beyond, "touch: any")) << "no triangle touches it";
}

TEST_F(Regions, FloodStopsAtCreasesAndFacingAsksTheNormal) {
    const TriMesh cube = box_surface(Eigen::Vector3d::Ones(), 3);
    surface(cube);
    const BuiltProblem built = build(R"(regions:
  top:    {flood: {from: [0.5, 0.5, 1.1], angle: 30deg}}
  whole:  {flood: {from: 0, angle: 100deg}}
  up:     {facing: +z}
  down:   {facing: [0, 0, -3]}
  sides:  all - up - down
  cone:   {facing: [1, 0, 1], within: 50deg}
)",
                                     Purpose::deform);
    const Points normal = triangle_normals(cube);
    const auto facing = [&](const Eigen::Vector3d& way, double within) {
        std::vector<int> found;
        for (int t = 0; t < cube.num_triangles(); ++t)
            if (std::acos(std::clamp(normal.row(t).dot(way.normalized()), -1.0, 1.0)) < within) found.push_back(t);
        return found;
    };
    EXPECT_EQ(region(built, "top"), facing({0, 0, 1}, 0.1));
    EXPECT_EQ(static_cast<int>(region(built, "whole").size()), cube.num_triangles());
    EXPECT_EQ(region(built, "up"), facing({0, 0, 1}, 0.1)) << "walls at 90 degrees do not face up";
    EXPECT_EQ(region(built, "down"), facing({0, 0, -1}, 0.1));
    EXPECT_EQ(static_cast<int>(region(built, "sides").size()), cube.num_triangles() * 4 / 6);
    EXPECT_EQ(region(built, "cone"), facing({1, 0, 1}, 50 * std::numbers::pi / 180));
    EXPECT_TRUE(contains(error("regions: {a: {flood: {from: 99999}}}\n"), "triangle 99999 must be in [0, "));
    EXPECT_TRUE(contains(error("regions: {a: {facing: up}}\n"), "regions.a.facing"));
    EXPECT_TRUE(contains(error("regions: {a: {facing: [0, 0, 0]}}\n"), "has no direction"));
    EXPECT_TRUE(contains(error("regions: {a: {solid: x, touch: any}}\n"), "touch"));
    const BuiltProblem boxed = build("regions: {up: {facing: +z}}\n", Purpose::deform);
    EXPECT_EQ(boxed.regions[0].box.min, Eigen::Vector3d(0, 0, 1));
    EXPECT_EQ(boxed.regions[0].box.max, Eigen::Vector3d(1, 1, 1));
    EXPECT_NEAR(boxed.regions[0].area, 1, 1e-12);
}

}  // namespace
}  // namespace strake
