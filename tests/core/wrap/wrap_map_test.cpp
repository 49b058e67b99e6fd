#include "core/wrap/wrap_map.hpp"

#include "cases/geometry/dirty_body.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/topology.hpp"
#include "core/patches/carried.hpp"
#include "core/wrap/alpha_wrap.hpp"
#include "core/wrap/halves.hpp"
#include "derivatives.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <numbers>
#include <numeric>

using namespace strake;

namespace {

const SymmetryPlane y_plane{{0, 1, 0}, 0};

Points random_points(Eigen::Index rows, unsigned seed) {
    const Eigen::VectorXd v = random_vector(3 * rows, seed);
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(v.data(), rows, 3);
}

TriMesh half_of(const TriMesh& whole) { return clipped(whole, y_plane, 1e-9); }

/// Displacements of a half that keep it on its plane.
Points on_plane(const TriMesh& half, Points u) {
    for (int v = 0; v < half.num_vertices(); ++v)
        if (half.vertices(v, 1) == 0) u(v, 1) = 0;
    return u;
}

}  // namespace

TEST(WrapMap, ClippingIsExactAndMirroringUndoesIt) {
    TriMesh whole = icosphere(3);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    whole.vertices = whole.vertices * turn.transpose();
    const TriMesh half = half_of(whole);
    const Adjacency adjacent = adjacency(half);
    double border = 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (adjacent.edge_triangles[e].size() != 1) continue;
        for (const int v : adjacent.edges[e]) EXPECT_EQ(half.vertices(v, 1), 0);
        border += (half.vertices.row(adjacent.edges[e][0]) - half.vertices.row(adjacent.edges[e][1])).norm();
    }
    EXPECT_NEAR(border, 2 * std::numbers::pi, 0.02);
    EXPECT_GE(half.vertices.col(1).minCoeff(), 0);
    EXPECT_NEAR(surface_area(half), surface_area(whole) / 2, 1e-3);
    const BothHalves both = with_mirror_image(half, y_plane, 0);
    EXPECT_TRUE(topology(both.mesh, adjacency(both.mesh)).closed);
    EXPECT_NEAR(enclosed_volume(both.mesh), enclosed_volume(whole), 1e-3);
    for (int v = 0; v < both.mesh.num_vertices(); ++v) {
        const int other = both.image[static_cast<std::size_t>(v)];
        EXPECT_EQ(both.image[static_cast<std::size_t>(other)], v);
        EXPECT_EQ(both.mesh.vertices.row(other), mirrored_point(y_plane, both.mesh.vertices.row(v)));
    }
}

TEST(WrapMap, TheTransposeIsExactOfWholesAndHalves) {
    const TriMesh body = icosphere(2);
    TriMesh around = icosphere(2);
    around.vertices *= 1.15;
    std::vector<char> held(static_cast<std::size_t>(body.num_vertices()), 0);
    held[3] = held[7] = 1;
    const WrapMap whole(around, body, {held});
    const TriMesh half_body = half_of(body), half_around = half_of(around);
    const WrapMap half(half_around, half_body, {{}, y_plane, true});
    const auto check = [](const WrapMap& map, Eigen::Index rows) {
        const Points u = random_points(map.mesh().num_vertices(), 3), g = random_points(rows, 5);
        const double one = map.displacement(u).cwiseProduct(g).sum(), other = u.cwiseProduct(map.transpose(g)).sum();
        EXPECT_NEAR(one, other, 1e-9 * u.norm() * g.norm());
        EXPECT_TRUE((map.displacement(Points::Zero(u.rows(), 3)).array() == 0).all()) << "the bits of the rest";
        std::vector<int> all(static_cast<std::size_t>(rows));
        std::iota(all.begin(), all.end(), 0);
        std::vector<Points> one_each(all.size(), Points::Zero(rows, 3));
        for (std::size_t v = 0; v < all.size(); ++v) one_each[v].row(all[v]) = g.row(all[v]);
        EXPECT_EQ(map.transpose_at(all, g), map.transpose(one_each)) << "of one vertex each, also on the plane";
    };
    check(whole, body.num_vertices());
    check(half, half_body.num_vertices());
    EXPECT_TRUE(whole.displacement(random_points(around.num_vertices(), 4)).row(7).isZero(0));
}

