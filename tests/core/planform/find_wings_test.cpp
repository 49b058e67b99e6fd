#include "core/planform/find_wings.hpp"

#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "surfaces.hpp"
#include "wing_bodies.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace strake {
namespace {

constexpr double degree = std::numbers::pi / 180;

TEST(FindWings, InAnyDirectionOfTheCoordinates) {
    for (const bool whole : {false, true}) {
        const TriMesh mesh = lofted(Loft{}, whole);
        // x, y, z become other axes, and the stream turns round.
        const int orders[][3] = {{0, 1, 2}, {2, 0, 1}, {1, 2, 0}, {0, 2, 1}};
        for (const auto& order : orders)
            for (const double sign : {1.0, -1.0}) {
                TriMesh turned = mesh;
                for (int c = 0; c < 3; ++c) turned.vertices.col(order[c]) = mesh.vertices.col(c) * (c == 0 ? sign : 1);
                if ((order[0] == 0 && order[1] == 2) != (sign < 0))
                    turned.triangles.col(1).swap(turned.triangles.col(2));
                const auto found = find_wing(turned);
                ASSERT_TRUE(found);
                EXPECT_FALSE(found->has_body);
                EXPECT_TRUE(found->declaration.triangles.empty());
                EXPECT_EQ(found->declaration.downstream[order[0]], sign);
                EXPECT_EQ(std::abs(found->declaration.span[order[1]]), 1);
                const WingFacts facts = Wing(turned, found->declaration).facts(turned);
                EXPECT_NEAR(facts.span.value, 6, 0.01);
                EXPECT_NEAR(facts.area.value, 4.5, 0.02);
                EXPECT_NEAR(facts.sweep.value, std::atan(0.4), 0.1 * degree);
            }
    }
}

/// Planes normal to the span cut along a winglet: what is thin and follows on from plane to plane begins inboard of it.
TEST(FindWings, WithAWinglet) {
    const WingBody body = bent_up();
    const auto found = find_wing(body.mesh);
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->has_body);
    EXPECT_EQ(std::abs(found->declaration.span[1]), 1);
    const Wing wing(body.mesh, found->declaration);
    EXPECT_TRUE(wing.has_winglet());
    EXPECT_NEAR(wing.facts(body.mesh).span.value, 2 * body.mesh.vertices.col(1).maxCoeff(), 1e-9);
}

TEST(FindWings, NotOnBodiesWithoutOne) {
    EXPECT_FALSE(find_wing(icosphere(3)));
    EXPECT_FALSE(find_wing(box_surface({4, 4, 0.2}, 6))) << "a plate";
    EXPECT_FALSE(find_wing(ellipsoid({3, 1, 0.6}, 4)));
    EXPECT_FALSE(find_wing(capped_cylinder(24, 10, 0.5, 6)));
    EXPECT_FALSE(find_wing(TriMesh{}));
}

/// A closed body below the wing that spans little of it.
TEST(FindWings, ANacelleIsNoPart) {
    const TriMesh wing = lofted(Loft{});
    TriMesh tank = ellipsoid({0.4, 0.12, 0.12}, 3);
    tank.vertices.rowwise() += Eigen::RowVector3d(0.9, 1.5, -0.05);
    const auto found = find_wing(both(wing, tank));
    ASSERT_TRUE(found);
    ASSERT_EQ(static_cast<int>(found->declaration.triangles.size()), wing.num_triangles());
    EXPECT_EQ(found->declaration.triangles.back(), wing.num_triangles() - 1);
}

/// Half a body, open at y = 0: the span goes to that plane, and the root is where the sections get thick.
TEST(FindWings, BesideHalfABody) {
    Loft loft;
    loft.cells = 12;
    loft.thickness = [](double s) { return s < 0.2 ? 0.14 + 4 * (0.2 - s) : 0.14; };  // a body: thicker than a wing
    const TriMesh mesh = lofted(loft);
    const auto found = find_wing(mesh);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->has_body);
    const Wing wing(mesh, found->declaration);
    EXPECT_NEAR(wing.facts(mesh).span.value, 6, 0.01) << "from tip to tip";
    EXPECT_NEAR(wing.root(0), found->root, 0.03);
}

/// Where no row of vertices follows the joint, triangles that cross its plane belong to the wing: the next row lies far
/// out.
TEST(FindWings, BesideABodyWithoutARowAtTheJoint) {
    Loft loft;
    loft.cells = 12;
    loft.thickness = [](double s) { return s < 0.16 ? 0.14 + 2 * (0.16 - s) : 0.14; };
    TriMesh mesh = lofted(loft);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        double& y = mesh.vertices(v, 1);
        y = y < 0.1 ? 0 : y < 0.3 ? 0.45 : 2 + 0.1 * (y - 0.5) / 0.25;
    }
    const auto found = find_wing(mesh);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->has_body);
    EXPECT_LT(found->root, 0.5);
    EXPECT_NEAR(Wing(mesh, found->declaration).root(0), 0.45, 1e-9) << "not where the next row is: 2";
}

