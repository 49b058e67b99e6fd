#include "core/repair/repair.hpp"

#include "core/error.hpp"
#include "core/mesh/weld.hpp"
#include "defective.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <numeric>

namespace strake {
namespace {

using namespace defective;

RepairOptions everything(const TriMesh& mesh) { return all_repairs(box_diagonal(mesh)); }

void expect_same_bits(const TriMesh& a, const TriMesh& b) {
    ASSERT_EQ(a.num_vertices(), b.num_vertices());
    ASSERT_EQ(a.num_triangles(), b.num_triangles());
    EXPECT_TRUE(a.vertices == b.vertices);
    EXPECT_TRUE(a.triangles == b.triangles);
    EXPECT_EQ(a.group, b.group);
    EXPECT_EQ(a.group_names, b.group_names);
}

/// One of each kind of defect, far enough from each other.
TriMesh battered() {
    TriMesh mesh = without(icosphere(3), [](int t) { return t == 100 || t == 101 || t == 900; });
    mesh = turned(mesh, [](int t) { return t == 500 || t == 501; });
    add_triangle(mesh, mesh.triangles(700, 0), mesh.triangles(700, 1), mesh.triangles(700, 2));
    mesh = joined(mesh, moved(with_cap(icosphere(2)), {3, 0, 0}));
    mesh = joined(mesh, moved(cracked(icosphere(2), 1e-6), {0, 3, 0}));
    mesh = joined(mesh, moved(turned(icosphere(1), [](int) { return true; }), {0, 0, 3}));
    mesh = joined(mesh, moved(unwelded(icosphere(1)), {3, 3, 0}));
    return mesh;
}

TEST(Repair, ACleanSurfaceKeepsItsBits) {
    for (TriMesh mesh : {icosphere(3), box_surface({1, 2, 3}, 3), capped_cylinder(24, 6), strip(2, 1, 8, 4)}) {
        mesh.group_names = {"one", "two"};
        for (int t = 0; t < mesh.num_triangles(); ++t) mesh.group.push_back(t % 2);
        RepairOptions options = everything(mesh);
        options.min_area_share = 0.01;
        if (mesh.num_vertices() == 45) options.holes.reset();  // the strip's rim is no hole
        const RepairResult result = repair(mesh, options);
        expect_same_bits(result.mesh, mesh);
        EXPECT_TRUE(result.items.empty());
        std::vector<int> own(static_cast<std::size_t>(mesh.num_triangles()));
        std::iota(own.begin(), own.end(), 0);
        EXPECT_EQ(result.source_triangle, own);
    }
}

TEST(Repair, EverythingAtOnceLeavesClosedComponents) {
    const RepairResult result = repair(battered(), everything(battered()));
    EXPECT_TRUE(result.after.facts.closed);
    EXPECT_EQ(result.after.facts.components, 5);
    EXPECT_TRUE(result.remaining.empty()) << result.remaining[0];
    EXPECT_EQ(result.count(RepairKind::hole), 3);
    EXPECT_EQ(result.count(RepairKind::duplicate), 1);
    EXPECT_EQ(result.count(RepairKind::degenerate), 1);
    EXPECT_EQ(result.after.inward_components, 0);
}

TEST(Repair, DoneTwiceChangesNothing) {
    for (const HoleFill fill : {HoleFill::planar, HoleFill::smooth}) {
        RepairOptions options = everything(battered());
        options.fill = fill;
        const TriMesh once = repair(battered(), options).mesh;
        expect_same_bits(repair(once, options).mesh, once);
    }
}

TEST(Repair, WhatIsNotAskedForStays) {
    const TriMesh mesh = battered();
    RepairOptions options;
    options.orient = true;
    const RepairResult result = repair(mesh, options);
    EXPECT_TRUE(result.mesh.vertices == mesh.vertices);
    ASSERT_EQ(result.mesh.num_triangles(), mesh.num_triangles());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        std::array<int, 3> a{mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)};
        std::array<int, 3> b{result.mesh.triangles(t, 0), result.mesh.triangles(t, 1), result.mesh.triangles(t, 2)};
        std::sort(a.begin(), a.end());
        std::sort(b.begin(), b.end());
        EXPECT_EQ(a, b);
    }
    EXPECT_EQ(result.before.facts.boundary_loops.size(), result.after.facts.boundary_loops.size());
}