TEST(WrapMap, AHalfMovesAsTheWholeDoes) {
    TriMesh around = icosphere(2);
    around.vertices *= 1.15;
    const TriMesh half_body = half_of(icosphere(2)), half_around = half_of(around);
    const BothHalves body = with_mirror_image(half_body, y_plane, 0), wrap = with_mirror_image(half_around, y_plane, 0);
    const WrapMap half(half_around, half_body, {{}, y_plane, true});
    const WrapMap whole(wrap.mesh, body.mesh, {{}, y_plane, false});
    const Points u = on_plane(half_around, random_points(half_around.num_vertices(), 3));
    Points both(wrap.mesh.num_vertices(), 3);
    both.topRows(u.rows()) = u;
    for (Eigen::Index v = u.rows(); v < both.rows(); ++v)
        both.row(v) = mirrored_vector(y_plane, u.row(wrap.image[static_cast<std::size_t>(v)]));
    const Points by_half = half.displacement(u), by_whole = whole.displacement(both);
    EXPECT_LT((by_whole.topRows(by_half.rows()) - by_half).cwiseAbs().maxCoeff(), 1e-8);
    for (int v = 0; v < half_body.num_vertices(); ++v)
        if (half_body.vertices(v, 1) == 0) {
            EXPECT_EQ(by_half(v, 1), 0);
        }
    // Symmetric motions move the whole symmetrically.
    for (int v = 0; v < body.mesh.num_vertices(); ++v)
        EXPECT_LT(
            (by_whole.row(body.image[static_cast<std::size_t>(v)]) - mirrored_vector(y_plane, by_whole.row(v))).norm(),
            1e-8);
    EXPECT_THROW(WrapMap(around, icosphere(2), {{}, SymmetryPlane{{0, 1, 0}, 0.3}, false}), InvalidInput);
}

TEST(WrapMap, LocalMapsAreGradientsOfTheMotion) {
    const TriMesh body = icosphere(3);
    TriMesh around = icosphere(3);
    around.vertices *= 1.1;
    const WrapMap map(around, body);
    Eigen::Matrix3d F;
    F << 1.1, 0.2, 0, -0.1, 0.9, 0.1, 0.05, 0, 1.2;
    const Points affine = around.vertices * (F - Eigen::Matrix3d::Identity()).transpose();
    for (const Eigen::Matrix3d& local : map.local_maps(affine)) EXPECT_LT((local - F).norm(), 1e-10);
    std::vector<Eigen::Matrix3d> maps_of_both(static_cast<std::size_t>(body.num_triangles()), F);
    map.add_to_maps(affine, maps_of_both);
    for (const Eigen::Matrix3d& both : maps_of_both)
        EXPECT_LT((both - (2 * F - Eigen::Matrix3d::Identity())).norm(), 1e-10);
    maps_of_both.pop_back();
    EXPECT_THROW(map.add_to_maps(affine, maps_of_both), InvalidInput);
    const auto bent = [](const Points& x) {
        Points u = Points::Zero(x.rows(), 3);
        u.col(2) = 0.2 * x.col(0).array().square();
        return u;
    };
    // Deep inside, where the local part has faded out, they are the derivatives of the displacement itself.
    const Points at = 0.15 * random_points(8, 3);
    constexpr double h = 1e-4;
    Points beside(6 * at.rows(), 3);
    for (Eigen::Index p = 0; p < at.rows(); ++p)
        for (int k = 0; k < 6; ++k)
            beside.row(6 * p + k) = at.row(p) + (k < 3 ? h : -h) * Eigen::RowVector3d::Unit(k % 3);
    const WrapBinding binding(around, beside);
    const Points u = bent(around.vertices), moved = binding.displacement(u);
    const std::vector<Eigen::Matrix3d> maps = binding.local_maps(u, at);
    for (Eigen::Index p = 0; p < at.rows(); ++p) {
        Eigen::Matrix3d wanted = Eigen::Matrix3d::Identity();
        for (int k = 0; k < 3; ++k)
            wanted.col(k) += (moved.row(6 * p + k) - moved.row(6 * p + 3 + k)).transpose() / (2 * h);
        EXPECT_LT((maps[static_cast<std::size_t>(p)] - wanted).norm(), 1e-6);
        EXPECT_GT((maps[static_cast<std::size_t>(p)] - Eigen::Matrix3d::Identity()).norm(), 1e-3);
    }
    WrapMapOptions all;
    all.held.assign(static_cast<std::size_t>(body.num_vertices()), 1);
    for (const Eigen::Matrix3d& local : WrapMap(around, body, all).local_maps(affine)) EXPECT_TRUE(local.isIdentity(0));
}

