#include "objectives/geometry/thickness.hpp"

#include "ask.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

std::vector<ThicknessLine> spars() {
    return {
        {{0.1, 0.2, 0.05}, {0, 0, 1}, 0.5}, {{-0.3, 0.1, 0}, {0.1, 0.2, 2}, 0.7}, {{0.2, -0.1, 9}, {0, 0.02, 1}, 0.6}};
}

}  // namespace

TEST(Thickness, ClosedForms) {
    const TriMesh box = box_surface({2, 3, 4}, 3);
    const std::vector<ThicknessLine> lines{{{0.7, 0.8, 1}, {0, 0, 3}, {}}, {{1, 1, 1}, {0, 1, 1}, {}}};
    const Quantity each = thickness("spars", box, lines, ThicknessValues::each);
    EXPECT_EQ(each.names, (std::vector<std::string>{"spars.1", "spars.2"}));
    EXPECT_NEAR(value(each, box, 0), 4, 1e-13);
    EXPECT_NEAR(value(each, box, 1), 3 * std::sqrt(2.0), 1e-13);
    const Quantity least = thickness("spars", box, lines, ThicknessValues::smallest);
    EXPECT_EQ(least.names, std::vector<std::string>{"spars"});
    EXPECT_NEAR(value(least, box), 4, 1e-13);
    EXPECT_FALSE(least.residuals);
    const TriMesh sphere = icosphere(5);
    EXPECT_NEAR(value(thickness("t", sphere, {{{0.6, 0, 0}, {0, 0, 1}, {}}}, ThicknessValues::each), sphere), 1.6,
                1e-3);
}

TEST(Thickness, LinesThroughVerticesAndEdgesMeetEachPlaceOnce) {
    const TriMesh box = box_surface({2, 2, 2}, 2);  // a vertex in the middle of every side
    for (const Eigen::Vector3d& at : {Eigen::Vector3d(1, 1, 0.5), Eigen::Vector3d(1, 0.5, 0.5)})
        EXPECT_NEAR(value(thickness("t", box, {{at, {0, 0, 1}, {}}}, ThicknessValues::each), box), 2, 1e-13);
}

TEST(Thickness, CrossingsOnEitherSideOfThePointCount) {
    TriMesh two = box_surface(), upper = moved(box_surface(), 2, {0, 0, 5});
    const int n = two.num_vertices();
    two.vertices.conservativeResize(2 * n, 3);
    two.vertices.bottomRows(n) = upper.vertices;
    const int m = two.num_triangles();
    two.triangles.conservativeResize(2 * m, 3);
    two.triangles.bottomRows(m) = upper.triangles.array() + n;
    const auto at = [&](double z) {
        return value(thickness("t", two, {{{0.3, 0.4, z}, {0, 0, 1}, {}}}, ThicknessValues::each), two);
    };
    EXPECT_NEAR(at(0.5), 1, 1e-13);
    EXPECT_NEAR(at(6), 2, 1e-13);
    EXPECT_NEAR(at(-3), 1, 1e-13);
    EXPECT_NEAR(at(99), 2, 1e-13);
}

TEST(Thickness, DerivativesAreExact) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    const Quantity each = thickness("spars", mesh, spars(), ThicknessValues::each);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(order(each, mesh, 1, i), 2, 0.1) << i;
        EXPECT_NEAR(order(each, mesh, 2, i), 1, 0.1) << i;
    }
    EXPECT_NEAR(order(thickness("s", mesh, spars(), ThicknessValues::smallest), mesh), 2, 0.1);
    EXPECT_NEAR(residual_order(each, mesh, 1), 2, 0.1);
    EXPECT_NEAR(residual_order(each, mesh, 2), 1, 0.1);
    const Residuals at = each.residuals(mesh, mesh);
    EXPECT_NEAR(at.r[0], (value(each, mesh, 0) - 0.5) / std::sqrt(3.0), 1e-14);
}

TEST(Thickness, ScalesIgnoresTranslationAndRefinement) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 2);
    const Quantity each = thickness("spars", mesh, spars(), ThicknessValues::each);
    auto far = spars();
    for (ThicknessLine& line : far) line.at = 100 * line.at + Eigen::Vector3d(5, -3, 1);
    const TriMesh other = moved(mesh, 100, {5, -3, 1});
    const Quantity scaled = thickness("spars", other, far, ThicknessValues::each),
                   fine = thickness("spars", refined(mesh), spars(), ThicknessValues::each);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(value(scaled, other, i), 100 * value(each, mesh, i), 1e-10);
        EXPECT_NEAR(value(fine, refined(mesh), i), value(each, mesh, i), 1e-13);
    }
}

TEST(Thickness, MissesAndWrongLinesAreRefusedWithTheirRow) {
    const TriMesh box = box_surface();
    const auto make = [&](ThicknessLine line) {
        return refusal([&] { thickness("spars", box, {line}, ThicknessValues::each); });
    };
    EXPECT_TRUE(has(make({{5, 5, 5}, {0, 0, 1}, {}, 7}), "spars: line 1 (row 7 of the file)"));
    EXPECT_TRUE(has(make({{5, 5, 5}, {0, 0, 1}, {}, 7}), "crosses the surface nowhere"));
    EXPECT_TRUE(has(make({{0, 0, 0}, {0, 0, 0}, {}, 7}), "length zero"));
    EXPECT_TRUE(has(make({{0, 0, 0}, {0, NAN, 0}, {}, 7}), "not finite"));
    EXPECT_THROW(thickness("spars", box, {}, ThicknessValues::each), InvalidInput);
    TriMesh sheet = strip(2, 2, 2, 2);
    EXPECT_TRUE(has(refusal([&] {
                        thickness("spars", sheet, {{{0.7, 0.6, 0}, {0, 0, 1}, {}}}, ThicknessValues::each);
                    }),
                    "only once"));
    const Quantity spar = thickness("spars", box, {{{0.5, 0.4, 0.5}, {0, 0, 1}, 1}}, ThicknessValues::each);
    const TriMesh away = moved(box, 1, {5, 0, 0});
    ASSERT_TRUE(ask(spar, away).failure);
    EXPECT_EQ(ask(spar, away).failure->kind, "undefined");
    EXPECT_THROW(spar.residuals(away, away), InvalidInput);
    const TemporaryFile file("t.csv", "x,y,z,dx,dy,dz\n0,0,0,0,0,1\n0,0,0,0,0,0\n");
    EXPECT_TRUE(has(refusal([&] { read_thickness_lines(file.path); }), "t.csv:3: the direction has length zero"));
    const TemporaryFile few("u.csv", "0,0,0,0,0\n");
    EXPECT_TRUE(
        has(refusal([&] { read_thickness_lines(few.path); }), ":1: 5 numbers; expected x,y,z,dx,dy,dz,[target]"));
}