TEST(Repair, ATriangleWithACornerTwiceIsPartedOnce) {
    TriMesh mesh = box_surface();
    mesh.triangles.conservativeResize(14, 3);
    mesh.triangles.bottomRows(2) << 3, 3, 7, 5, 5, 5;
    RepairOptions options;
    options.split = true;
    const TriMesh once = repair(mesh, options).mesh;
    EXPECT_EQ(repair(once, options).items.size(), 0u);
    for (int i = 0; i < mesh.triangles.size(); ++i)
        EXPECT_EQ(once.vertices.row(once.triangles.data()[i]), mesh.vertices.row(mesh.triangles.data()[i]));
}

TEST(Repair, CountsDoNotDependOnPlaceScaleAndNumbering) {
    const TriMesh mesh = battered();
    const RepairResult plain = repair(mesh, everything(mesh));
    TriMesh far = mesh;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    far.vertices = ((1e6 * mesh.vertices) * turn.transpose()).rowwise() + Eigen::RowVector3d(3e6, -1e6, 2e6);
    TriMesh small = mesh;
    small.vertices *= 0x1p-30;
    for (const TriMesh& other : {far, small, renumbered(mesh, 5)}) {
        const RepairResult result = repair(other, everything(other));
        for (int k = 0; k <= static_cast<int>(RepairKind::isolated); ++k)
            if (const auto kind = static_cast<RepairKind>(k); kind != RepairKind::weld && kind != RepairKind::crack) {
                EXPECT_EQ(result.count(kind), plain.count(kind)) << name_of(kind);
            }
        EXPECT_EQ(result.mesh.num_triangles(), plain.mesh.num_triangles());
        EXPECT_EQ(result.mesh.num_vertices(), plain.mesh.num_vertices());
        EXPECT_TRUE(result.after.facts.closed);
    }
}

TEST(Repair, WeldsWithinTheToleranceOnly) {
    TriMesh mesh = cracked(icosphere(2), 1e-3);
    RepairOptions options;
    options.weld = 0.9e-3;
    EXPECT_EQ(repair(mesh, options).count(RepairKind::weld), 0);
    options.weld = 1.1e-3;
    const RepairResult result = repair(mesh, options);
    EXPECT_TRUE(result.after.facts.closed);
    for (const RepairItem& item : result.items) EXPECT_NEAR(item.size, 1e-3, 1e-12);
    EXPECT_TRUE(result.mesh.vertices == icosphere(2).vertices);  // the smaller number stays where it is
}

TEST(Repair, ASmoothFillGoesOnWithTheCurvature) {
    const TriMesh ball = icosphere(4);
    const TriMesh open = without(ball, [&](int t) { return centroid(ball, t).z() > 0.85; });
    RepairOptions options;
    options.holes = std::numeric_limits<double>::infinity();
    const double flat_volume = repair(open, options).after.volume;
    options.fill = HoleFill::smooth;
    const RepairResult result = repair(open, options);
    ASSERT_TRUE(result.after.facts.closed);
    ASSERT_GT(result.mesh.num_vertices(), open.num_vertices() + 50);
    for (int v = ball.num_vertices(); v < result.mesh.num_vertices(); ++v)
        EXPECT_NEAR(result.mesh.vertices.row(v).norm(), 1, 0.02);
    const double whole = enclosed_volume(ball);
    EXPECT_LT(std::abs(result.after.volume - whole), 0.1 * (whole - flat_volume));
    EXPECT_GT(surface_quality(result.mesh, result.after.adjacent).angle_min_deg, 15);
    EXPECT_TRUE(result.after.pairs->apart.empty());
}

TEST(Repair, AFlatHoleIsFilledInItsPlane) {
    const TriMesh box = box_surface({1, 1, 1}, 8);
    std::vector<int> group;
    TriMesh open = without(box, [&](int t) {
        return std::abs(centroid(box, t).z() - 1) < 1e-12 && std::abs(centroid(box, t).x() - 0.5) < 0.3;
    });
    open.group_names = {"sides", "top"};
    for (int t = 0; t < open.num_triangles(); ++t) open.group.push_back(centroid(open, t).z() > 0.999);
    RepairOptions options;
    options.holes = 10;
    const RepairResult result = repair(open, options);
    EXPECT_TRUE(result.after.facts.closed);
    EXPECT_NEAR(result.after.volume, 1, 1e-14);
    EXPECT_NEAR(result.after.area, 6, 1e-13);
    EXPECT_TRUE(result.after.facts.degenerate_triangles.empty());
    for (int t = 0; t < result.mesh.num_triangles(); ++t)
        if (result.source_triangle[t] < 0) {
            EXPECT_EQ(result.mesh.group[t], 1);
        }
}

