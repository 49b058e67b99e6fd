#include "objectives/geometry/wing_values.hpp"

#include "ask.hpp"
#include "tests/core/planform/lofted_wing.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

TriMesh small_wing(bool whole = false) {
    Loft loft;
    loft.blunt = 0.005;
    loft.cells = 8;
    loft.panels = 24;
    return lofted(loft, whole);
}

std::shared_ptr<const Wing> wing_of(const TriMesh& mesh) {
    return std::make_shared<const Wing>(mesh, WingDeclaration{});
}

const std::vector<std::string> all{"area",
                                   "span",
                                   "aspect_ratio",
                                   "taper",
                                   "sweep",
                                   "dihedral",
                                   "mean_chord",
                                   "box_volume",
                                   "chord@0.37",
                                   "twist@0.37",
                                   "thickness_to_chord@0.37",
                                   "camber@0.37",
                                   "leading_edge_radius@0.37",
                                   "trailing_edge_angle@0.37",
                                   "trailing_edge_thickness@0.37",
                                   "thickness@0.37@0.25",
                                   "twist_step@0.2@0.6",
                                   "chord_step@0.2@0.6",
                                   "spar_offset@0.4@0.15",
                                   "sweep@0.2",
                                   "dihedral@0.2"};

}  // namespace

TEST(WingValues, AreNamedAndOfTheWholeWing) {
    const TriMesh half = small_wing(), whole = small_wing(true);
    const Quantity of_half = wing_values("wing", half, wing_of(half), all);
    ASSERT_EQ(of_half.names.size(), all.size());
    EXPECT_EQ(of_half.names[9], "wing.twist@0.37");
    const QuantityResult a = ask(of_half, half), b = ask(wing_values("wing", whole, wing_of(whole), all), whole);
    ASSERT_FALSE(a.failure || b.failure);
    for (std::size_t i = 0; i < all.size(); ++i)
        EXPECT_NEAR(a.values[i], b.values[i], 1e-10 * (1 + std::abs(a.values[i]))) << all[i];
    EXPECT_NEAR(a.values[0], 4.5, 0.03);
    EXPECT_NEAR(a.values[16], -0.032, 1e-4) << "twist falls by 0.08 from root to tip";
    EXPECT_NEAR(a.values[17], -0.2, 1e-3);
    EXPECT_NEAR(a.values[18], 0, 1e-3) << "the edges are straight";
    EXPECT_NEAR(a.values[19], std::atan(1.2 / 3), 1e-4) << "the quarter chord of the only panel";
    EXPECT_NEAR(a.values[20], std::atan(0.3 / 3), 1e-4);
}

TEST(WingValues, ASparIsStraightWhereNoKinkBendsIt) {
    Loft loft;  // the trailing edge has a kink at 40 %
    loft.twist = [](double) { return 0.0; };
    loft.chord = [](double s) { return s < 0.4 ? 1.4 - s : 1 - 0.5 * (s - 0.4); };
    loft.quarter = [&](double s) { return 1.2 * s + 0.25 * loft.chord(s); };
    loft.cells = 20;
    const TriMesh mesh = lofted(loft);
    const auto values =
        ask(wing_values("wing", mesh, wing_of(mesh), {"spar_offset@0.4@0", "spar_offset@0.4@0.6"}), mesh);
    const double last = wing_of(mesh)->place(0, 1), tip = loft.chord(last), on_line = 1.4 + 0.4 / last * (tip - 1.4);
    EXPECT_NEAR(values.values[0], 0, 1e-3) << "the leading edge";
    EXPECT_NEAR(values.values[1], 0.6 * (loft.chord(0.4) - on_line), 1e-3);
    EXPECT_LT(values.values[1], -0.05);
}

TEST(WingValues, GradientsAreExact) {
    const TriMesh mesh = small_wing();
    const Quantity quantity = wing_values("wing", mesh, wing_of(mesh), all);
    const QuantityResult at = ask(quantity, mesh, true);
    ASSERT_EQ(at.dJ_dv.size(), all.size());
    Points way(mesh.num_vertices(), 3);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Eigen::Vector3d x = mesh.vertices.row(v);
        way.row(v) << 0.3 * std::sin(1.1 * x[1] + x[0]) + 0.2 * x[2], 0.1 * x[1] * std::cos(0.7 * x[0]),
            0.3 * std::cos(0.9 * x[1]) * (x[0] + 0.5) + 0.8 * x[2];
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
        const auto J = [&](const Eigen::VectorXd& x) { return value(quantity, with_vertices(mesh, points(x)), i); };
        const Eigen::VectorXd g = flat(at.dJ_dv[i]);
        // Of third order where the second derivative happens to be small; linear in the vertices: round-off.
        const double near = std::abs(J(flat(mesh.vertices + 4e-4 * way)) - at.values[i] - 4e-4 * g.dot(flat(way)));
        if (near > 1e-13) {
            EXPECT_GT(taylor_order(J, flat(mesh.vertices), g, flat(way), 4e-3), 1.8) << all[i];
        }
        EXPECT_NEAR(taylor_order(J, flat(mesh.vertices), 1.2 * g, flat(way), 4e-3), 1, 0.2) << all[i];
    }
    // Only what is asked for.
    QuantityRequest request{mesh, true, 1, 0, {}};
    request.wanted.assign(all.size(), 0);
    request.wanted[2] = 1;
    const QuantityResult one = quantity.evaluate(request);
    EXPECT_EQ(one.dJ_dv[0].rows(), 0);
    EXPECT_EQ(one.dJ_dv[2], at.dJ_dv[2]);
}