/// Wings from outside (STRAKE_DATA). Their span, area and sweep without sections: extents of the vertices, half of the
/// area that the triangles project onto the plane of span and stream, and the quarter chord of the foremost and aftmost
/// vertices of each slab along the span.
struct Independent {
    double span = 0, area = 0, sweep = 0;
};

/// How much of a triangle lies beyond the plane of the root, by the heights of its corners above it.
double share_beyond(std::array<double, 3> height) {
    std::sort(height.begin(), height.end());
    const auto [a, b, c] = height;
    if (a >= 0 || c <= 0) return a >= 0 ? 1 : 0;
    return b <= 0 ? c / (c - a) * c / (c - b) : 1 - a / (a - b) * a / (a - c);
}

Independent by_vertices(const TriMesh& mesh, const Wing& wing) {
    const WingDeclaration& declared = wing.declaration();
    const int sides = wing.num_sides();
    std::vector<char> is_in(static_cast<std::size_t>(mesh.num_triangles()), declared.triangles.empty());
    for (const int t : declared.triangles) is_in[static_cast<std::size_t>(t)] = 1;
    Independent found;
    double low = 1e300, high = -1e300;
    std::vector<Eigen::Vector2d> points;  // along the span, along the stream
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!is_in[static_cast<std::size_t>(t)]) continue;
        double share = 0;  // each side goes on to its own root
        for (int side = 0; side < sides; ++side) {
            std::array<double, 3> height{};
            for (std::size_t k = 0; k < 3; ++k)
                height[k] =
                    wing.span(side).dot(mesh.vertices.row(mesh.triangles(t, static_cast<int>(k)))) - wing.root(side);
            share += share_beyond(height);
        }
        found.area += 0.5 * share * std::abs(area_vector(mesh, t).dot(declared.up));
        for (const int v : mesh.triangles.row(t)) {
            const Eigen::Vector3d p = mesh.vertices.row(v);
            points.emplace_back(declared.span.dot(p), declared.downstream.dot(p));
            low = std::min(low, points.back()[0]), high = std::max(high, points.back()[0]);
        }
    }
    found.span = (high - low) * (sides == 1 ? 2 : 1);
    if (sides == 1) found.area *= 2;
    const double centre = 0.5 * (low + high), root = sides == 1 ? low : centre;
    // One side is enough; the tip of a half may point either way.
    const bool tip_is_low = sides == 1 && std::abs(low) > std::abs(high);
    constexpr int slabs = 30;
    std::vector<double> fore(slabs, 1e300), aft(slabs, -1e300);
    for (const Eigen::Vector2d& p : points) {
        const double s = tip_is_low ? (high - p[0]) / (high - low) : (p[0] - root) / (high - root);
        const int k = static_cast<int>(s / 0.95 * slabs);
        if (s < 0 || k >= slabs) continue;
        fore[static_cast<std::size_t>(k)] = std::min(fore[static_cast<std::size_t>(k)], p[1]);
        aft[static_cast<std::size_t>(k)] = std::max(aft[static_cast<std::size_t>(k)], p[1]);
    }
    double n = 0, y = 0, x = 0, yy = 0, xy = 0;
    for (int k = 0; k < slabs; ++k) {
        if (fore[static_cast<std::size_t>(k)] > 1e299) continue;
        const double at = (k + 0.5) * 0.95 / slabs * (tip_is_low ? high - low : high - root);
        const double quarter = 0.75 * fore[static_cast<std::size_t>(k)] + 0.25 * aft[static_cast<std::size_t>(k)];
        n += 1, y += at, x += quarter, yy += at * at, xy += at * quarter;
    }
    found.sweep = std::atan((xy - x * y / n) / (yy - y * y / n));
    return found;
}

class WingsFromOutside : public testing::TestWithParam<const char*> {
protected:
    std::optional<TriMesh> mesh() const {
        const char* folder = std::getenv("STRAKE_DATA");
        if (!folder) return {};
        const auto file = std::filesystem::path(folder) / GetParam();
        if (!std::filesystem::exists(file)) return {};
        return read_surface(file).mesh;
    }
};
class BodiesFromOutside : public WingsFromOutside {};