TEST(Repair, AFlatSheetIsNotClosedByItsOwnBack) {
    RepairOptions options;
    options.holes = 100;
    for (const HoleFill how : {HoleFill::planar, HoleFill::smooth}) {
        options.fill = how;
        const TriMesh sheet = strip(2, 1, 6, 4);
        const RepairResult result = repair(sheet, options);
        expect_same_bits(result.mesh, sheet);
        ASSERT_FALSE(result.remaining.empty());
        EXPECT_NE(result.remaining[0].find("lie back to back"), std::string::npos) << result.remaining[0];
        // A hole inside of it is one.
        const Eigen::Vector3d inside(2.5 / 3, 0.375, 0);
        const RepairResult framed =
            repair(without(sheet, [&](int t) { return (centroid(sheet, t) - inside).norm() < 0.15; }), options);
        EXPECT_EQ(framed.count(RepairKind::hole), 1);
        EXPECT_EQ(framed.after.facts.boundary_loops.size(), 1u);
    }
}

TEST(Repair, CracksAreNotClosedToASurfaceOfOneSide) {
    // A band turned half around, its ends a hair apart; with and without a vertex in the middle of one of them.
    const TriMesh moebius = twisted_band(24, 1);
    for (const bool has_junction : {false, true}) {
        TriMesh band = moebius;
        band.vertices.conservativeResize(50, 3);
        for (int k = 0; k < 2; ++k)
            band.vertices.row(48 + k) = moebius.vertices.row(k) + Eigen::RowVector3d(1e-7, -1e-7, 1e-7);
        for (int t = 0; t < 2; ++t)
            for (int k = 0; k < 3; ++k)
                if (band.triangles(t, k) < 2) band.triangles(t, k) += 48;
        if (has_junction) {
            band.vertices.conservativeResize(51, 3);
            band.vertices.row(50) = 0.5 * (band.vertices.row(48) + band.vertices.row(49));
            const int apex = band.triangles(0, 1);
            band.triangles.row(0) << 48, apex, 50;
            add_triangle(band, apex, 49, 50);
        }
        RepairOptions options;
        options.cracks = 1e-5;
        options.orient = true;
        ASSERT_TRUE(checkup(band).facts.orientable);
        const RepairResult result = repair(band, options);
        EXPECT_TRUE(result.after.facts.orientable);
        EXPECT_TRUE(result.after.facts.misoriented_edges.empty());
        // Turned once more, the sides agree and are joined.
        TriMesh plain = twisted_band(24, 2);
        plain.vertices.conservativeResize(50, 3);
        for (int k = 0; k < 2; ++k) plain.vertices.row(48 + k) = plain.vertices.row(k);
        for (int t = 0; t < 2; ++t)
            for (int k = 0; k < 3; ++k)
                if (plain.triangles(t, k) < 2) plain.triangles(t, k) += 48;
        EXPECT_EQ(repair(plain, options).after.facts.boundary_loops.size(), 2u);
    }
}

TEST(Repair, HalfModelsKeepTheirCut) {
    const TriMesh ball = icosphere(3);
    const TriMesh half = without(box_surface({1, 1, 1}, 4), [](int t) { return t < 32; });
    RepairOptions options = everything(half);
    options.holes = 100;
    const RepairResult kept = repair(half, options);
    EXPECT_EQ(kept.after.facts.boundary_loops.size(), 1u);
    options.keep_symmetry_loops = false;
    EXPECT_TRUE(repair(half, options).after.facts.closed);
    const TriMesh inward = turned(half, [](int) { return true; });
    EXPECT_EQ(repair(inward, everything(inward)).count(RepairKind::orient), 1);  // a flat lid would close it
}