/// A flap behind and below the small wing; values of the flap.
TEST(WingValues, GapAndOverlapHaveExactGradients) {
    Loft flap;
    flap.cells = 8;
    flap.panels = 24;
    flap.chord = [](double s) { return 0.25 * (1 - 0.5 * s); };
    flap.quarter = [](double s) { return 1.1 + 0.76 * s; };
    flap.height = [](double s) { return 0.3 * s - 0.06; };
    const TriMesh main = small_wing(), rear = lofted(flap);
    TriMesh mesh;
    mesh.vertices.resize(main.num_vertices() + rear.num_vertices(), 3);
    mesh.vertices << main.vertices, rear.vertices;
    mesh.triangles.resize(main.num_triangles() + rear.num_triangles(), 3);
    mesh.triangles << main.triangles, Triangles(rear.triangles.array() + main.num_vertices());
    WingDeclaration ahead, behind;
    behind.name = "flap";
    for (int t = 0; t < mesh.num_triangles(); ++t) (t < main.num_triangles() ? ahead : behind).triangles.push_back(t);
    WingValueOptions options;
    options.ahead = std::make_shared<const Wing>(mesh, ahead);
    const auto of = std::make_shared<const Wing>(mesh, behind);
    const Quantity quantity = wing_values("flap", mesh, of, {"gap@0.37", "overlap@0.37"}, options);
    const QuantityResult at = ask(quantity, mesh, true);
    ASSERT_FALSE(at.failure);
    Points way(mesh.num_vertices(), 3);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Eigen::Vector3d x = mesh.vertices.row(v);
        way.row(v) << 0.3 * std::sin(1.1 * x[1] + x[0]) + 0.2 * x[2], 0.1 * x[1] * std::cos(0.7 * x[0]),
            0.3 * std::cos(0.9 * x[1]) * (x[0] + 0.5) + 0.8 * x[2];
    }
    for (std::size_t i = 0; i < 2; ++i) {
        const auto J = [&](const Eigen::VectorXd& x) { return value(quantity, with_vertices(mesh, points(x)), i); };
        const Eigen::VectorXd g = flat(at.dJ_dv[i]);
        EXPECT_GT(taylor_order(J, flat(mesh.vertices), g, flat(way), 4e-3), 1.8) << i;
        EXPECT_NEAR(taylor_order(J, flat(mesh.vertices), 1.2 * g, flat(way), 4e-3), 1, 0.2) << i;
    }
    EXPECT_TRUE(has(refusal([&] { wing_values("flap", mesh, of, {"gap@0.5"}); }), "no wing is ahead"));
}

TEST(WingValues, WhatIsNoValueIsRefusedInWords) {
    const auto refused = [](const std::string& name) { return refusal([&] { parse_wing_value(name); }); };
    EXPECT_TRUE(has(refused("twits@0.5"), "did you mean 'twist'?"));
    EXPECT_TRUE(has(refused("twist"), "write 'twist@0.5' with a fraction of the semispan"));
    EXPECT_TRUE(has(refused("area@0.5"), "a value of the whole wing"));
    EXPECT_TRUE(has(refused("twist@1.5"), "'1.5' must be a fraction in [0, 1]"));
    EXPECT_TRUE(has(refused("twist@x"), "must be a fraction"));
    EXPECT_TRUE(has(refused("thickness@0.5"), "fractions of the semispan and of the chord"));
    EXPECT_TRUE(has(refused("twist_step@0.5"), "write 'twist_step@0.2@0.5' with two fractions of the semispan"));
    EXPECT_TRUE(is_angle(parse_wing_value("twist_step@0.1@0.2")));
    EXPECT_TRUE(has(refused("sweep@0.1@0.2"), "write 'sweep@0.5' with a fraction of the semispan"));
    EXPECT_TRUE(is_angle(parse_wing_value("sweep")));
    EXPECT_TRUE(is_angle(parse_wing_value("dihedral@0.3")));
    EXPECT_FALSE(is_angle(parse_wing_value("chord@0")));
    // A surface without the wing: a failure, not a number.
    const TriMesh mesh = small_wing();
    const Quantity quantity = wing_values("wing", mesh, wing_of(mesh), {"area"});
    TriMesh flat = mesh;
    flat.vertices.col(1).setZero();
    ASSERT_TRUE(ask(quantity, flat).failure);
    EXPECT_EQ(ask(quantity, flat).failure->kind, "undefined");
}
