#include "core/wrap/wrap.hpp"

#include "cases/geometry/dirty_body.hpp"
#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/topology.hpp"
#include "core/wrap/alpha_wrap.hpp"
#include "core/wrap/wrap_binding.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

TriMesh half_open(const TriMesh& mesh, double above) {
    const Points c = triangle_centroids(mesh);
    TriMesh out = mesh;
    int count = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (c(t, 2) < above) out.triangles.row(count++) = mesh.triangles.row(t);
    out.triangles.conservativeResize(count, 3);
    return out;
}

}  // namespace

TEST(Wrap, CapsCloseEachOpenBorder) {
    int caps = -1;
    EXPECT_EQ(with_caps(icosphere(2), caps).num_triangles(), icosphere(2).num_triangles());
    EXPECT_EQ(caps, 0);
    const TriMesh open = half_open(icosphere(3), 0.8), closed = with_caps(open, caps);
    EXPECT_EQ(caps, 1);
    EXPECT_TRUE(topology(open, adjacency(open)).boundary_loops.size() == 1);
    EXPECT_TRUE(topology(closed, adjacency(closed)).boundary_loops.empty());
    EXPECT_EQ(closed.vertices.topRows(open.num_vertices()), open.vertices);
}

TEST(Wrap, IsClosedEvenAndOutside) {
    if (!has_alpha_wrap()) GTEST_SKIP() << "built without the alpha wrap (-DSTRAKE_GPL=OFF)";
    for (const char* kind : {"wing_through_body", "holes", "crossing_cylinders", "gaps"}) {
        const TriMesh body = example::dirty_body(kind);
        const Wrap wrap = wrap_around(body);
        const Adjacency adjacent = adjacency(wrap.mesh);
        const TopologyFacts facts = topology(wrap.mesh, adjacent);
        EXPECT_TRUE(facts.closed) << kind;
        EXPECT_EQ(facts.components, 1) << kind;
        EXPECT_TRUE(self_intersections(wrap.mesh).empty()) << kind;
        EXPECT_LE(wrap.genus, 12) << kind;
        // The 5th percentile of 2 inradius over circumradius.
        std::vector<double> quality;
        const Points angles = corner_angles(wrap.mesh);
        for (int t = 0; t < wrap.mesh.num_triangles(); ++t) {
            double sines = 1;
            for (int k = 0; k < 3; ++k) sines *= std::sin(angles(t, k) / 2);
            quality.push_back(8 * sines);
        }
        std::nth_element(quality.begin(), quality.begin() + quality.size() / 20, quality.end());
        EXPECT_GT(quality[quality.size() / 20], 0.75) << kind;
        const ClosestPointTree near(body);
        double farthest = 0;
        for (int v = 0; v < wrap.mesh.num_vertices(); ++v)
            farthest = std::max(farthest, near.find(wrap.mesh.vertices.row(v)).distance);
        EXPECT_LT(farthest, 3 * wrap.alpha) << kind;
    }
}

TEST(Wrap, CarriesADirtyBodyThroughABend) {
    if (!has_alpha_wrap()) GTEST_SKIP() << "built without the alpha wrap (-DSTRAKE_GPL=OFF)";
    for (const char* kind : {"wing_through_body", "flipped_parts"}) {
        const TriMesh body = example::dirty_body(kind);
        const Wrap wrap = wrap_around(body);
        const WrapBinding binding(wrap.mesh, body.vertices);
        const auto bent = [](const Points& x) {
            Points u = Points::Zero(x.rows(), 3);
            u.col(2) = 0.05 * x.col(0).array().square();
            return u;
        };
        const Points off = binding.displacement(bent(wrap.mesh.vertices)) - bent(body.vertices);
        EXPECT_LT(off.rowwise().norm().maxCoeff(), 2e-4 * box_diagonal(body)) << kind;
    }
}

TEST(Wrap, TakesACoarserSecondTryWhereTimeIsShort) {
    if (!has_alpha_wrap()) GTEST_SKIP() << "built without the alpha wrap (-DSTRAKE_GPL=OFF)";
    WrapOptions options;
    options.max_seconds = 1e-9;
    try {
        wrap_around(example::dirty_body("crossing_boxes"), options);
        FAIL() << "no wrap in a nanosecond";
    } catch (const InvalidInput& refused) {
        const std::string words = refused.what();
        EXPECT_NE(words.find("takes longer than 1e-09 s of CPU"), std::string::npos) << words;
        EXPECT_NE(words.find("shell: none"), std::string::npos) << words;
        std::size_t tries = 0;
        for (std::size_t at = 0; (at = words.find("takes longer", at)) != std::string::npos; ++at) ++tries;
        EXPECT_EQ(tries, 3u) << words;
    }
}

TEST(Wrap, WrongOptionsAreRefused) {
    WrapOptions options;
    options.alpha = -1;
    EXPECT_THROW(validate(options), InvalidInput);
    options = {};
    options.max_seconds = 0;
    EXPECT_THROW(validate(options), InvalidInput);
    EXPECT_THROW(wrap_around(TriMesh{}), InvalidInput);
}

TEST(Wrap, ABuildWithoutItSaysSo) {
    if (has_alpha_wrap()) GTEST_SKIP() << "built with the alpha wrap";
    try {
        wrap_around(icosphere(2));
        FAIL();
    } catch (const InvalidInput& refused) {
        EXPECT_NE(std::string(refused.what()).find("STRAKE_GPL"), std::string::npos);
    }
}