TEST(Repair, AStatedPlaneOfSymmetryIsNeitherClosedNorTold) {
    const TriMesh half = without(box_surface({1, 1, 1}, 4), [](int t) { return t < 32; });
    const BoundaryLoop cut = checkup(half).loops.at(0);
    ASSERT_GE(cut.symmetry_axis, 0);
    RepairOptions options;
    options.orient = true;
    const auto told = [&] {
        std::string all;
        for (const std::string& words : repair(half, options).remaining) all += words + "\n";
        return all;
    };
    EXPECT_NE(told().find("1 open loop(s): not requested"), std::string::npos);
    for (const double sign : {1.0, -1.0}) {
        options.symmetry = SymmetryPlane{sign * Eigen::Vector3d::Unit(cut.symmetry_axis), sign * cut.symmetry_at};
        options.holes.reset();
        EXPECT_EQ(told(), "");
        options.holes = 100;
        EXPECT_EQ(repair(half, options).after.facts.boundary_loops.size(), 1U);
    }
    options.symmetry->offset += 0.1;  // another plane: the opening is a hole
    EXPECT_TRUE(repair(half, options).after.facts.closed);
}

TEST(Repair, CommonWallsOfTouchingPartsGo) {
    TriMesh boxes = joined(box_surface({1, 1, 1}, 3), moved(box_surface({1, 1, 1}, 3), {1, 0, 0}));
    RepairOptions options;
    options.weld = 1e-12;
    options.duplicates = true;
    const RepairResult result = repair(boxes, options);
    EXPECT_TRUE(result.after.facts.closed);
    EXPECT_EQ(result.after.facts.components, 1);
    EXPECT_NEAR(result.after.volume, 2, 1e-13);
}

TEST(Repair, ASkinGivenTwiceKeepsOneCopy) {
    const TriMesh ball = icosphere(2);
    for (const bool reversed : {false, true}) {
        TriMesh twice = joined(ball, turned(ball, [&](int) { return reversed; }));
        RepairOptions options;
        options.weld = 0;
        options.duplicates = options.orient = true;
        const RepairResult result = repair(twice, options);
        expect_same_bits(result.mesh, ball);
    }
}

TEST(Repair, DegenerateFansDisappearWithoutOpeningTheSurface) {
    // A box whose top is a fan over many points on one edge: most triangles of the fan have no area.
    TriMesh mesh = box_surface();
    for (int round = 0; round < 6; ++round) mesh = with_cap(mesh);
    RepairOptions options;
    options.degenerate = true;
    const RepairResult result = repair(mesh, options);
    EXPECT_GE(result.before.facts.degenerate_triangles.size(), 6u);
    EXPECT_TRUE(result.after.facts.degenerate_triangles.empty());
    EXPECT_TRUE(result.after.facts.closed);
    EXPECT_NEAR(result.after.volume, 1, 1e-12);
}

/// A polygon with all corners but one on a line, cut into a fan: only from its end can the triangles be taken away.
TEST(Repair, AFanOfThousandsOfDegenerateTrianglesTakesNoTime) {
    TriMesh fan;
    fan.vertices.resize(3002, 3);
    fan.vertices.setZero();
    for (int i = 1; i <= 3000; ++i) fan.vertices(i, 0) = 1 + 1e-4 * i;
    fan.vertices(3001, 1) = 1;
    fan.triangles.resize(3000, 3);
    for (int i = 0; i < 3000; ++i) fan.triangles.row(i) << 0, i + 1, i + 2;
    RepairOptions options;
    options.degenerate = true;
    const RepairResult result = repair(fan, options);
    EXPECT_EQ(result.before.facts.degenerate_triangles.size(), 2999u);
    EXPECT_TRUE(result.after.facts.degenerate_triangles.empty());
    EXPECT_EQ(result.mesh.num_triangles(), 3000);  // the last one, cut at each of the others' corners
    EXPECT_NEAR(result.after.area, result.before.area, 1e-12);
}

/// Each cut the others, and their parts, without end: memory ran out.
TEST(Repair, TrianglesOnOneLineThatShareAnEdgeComeToAnEnd) {
    TriMesh lines;
    lines.vertices.resize(5, 3);
    lines.vertices << 0, 0, 0, 1, 0, 0, -0.22335410130890199, 1.3111809646109797e-14, 2.8082907309268793e-14,
        0.30815780337343401, -1.6473486515965887e-14, 3.3499888698871065e-15, 0.51992625456752994,
        -2.0729181703706456e-14, -1.353088795218628e-14;
    lines.triangles.resize(3, 3);
    lines.triangles << 0, 1, 2, 0, 1, 3, 0, 1, 4;
    // With a body beside them: something is left in any case.
    TriMesh both = box_surface();
    const int n = both.num_vertices(), m = both.num_triangles();
    both.vertices.conservativeResize(n + 5, 3);
    both.vertices.bottomRows(5) = lines.vertices.rowwise() + Eigen::RowVector3d(0, 3, 0);
    both.triangles.conservativeResize(m + 3, 3);
    both.triangles.bottomRows(3) = lines.triangles.array() + n;
    for (const TriMesh& mesh : {lines, both}) {
        RepairOptions options;
        options.degenerate = true;
        try {
            const RepairResult result = repair(mesh, options);
            EXPECT_LE(result.mesh.num_triangles(), mesh.num_triangles() + 9);
            EXPECT_LE(result.after.facts.degenerate_triangles.size(), 9u);
            EXPECT_LE(result.items.size(), 30u);
        } catch (const InvalidInput& none_left) {
            EXPECT_EQ(mesh.num_triangles(), 3) << none_left.what();
        }
    }
}

