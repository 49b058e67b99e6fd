#include "studio/choice.hpp"

#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

#include <unistd.h>
#include <algorithm>
#include <fstream>
#include <numbers>

namespace strake {
namespace {

/// Two boxes beside each other, parts of a file.
TriMesh two_boxes(int cells) {
    TriMesh one = box_surface({1, 2, 3}, cells), both = one;
    const int n = one.num_vertices(), m = one.num_triangles();
    both.vertices.conservativeResize(2 * n, 3);
    both.vertices.bottomRows(n) = one.vertices.rowwise() + Eigen::RowVector3d(4, 0, 0);
    both.triangles.conservativeResize(2 * m, 3);
    both.triangles.bottomRows(m) = one.triangles.array() + n;
    both.group_names = {"first", "second"};
    both.group.assign(static_cast<std::size_t>(2 * m), 0);
    std::fill(both.group.begin() + m, both.group.end(), 1);
    return both;
}

class Choices : public ::testing::Test {
protected:
    std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("strake-choice-" + std::to_string(::getpid()));
    RegionGround ground;
    std::vector<Region> none;

    void SetUp() override {
        std::filesystem::create_directories(folder);
        StartSurface& start = ground.start;
        start.mesh = two_boxes(6);
        start.adjacent = adjacency(start.mesh);
        start.area = triangle_areas(start.mesh);
        start.diagonal = box_diagonal(start.mesh);
        start.file_triangles = start.mesh.num_triangles();
        ground.tree = segment_automatically(start.mesh, start.adjacent);
        write_surface(folder / "body.obj", start.mesh, SurfaceFormat::obj);
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    ChoiceGround on() const { return {ground, none}; }
    int count() const { return ground.start.mesh.num_triangles(); }
    Eigen::Vector3d vertex(int t, int k) const {
        return ground.start.mesh.vertices.row(ground.start.mesh.triangles(t, k)).transpose();
    }
    /// All three vertices fulfil `inside`.
    template <class Inside>
    std::vector<char> those(const Inside& inside) const {
        std::vector<char> marks;
        for (int t = 0; t < count(); ++t)
            marks.push_back(inside(vertex(t, 0)) && inside(vertex(t, 1)) && inside(vertex(t, 2)));
        return marks;
    }

    /// Describes, writes the case, reads it as `strake check` does, and compares. Returns the kind.
    std::string kind_of(const std::vector<ChoiceStep>& steps, const std::vector<char>& marks) {
        const Description words = described(on(), steps, marks, "mine", "mine-triangles.txt");
        std::string yaml = "surface: {file: body.obj}\nobjective: {maximize: volume}\n";
        for (const RegionText& region : words.regions) yaml = with_region(yaml, region);
        std::ofstream list(folder / "mine-triangles.txt");
        for (const int number : words.numbers) list << number << "\n";
        list.close();
        const Case read = load_case_text(yaml, folder / "case.yaml");
        RegionSets sets(read.regions, ground.start, ground.tree);
        std::vector<char> again(marks.size(), 0);
        for (std::size_t k = 0; k < read.regions.size(); ++k)
            if (read.regions[k].name == "mine")
                for (const int t : sets.triangles(static_cast<int>(k))) again[static_cast<std::size_t>(t)] = 1;
        EXPECT_EQ(again, marks) << yaml;
        return words.kind;
    }
    std::string kind_of(const std::vector<ChoiceStep>& steps) { return kind_of(steps, chosen(on(), steps)); }
};

TEST_F(Choices, PlanesAndBoxesHoldWhatTheirVerticesSay) {
    const ChoiceStep plane{Combine::add, HalfSpace{{0, 0, 1}, 1.2, false}};
    EXPECT_EQ(chosen(on(), {plane}), those([](const auto& x) { return x[2] <= 1.2; }));
    EXPECT_EQ(kind_of({plane}), "plane");
    const ChoiceStep box{Combine::add, BoxShape{{-1, -1, -1}, {0.6, 3, 1.1}}};
    EXPECT_EQ(chosen(on(), {box}), those([](const auto& x) { return x[0] <= 0.6 && x[2] <= 1.1; }));
    EXPECT_EQ(kind_of({box}), "box");
    const ChoiceStep oblique{Combine::add, HalfSpace{Eigen::Vector3d(1, 2, 3).normalized(), 1, true}};
    EXPECT_EQ(kind_of({oblique}), "plane");
    const ChoiceStep nowhere{Combine::add, HalfSpace{{0, 0, 1}, 100, true}};
    EXPECT_EQ(chosen(on(), {nowhere}), std::vector<char>(static_cast<std::size_t>(count()), 0))
        << "no error while it is dragged";
    EXPECT_THROW(described(on(), {nowhere}, chosen(on(), {nowhere}), "mine", "list"), InvalidInput);
}

TEST_F(Choices, StepsCombineInTheirOrder) {
    const std::vector<ChoiceStep> steps{{Combine::add, SolidShape{"first"}},
                                        {Combine::subtract, HalfSpace{{0, 0, 1}, 2, true}},
                                        {Combine::intersect, HalfSpace{{0, 1, 0}, 1, false}},
                                        {Combine::add, ComponentShape{1}}};
    const auto expected = those([](const auto& x) { return x[0] > 2; });
    const auto low = those([](const auto& x) { return x[0] < 2 && x[1] <= 1; });
    const auto high = those([](const auto& x) { return x[0] < 2 && x[2] >= 2; });
    std::vector<char> marks = expected;
    for (std::size_t t = 0; t < marks.size(); ++t) marks[t] = static_cast<char>(expected[t] || (low[t] && !high[t]));
    EXPECT_EQ(chosen(on(), steps), marks);
    EXPECT_EQ(kind_of(steps), "steps");
    const std::vector<ChoiceStep> other{{Combine::add, SolidShape{"first"}}, {Combine::add, InvertChoice{}}};
    EXPECT_EQ(chosen(on(), other), expected);
}

TEST_F(Choices, FloodStopsAtCreases) {
    const ChoiceStep flood{Combine::add, FloodedRegion{{}, {0.5, 1, 3}, 30 * std::numbers::pi / 180}};
    EXPECT_EQ(chosen(on(), {flood}), those([](const auto& x) { return x[2] >= 3 && x[0] < 2; }));
    const ChoiceStep all{Combine::add, FloodedRegion{{}, {0.5, 1, 3}, std::numbers::pi}};
    EXPECT_EQ(chosen(on(), {all}), those([](const auto& x) { return x[0] < 2; }));
}

TEST_F(Choices, ShortestWordsFirst) {
    const std::size_t n = static_cast<std::size_t>(count());
    EXPECT_EQ(kind_of({{Combine::add, PickedAll{}}}), "whole surface");
    EXPECT_EQ(kind_of({{Combine::add, ComponentShape{0}}}), "part") << "the file names it";
    // However triangles were chosen, the words depend on which they are.
    const auto list_of = [&](const std::vector<char>& marks) {
        PickedTriangles picked;
        for (std::size_t t = 0; t < n; ++t)
            if (marks[t]) picked.triangles.push_back(static_cast<int>(t));
        return std::vector<ChoiceStep>{{Combine::add, picked}};
    };
    EXPECT_EQ(kind_of(list_of(those([](const auto& x) { return x[2] <= 1.2; }))), "plane");
    EXPECT_EQ(kind_of(list_of(those([](const auto& x) { return x[2] <= 1.2 && x[0] < 2 && x[1] <= 1.5; }))), "box");
    const auto& level = ground.tree.levels[2].patches;
    ASSERT_GE(level.size(), 4u);
    EXPECT_EQ(kind_of({{Combine::add, PatchShape{level[0].name}}}), "patch");
    std::vector<char> crumbs(n, 0);
    for (std::size_t t = 0; t < n; t += 7) crumbs[t] = 1;
    EXPECT_EQ(kind_of(list_of(crumbs)), "list of triangles");
    EXPECT_THROW(chosen(on(), {{Combine::add, PickedTriangles{{count()}}}}), InvalidInput);
    EXPECT_THROW(chosen(on(), {{Combine::add, PatchShape{"p99"}}}), InvalidInput);
}

TEST_F(Choices, EveryPairOfPatchesIsSaidTruly) {
    const auto& patches = ground.tree.levels.back().patches;
    for (std::size_t a = 0; a < patches.size(); a += 5)
        for (std::size_t b = a + 1; b < patches.size(); b += 7) {
            const std::string kind =
                kind_of({{Combine::add, PatchShape{patches[a].name}}, {Combine::add, PatchShape{patches[b].name}}});
            EXPECT_TRUE(kind == "patches" || kind == "box" || kind == "plane" || kind == "patch") << kind;
        }
}

TEST_F(Choices, GrowsAsTheCaseDoes) {
    const std::vector<ChoiceStep> steps{{Combine::add, HalfSpace{{0, 0, 1}, 0.6, false}},
                                        {Combine::add, GrowChoice{0.5}}};
    const auto marks = chosen(on(), steps);
    EXPECT_EQ(kind_of(steps, marks), "plane") << "shorter than the steps that led there";
    EXPECT_EQ(marks, those([](const auto& x) { return x[2] <= 1.0; })) << "one more row of triangles, 0.5 high";
    const auto back = chosen(on(), {steps[0], {Combine::add, GrowChoice{-0.5}}});
    EXPECT_LT(std::count(back.begin(), back.end(), 1), std::count(marks.begin(), marks.end(), 1));
}

TEST_F(Choices, MirrorImagesComeAlong) {
    // Mirror images of each other: the two boxes, about x = 2.5; each of them, about y = 1.
    const ChoiceStep low{Combine::add, HalfSpace{{0, 0, 1}, 1.2, false}},
        first{Combine::intersect, SolidShape{"first"}};
    const auto both = chosen(on(), {low, first, {Combine::add, MirrorChoice{{{1, 0, 0}, 2.5}}}});
    EXPECT_EQ(both, those([](const auto& x) { return x[2] <= 1.2; }));
    const ChoiceStep side{Combine::add, HalfSpace{{0, 1, 0}, 0.5, false}};
    const auto sides = chosen(on(), {side, {Combine::add, MirrorChoice{{{0, 1, 0}, 1}}}});
    const auto left = those([](const auto&x) { return x[1] <= 0.5; }),
               right = those([](const auto&x) { return x[1] >= 1.5; });
    std::vector<char> expected = left;
    for (std::size_t t = 0; t < expected.size(); ++t) expected[t] = static_cast<char>(left[t] || right[t]);
    EXPECT_EQ(sides, expected);
    EXPECT_EQ(chosen(on(), {side, {Combine::add, MirrorChoice{{{1, 0, 0}, 9}}}}), left) << "nothing lies there";
    EXPECT_EQ(chosen(on(), {{Combine::add, MirrorChoice{{{1, 0, 0}, 2.5}}}}),
              std::vector<char>(static_cast<std::size_t>(count()), 0));
}

TEST_F(Choices, ListsNeedTheNumbersOfTheFile) {
    PickedTriangles crumbs{{0, 7, 31}};
    const std::vector<ChoiceStep> steps{{Combine::add, crumbs}};
    const auto marks = chosen(on(), steps);
    ground.start.source_triangle.assign(static_cast<std::size_t>(count()), 0);
    for (int t = 0; t < count(); ++t) ground.start.source_triangle[static_cast<std::size_t>(t)] = t + 5;
    EXPECT_EQ(described(on(), steps, marks, "mine", "list").numbers, (std::vector<int>{5, 12, 36}));
    ground.start.source_triangle[7] = -1;
    EXPECT_THROW(described(on(), steps, marks, "mine", "list"), InvalidInput);
    ground.start.is_remeshed = true;
    EXPECT_THROW(described(on(), steps, marks, "mine", "list"), InvalidInput);
}

TEST(ShortestNumber, LiesBetweenAndIsShort) {
    EXPECT_EQ(shortest_between(0.21, 0.44), "0.3");
    EXPECT_EQ(shortest_between(-0.1, 0.4), "0");
    EXPECT_EQ(shortest_between(1.23, 1.27), "1.23");
    EXPECT_EQ(shortest_between(-7.9, -3.2), "-4");
    EXPECT_EQ(shortest_between(121.0, 180.0), "130");
    EXPECT_EQ(shortest_between(0.1 + 0.2, 0.1 + 0.2), "0.30000000000000004");
    for (double low = -3; low < 3; low += 0.0371)
        for (const double width : {1e-12, 1e-3, 0.5}) {
            const double value = std::stod(shortest_between(low, low + width));
            EXPECT_GE(value, low);
            EXPECT_LE(value, low + width);
        }
}

}  // namespace
}  // namespace strake
