#include "report/drawing.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "tests/surfaces.hpp"

#include <gtest/gtest.h>
#include <cmath>

namespace strake {
namespace {

Drawing drawn(const TriMesh& mesh, const View& view, int width, int height) {
    const auto m = static_cast<std::size_t>(mesh.num_triangles());
    return draw_surface(mesh, std::vector<Colour>(m, Colour{200, 200, 200}), std::vector<int>(m, 0), view, width,
                        height);
}

TEST(Drawing, PointsAreWhereTheirTrianglesAreDrawn) {
    const TriMesh mesh = icosphere(2);
    const View view{{-1, 0.7, 0.4}, {0, 0, 1}, 0.1};
    const Drawing drawing = drawn(mesh, view, 300, 200);
    const Points centroids = triangle_centroids(mesh), normals = triangle_normals(mesh);
    int seen = 0, hits = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (normals.row(t).dot(view.from.normalized()) < 0.5) continue;  // well inside of what is seen
        const Eigen::Vector2d pixel = drawing.pixel_of(centroids.row(t));
        const auto at =
            static_cast<std::size_t>(std::floor(pixel[1])) * 300 + static_cast<std::size_t>(std::floor(pixel[0]));
        ++seen;
        hits += drawing.triangle[at] == t;
    }
    EXPECT_GT(seen, 50);
    EXPECT_EQ(hits, seen);
}

TEST(Drawing, TheMarginStaysFree) {
    const TriMesh mesh = icosphere(2);
    for (const double margin : {0.0, 0.2, 0.4}) {
        const Drawing drawing = drawn(mesh, {{1, 0, 0}, {0, 0, 1}, margin}, 100, 100);
        int first = 100, last = -1;
        for (int y = 0; y < 100; ++y)
            for (int x = 0; x < 100; ++x)
                if (drawing.triangle[static_cast<std::size_t>(y) * 100 + x] >= 0)
                    first = std::min(first, x), last = std::max(last, x);
        EXPECT_NEAR(first, 100 * margin, 2);
        EXPECT_NEAR(last, 100 * (1 - margin), 2);
    }
    EXPECT_THROW(drawn(mesh, {{1, 0, 0}, {0, 0, 1}, 0.5}, 100, 100), InvalidInput);
}

TEST(Drawing, SignedColoursAreBlueInwardsBrownOutwards) {
    EXPECT_LT(signed_colour(-1)[0], signed_colour(-1)[2]);
    EXPECT_GT(signed_colour(1)[0], signed_colour(1)[2]);
    const Colour zero = signed_colour(0);
    EXPECT_LT(std::abs(zero[0] - zero[2]), 10);
    EXPECT_EQ(signed_colour(7), signed_colour(1));
    EXPECT_EQ(signed_colour(std::nan("")), zero);
}

TEST(Drawing, ArrowsEndWhereTheyPoint) {
    Panel panel{drawn(icosphere(0), {{1, 0, 0}, {0, 0, 1}, 0.2}, 100, 80), "a"};
    panel.arrows.push_back({{10, 20}, {60, 20}, {0, 90, 150}, "right wing"});
    panel.arrows.push_back({{10, 20}, {11, 20}, {190, 80, 0}, "towards the reader"});
    const std::string svg = svg_picture("t", {panel}, {});
    // The panel begins at (20, 78); the head's tip is where the arrow points.
    EXPECT_NE(svg.find("M80.0 98.0L69.0 104.0L69.0 92.0Z"), std::string::npos) << svg;
    EXPECT_NE(svg.find(">right wing</text>"), std::string::npos);
    EXPECT_EQ(svg.find("towards the reader"), std::string::npos);
}

}  // namespace
}  // namespace strake