TEST(WrapMap, RegionsAndPatchesAreCarriedOver) {
    const TriMesh body = icosphere(3);
    TriMesh around = icosphere(2);
    around.vertices *= 1.1;
    const WrapMap map(around, body);
    const Points c = triangle_centroids(body), w = triangle_centroids(around);
    std::vector<int> above;
    for (int t = 0; t < body.num_triangles(); ++t)
        if (c(t, 2) > 0) above.push_back(t);
    for (const int t : map.carried(above)) EXPECT_GT(w(t, 2), -0.1);
    EXPECT_NEAR(static_cast<double>(map.carried(above).size()), around.num_triangles() / 2.0, 30);
    EXPECT_EQ(map.carried({above[0]}).size(), 1u) << "of a list that is not empty never none";
    EXPECT_TRUE(map.carried({}).empty());
    std::vector<int> label(static_cast<std::size_t>(around.num_triangles()));
    for (std::size_t t = 0; t < label.size(); ++t) label[t] = w(static_cast<Eigen::Index>(t), 0) > 0;
    PatchLevel level;
    level.label = label;
    level.patches.resize(2);
    level.patches[1].id = 1;
    const PatchHierarchy tree = carried(PatchHierarchy{{level}}, map.wrap_triangle(), body);
    EXPECT_EQ(tree.levels[0].label, carried(label, map.wrap_triangle()));
    EXPECT_NEAR(tree.levels[0].patches[0].area, surface_area(body) / 2, 0.5);
    EXPECT_NEAR(tree.levels[0].patches[0].area + tree.levels[0].patches[1].area, surface_area(body), 1e-9);
}

TEST(WrapMap, SaysWhereTheBodyIsThinnerThanAlpha) {
    const TriMesh thick = ellipsoid({1, 1, 1}, 3), thin = ellipsoid({1, 1, 0.02}, 3);
    TriMesh around = icosphere(3);
    around.vertices *= 1.3;
    EXPECT_EQ(thinner_than(thick, around, 0.2).share, 0);
    EXPECT_GT(thinner_than(thin, around, 0.2).share, 0.8);
    TriMesh flipped = thin;
    flipped.triangles.col(1).swap(flipped.triangles.col(2));
    EXPECT_GT(thinner_than(flipped, around, 0.2).share, 0.8) << "whichever way its triangles are turned";
}

TEST(Wrap, OfAHalfEndsOnItsPlane) {
    if (!has_alpha_wrap()) GTEST_SKIP() << "built without the alpha wrap (-DSTRAKE_GPL=OFF)";
    const TriMesh half = half_of(example::dirty_body("crossing_cylinders"));
    WrapOptions options;
    options.plane = SymmetryPlane{{0, -1, 0}, 0};  // whichever way its normal shows
    options.is_half = true;
    const Wrap wrap = wrap_around(half, options);
    const Adjacency adjacent = adjacency(wrap.mesh);
    int open = 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (adjacent.edge_triangles[e].size() != 1) continue;
        ++open;
        for (const int v : adjacent.edges[e]) EXPECT_EQ(wrap.mesh.vertices(v, 1), 0);
    }
    EXPECT_GT(open, 10);
    EXPECT_GE(wrap.mesh.vertices.col(1).minCoeff(), 0) << "on the side of the body";
    options.is_half = false;
    const Wrap whole = wrap_around(example::dirty_body("crossing_cylinders"), options);
    EXPECT_TRUE(topology(whole.mesh, adjacency(whole.mesh)).closed);
    EXPECT_NO_THROW(WrapMap(whole.mesh, example::dirty_body("crossing_cylinders"), {{}, options.plane, false}));
}