/// All pairs of so many triangles at an edge are too many.
TEST(Repair, ABookOfThousandsOfPagesTakesNoTime) {
    const int n = 20'000;
    TriMesh book;
    book.vertices.resize(n + 2, 3);
    book.vertices.topRows(2) << 0, 0, 0, 0, 0, 1;
    book.triangles.resize(n, 3);
    for (int t = 0; t < n; ++t) {
        const double angle = 0.7 + 6.2831 * t / n;
        book.vertices.row(t + 2) << std::cos(angle), std::sin(angle), 0.5;
        book.triangles.row(t) << (t % 3 ? 0 : 1), (t % 3 ? 1 : 0), t + 2;
    }
    RepairOptions options;
    options.split = true;
    const auto begin = std::chrono::steady_clock::now();
    const RepairResult result = repair(book, options);
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 20);
    EXPECT_TRUE(result.after.facts.nonmanifold_edges.empty());
}

TEST(Repair, BadOptionsAndSurfacesAreRefused) {
    const TriMesh ball = icosphere(1);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const auto& spoil : std::vector<std::function<void(RepairOptions&)>>{
             [&](RepairOptions& o) { o.weld = -1; }, [&](RepairOptions& o) { o.weld = nan; },
             [&](RepairOptions& o) { o.cracks = 0; }, [&](RepairOptions& o) { o.holes = nan; },
             [&](RepairOptions& o) { o.min_area_share = 1; }, [&](RepairOptions& o) { o.keep_largest = -1; },
             [&](RepairOptions& o) { o.min_triangles = 1000; }}) {
        RepairOptions options;
        spoil(options);
        EXPECT_THROW(repair(ball, options), InvalidInput);
    }
    EXPECT_THROW(repair(TriMesh{}, {}), InvalidInput);
    TriMesh broken = ball;
    broken.triangles(3, 1) = 999;
    EXPECT_THROW(repair(broken, {}), InvalidInput);
    broken = ball;
    broken.vertices(3, 1) = nan;
    EXPECT_THROW(repair(broken, {}), InvalidInput);
}

/// Random triangles between few vertices: everything that can be wrong is.
TEST(Repair, AnythingGoesInAndOneSurfaceComesOut) {
    unsigned state = 1;
    const auto random = [&](int n) { return static_cast<int>((state = state * 1664525u + 1013904223u) >> 8) % n; };
    for (int round = 0; round < 300; ++round) {
        TriMesh mesh;
        const int n = 3 + random(12), m = 1 + random(30);
        for (int v = 0; v < n; ++v) add_vertex(mesh, Eigen::Vector3d(random(4), random(4), random(3)));
        for (int t = 0; t < m; ++t) add_triangle(mesh, random(n), random(n), random(n));
        RepairOptions options = everything(mesh);
        options.holes = 100;
        options.fill = round % 2 ? HoleFill::smooth : HoleFill::planar;
        if (!(box_diagonal(mesh) > 0)) continue;
        try {
            const RepairResult result = repair(mesh, options);
            EXPECT_TRUE(result.mesh.vertices.allFinite());
            EXPECT_EQ(result.source_triangle.size(), static_cast<std::size_t>(result.mesh.num_triangles()));
            EXPECT_TRUE(result.after.facts.duplicate_triangles.empty()) << round;
            EXPECT_TRUE(result.after.facts.isolated_vertices.empty()) << round;
        } catch (const InvalidInput& nothing_left) {
            EXPECT_NE(std::string(nothing_left.what()).find("left"), std::string::npos) << nothing_left.what();
        }
    }
}

}  // namespace
}  // namespace strake