TEST_P(WingsFromOutside, AreFoundWithSpanAreaAndSweep) {
    const auto surface = mesh();
    if (!surface) GTEST_SKIP() << "STRAKE_DATA is not set";  // the surfaces are not ours to ship
    const auto found = find_wing(*surface);
    ASSERT_TRUE(found);
    const Wing wing(*surface, found->declaration);
    const WingFacts facts = wing.facts(*surface);
    const Independent known = by_vertices(*surface, wing);
    EXPECT_NEAR(facts.span.value, known.span, 0.01 * known.span);
    // The projected chord is shorter by the twist: ten degrees on one of them.
    const double shown = std::cos(wing.station(*surface, 0.5).twist.value);
    EXPECT_NEAR(facts.area.value * shown, known.area, 0.01 * known.area);
    // Slabs see the edges of unstructured meshes to within a triangle (0.3 degrees) and smear the kinks of two wings
    // that run into their bodies (2 %).
    EXPECT_NEAR(facts.sweep.value / degree, known.sweep / degree, std::max(0.3, 0.02 * known.sweep / degree));
}
INSTANTIATE_TEST_SUITE_P(All, WingsFromOutside,
                         testing::Values("bwb_machline_medium.vtk", "cessna210_flowpanel.msh", "dpw_w1_pypan.tri",
                                         "oneraM6_pyhyp_small.ply", "oneraM6_pyhyp_small_full.ply",
                                         "oneraM6_su2_surface.stl", "supersonic_wing_body_pypan.stl",
                                         "wing717_pyhyp.ply", "wing_c172_pygeo.stl", "zeroebwb_93k.ply",
                                         "three_element_wing_cpanel.tri"));

TEST_P(BodiesFromOutside, HaveNoWing) {
    const auto surface = mesh();
    if (!surface) GTEST_SKIP() << "STRAKE_DATA is not set";
    EXPECT_FALSE(find_wing(*surface));
}
INSTANTIATE_TEST_SUITE_P(All, BodiesFromOutside,
                         testing::Values("bunny_pmp.off", "cgal_anchor.off", "cgal_elephant-with-holes.off",
                                         "cgal_fandisk_large.off", "cgal_joint.off", "jet_engine_nacelle_machline.stl",
                                         "of_DTC-scaled.stl.gz", "of_wigley.stl.gz", "platonic_shelf_be.ply",
                                         "threeplugs_pynastran.tri", "turbineblade_vtkdata.ply",
                                         "two_objects_mixed_case_trimesh.stl"));

/// Of raw models, by sections that a program of its own made (bench/wings/found_wings.py).
TEST(FindWings, OnRawModelsOfManyParts) {
    const char* folder = std::getenv("STRAKE_DATA");
    if (!folder) GTEST_SKIP() << "STRAKE_DATA is not set";
    const std::tuple<const char*, double, double, double> known[] = {{"citationX_raw.ply", 19.6447, 42.3987, 37.34},
                                                                     {"hsct_pypan.tri", 0.62218, 0.133587, 52.80}};
    for (const auto& [name, span, area, sweep] : known) {
        SCOPED_TRACE(name);
        const auto file = std::filesystem::path(folder) / name;
        if (!std::filesystem::exists(file)) GTEST_SKIP() << name << " is not there";
        const TriMesh mesh = read_surface(file).mesh;
        const auto found = find_wing(mesh);
        ASSERT_TRUE(found);
        const WingFacts facts = Wing(mesh, found->declaration).facts(mesh);
        EXPECT_NEAR(facts.span.value, span, 0.01 * span);
        EXPECT_NEAR(facts.area.value, area, 0.01 * area);
        EXPECT_NEAR(facts.sweep.value / degree, sweep, 0.01 * sweep);
    }
}

// What AGARD AR-138 says of the ONERA M6, and the workshop of its wing W1.
TEST(FindWings, KnowsTheSweepOfTwoPublishedWings) {
    const char* folder = std::getenv("STRAKE_DATA");
    if (!folder) GTEST_SKIP() << "STRAKE_DATA is not set";
    const std::pair<const char*, double> known[] = {{"oneraM6_pyhyp_small.ply", 26.7}, {"dpw_w1_pypan.tri", 15.0}};
    for (const auto& [name, sweep] : known) {
        const auto file = std::filesystem::path(folder) / name;
        if (!std::filesystem::exists(file)) GTEST_SKIP() << name << " is not there";
        const TriMesh mesh = read_surface(file).mesh;
        const auto found = find_wing(mesh);
        ASSERT_TRUE(found) << name;
        EXPECT_NEAR(Wing(mesh, found->declaration).facts(mesh).sweep.value / degree, sweep, 0.01 * sweep) << name;
    }
}

}  // namespace
}  // namespace strake
