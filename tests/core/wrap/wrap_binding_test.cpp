#include "core/wrap/wrap_binding.hpp"

#include "cases/geometry/closed_body.hpp"
#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/parallel.hpp"
#include "derivatives.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

using namespace strake;

namespace {

using Map = std::function<Eigen::RowVector3d(const Eigen::RowVector3d&)>;

/// A smooth body inside of a somewhat larger one.
struct Pair {
    TriMesh wrap = example::superellipsoid(3000, {{2.04, 0.64, 0.49}, 2.5});
    TriMesh body = example::superellipsoid(6000, {{2, 0.6, 0.45}, 2.5});
};

Points displaced(const Points& x, const Map& u) {
    Points out(x.rows(), 3);
    for (Eigen::Index v = 0; v < x.rows(); ++v) out.row(v) = u(x.row(v));
    return out;
}

Points random_points(Eigen::Index rows, int seed) {
    const Eigen::VectorXd all = random_vector(static_cast<int>(3 * rows), seed);
    return Eigen::Map<const Points>(all.data(), rows, 3);
}

/// Bending of 5 % of the length.
Map bend() {
    return [](const Eigen::RowVector3d& x) { return Eigen::RowVector3d(0, 0, 0.05 * 4 * x[0] * x[0] / 4); };
}
/// Two periods over the length.
Map wave() {
    return
        [](const Eigen::RowVector3d& x) { return Eigen::RowVector3d(0, 0, 0.04 * std::sin(std::numbers::pi * x[0])); };
}

/// Root mean square of the changes of dihedral angles between two positions of one surface, degrees.
double roughness(const TriMesh& mesh, const Points& one, const Points& other) {
    const Adjacency adjacent = adjacency(mesh);
    const Points a = triangle_normals(with_vertices(mesh, one)), b = triangle_normals(with_vertices(mesh, other));
    double sum = 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto sides = adjacent.edge_triangles[e];
        sum += std::pow(dihedral(a.row(sides[0]), a.row(sides[1])) - dihedral(b.row(sides[0]), b.row(sides[1])), 2);
    }
    return std::sqrt(sum / adjacent.num_edges()) * 180 / std::numbers::pi;
}

/// What a binding to the closest triangle does.
Points by_closest_triangle(const TriMesh& wrap, const Points& body, const Points& u) {
    const ClosestPointTree tree(wrap);
    Points out(body.rows(), 3);
    for (Eigen::Index v = 0; v < body.rows(); ++v) {
        const ClosestPoint at = tree.find(body.row(v));
        const Eigen::Vector3d p0 = wrap.vertices.row(wrap.triangles(at.triangle, 0)),
                              p1 = wrap.vertices.row(wrap.triangles(at.triangle, 1)),
                              p2 = wrap.vertices.row(wrap.triangles(at.triangle, 2)), n = (p1 - p0).cross(p2 - p0);
        const double a = (p2 - p1).cross(at.point - p1).dot(n) / n.squaredNorm(),
                     b = (p0 - p2).cross(at.point - p2).dot(n) / n.squaredNorm();
        out.row(v) = a * u.row(wrap.triangles(at.triangle, 0)) + b * u.row(wrap.triangles(at.triangle, 1)) +
                     (1 - a - b) * u.row(wrap.triangles(at.triangle, 2));
    }
    return out;
}

}  // namespace

TEST(WrapBinding, RestIsExactAndAffineMapsAreToRoundOff) {
    const Pair pair;
    const WrapBinding binding(pair.wrap, pair.body.vertices);
    EXPECT_EQ(binding.displacement(Points::Zero(pair.wrap.num_vertices(), 3)),
              Points::Zero(pair.body.num_vertices(), 3));
    const Eigen::Matrix3d A = Eigen::Matrix3d::Random();
    const Eigen::RowVector3d b(3, -1, 2);
    const Map affine = [&](const Eigen::RowVector3d& x) { return Eigen::RowVector3d(x * A + b); };
    const Points moved = binding.displacement(displaced(pair.wrap.vertices, affine));
    EXPECT_LT((moved - displaced(pair.body.vertices, affine)).cwiseAbs().maxCoeff(), 1e-13);  // of lengths up to 5
}

TEST(WrapBinding, TransposeIsExact) {
    const Pair pair;
    std::vector<char> held(static_cast<std::size_t>(pair.body.num_vertices()), 0);
    for (std::size_t v = 0; v < held.size(); v += 3) held[v] = 1;
    for (const bool holds : {false, true}) {
        const WrapBinding binding(pair.wrap, pair.body.vertices, {holds ? held : std::vector<char>{}, 300});
        const Points u = random_points(pair.wrap.num_vertices(), 1), g = random_points(pair.body.num_vertices(), 2);
        const double forward = binding.displacement(u).cwiseProduct(g).sum(),
                     back = binding.transpose(g).cwiseProduct(u).sum();
        const double scale = binding.displacement(u).norm() * g.norm();
        EXPECT_LT(std::abs(forward - back), 1e-10 * scale) << holds;
        EXPECT_GT(std::abs(forward - 1.001 * back), 1e-6 * std::abs(forward)) << "the test can fail";
    }
}

TEST(WrapBinding, SeveralFunctionalsAtOnceAreAsOneAfterTheOther) {
    const Pair pair;
    const WrapBinding binding(pair.wrap, pair.body.vertices, {{}, 100});
    const std::vector<Points> g{random_points(pair.body.num_vertices(), 2), random_points(pair.body.num_vertices(), 3),
                                random_points(pair.body.num_vertices(), 4)};
    const std::vector<Points> all = binding.transpose(g);
    ASSERT_EQ(all.size(), g.size());
    for (std::size_t i = 0; i < g.size(); ++i) {
        const Points one = binding.transpose(g[i]);
        EXPECT_LT((all[i] - one).norm(), 1e-12 * one.norm());
        EXPECT_GT((all[i] - binding.transpose(g[(i + 1) % 3])).norm(), 0.1 * one.norm()) << "the test can fail";
    }
    EXPECT_TRUE(binding.transpose(std::vector<Points>{}).empty());
    EXPECT_THROW(binding.transpose(std::vector<Points>{g[0], Points::Zero(5, 3)}), InvalidInput);
}

/// A body of more than 16 000 vertices, whose radial functions are not kept, and a piece of it, whose are.
TEST(WrapBinding, LargeBodiesMoveAsTheirPieces) {
    const Pair pair;
    const Points large = example::superellipsoid(36000, {{2, 0.6, 0.45}, 2.5}).vertices, piece = large.topRows(3000);
    ASSERT_GT(large.rows() * 500 * 8, 64000000);
    const WrapBinding of_large(pair.wrap, large), of_piece(pair.wrap, piece);
    const Points u = random_points(pair.wrap.num_vertices(), 1), moved = of_large.displacement(u);
    EXPECT_LT((moved.topRows(3000) - of_piece.displacement(u)).norm(), 1e-8 * moved.norm());
    Points g = Points::Zero(large.rows(), 3);
    g.topRows(3000) = random_points(3000, 2);
    const Points back = of_large.transpose(g);
    EXPECT_LT((back - of_piece.transpose(Points(g.topRows(3000)))).norm(), 1e-8 * back.norm());
}

/// Runs that began with the sums of before go on with them: alike, but not to the bit.
TEST(WrapBinding, SumsOfBeforeAreKept) {
    const Pair pair;
    const Points large = example::superellipsoid(36000, {{2, 0.6, 0.45}, 2.5}).vertices;
    const WrapBinding now(pair.wrap, large), before(pair.wrap, large, {{}, 500, {}, RadialSums::by_products});
    const Points u = random_points(pair.wrap.num_vertices(), 1), g = random_points(large.rows(), 2);
    const Points moved = now.displacement(u), back = now.transpose(g);
    EXPECT_LT((moved - before.displacement(u)).norm(), 1e-8 * moved.norm());
    EXPECT_NE(moved, before.displacement(u));
    EXPECT_LT((back - before.transpose(g)).norm(), 1e-8 * back.norm());
    EXPECT_NE(back, before.transpose(g));
    const auto maps = now.local_maps(u, large.topRows(100)), maps_before = before.local_maps(u, large.topRows(100));
    for (std::size_t p = 0; p < maps.size(); ++p)
        EXPECT_LT((maps[p] - maps_before[p]).norm(), 1e-8 * (1 + maps[p].norm()));
}

/// From 100 000 vertices on sums go over boxes, unless a run began otherwise.
TEST(WrapBinding, BoxesMoveVeryLargeBodiesAsCenterByCenter) {
    const Pair pair;
    const Points large = example::superellipsoid(220000, {{2, 0.6, 0.45}, 2.5}).vertices;
    ASSERT_GT(large.rows(), 100000);
    const WrapBinding now(pair.wrap, large), before(pair.wrap, large, {{}, 500, {}, RadialSums::by_centers});
    const Points u = displaced(pair.wrap.vertices, wave()), g = random_points(large.rows(), 2);
    const Points moved = now.displacement(u), moved_before = before.displacement(u);
    EXPECT_NE(moved, moved_before);
    EXPECT_LT((moved - moved_before).cwiseAbs().maxCoeff(), 1e-8 * moved.cwiseAbs().maxCoeff());
    const Points back = now.transpose(g);
    EXPECT_NEAR(moved.cwiseProduct(g).sum(), u.cwiseProduct(back).sum(), 1e-13 * moved.norm() * g.norm());
    EXPECT_GT(std::abs(moved.cwiseProduct(g).sum() - u.cwiseProduct(before.transpose(g)).sum()), 0) << "another map";
    EXPECT_TRUE(now.displacement(Points::Zero(u.rows(), 3)).isZero(0));
    const auto maps = now.local_maps(u, large), maps_before = before.local_maps(u, large);
    for (std::size_t p = 0; p < maps.size(); p += 997) EXPECT_LT((maps[p] - maps_before[p]).norm(), 1e-5);
}

/// However radial functions are added up, and whether they are kept.
TEST(WrapBinding, FunctionalsOfOneVertexHaveTheBitsOfWholeOnes) {
    const Pair pair;
    const auto check = [&](int triangles, RadialSums sums) {
        const Points body = example::superellipsoid(triangles, {{2, 0.6, 0.45}, 2.5}).vertices;
        const auto n = static_cast<int>(body.rows());
        std::vector<char> held(static_cast<std::size_t>(n), 0);
        held[static_cast<std::size_t>(n / 3)] = 1;
        const WrapBinding binding(pair.wrap, body, {held, 500, {}, sums});
        const std::vector<int> vertex{0, n / 3, n / 2, n / 2 + 1, n - 1, n / 2, 17};
        const Points g = random_points(static_cast<Eigen::Index>(vertex.size()), 4);
        std::vector<Points> whole(vertex.size(), Points::Zero(n, 3));
        for (std::size_t i = 0; i < vertex.size(); ++i) whole[i].row(vertex[i]) = g.row(static_cast<Eigen::Index>(i));
        const std::vector<Points> wanted = binding.transpose(whole), back = binding.transpose_at(vertex, g);
        for (std::size_t i = 0; i < vertex.size(); ++i) EXPECT_EQ(back[i], wanted[i]) << n << " " << i;
        EXPECT_GT(back[0].norm(), 0.1);
        EXPECT_TRUE(back[1].isZero(0)) << "it is held";
        EXPECT_THROW(binding.transpose_at({n}, random_points(1, 1)), InvalidInput);
        EXPECT_THROW(binding.transpose_at({0}, g), InvalidInput);
    };
    check(2000, RadialSums::by_boxes);
    check(40000, RadialSums::by_centers);
    check(40000, RadialSums::by_products);
    check(220000, RadialSums::by_boxes);
}

TEST(WrapBinding, CentersAreInterpolatedAndHeldVerticesStay) {
    const Pair pair;
    const WrapBinding ahead(pair.wrap, pair.body.vertices, {{}, 200});
    const Points at_centers = pair.wrap.vertices(ahead.centers(), Eigen::all);
    std::vector<char> held(ahead.centers().size(), 0);
    held[7] = 1;
    const WrapBinding binding(pair.wrap, at_centers, {held, 200});
    const Points u = displaced(pair.wrap.vertices, wave()), moved = binding.displacement(u);
    for (std::size_t c = 0; c < held.size(); ++c) {
        // Beside the interpolation there is the mean of what it leaves of the wrap's own wave.
        EXPECT_LT((moved.row(static_cast<Eigen::Index>(c)) - u.row(ahead.centers()[c])).norm(), held[c] ? 1 : 2e-3);
    }
    EXPECT_TRUE(moved.row(7).isZero(0));
}

TEST(WrapBinding, SmoothMotionsArriveSmoothly) {
    const Pair pair;
    const WrapBinding binding(pair.wrap, pair.body.vertices);
    const double diagonal = box_diagonal(pair.body);
    for (const auto& [motion, off, rough] : {std::tuple(bend(), 2e-4, 0.05), std::tuple(wave(), 1e-3, 0.5)}) {
        const Points u = displaced(pair.wrap.vertices, motion);
        const Points exact = pair.body.vertices + displaced(pair.body.vertices, motion);
        const Points carried = pair.body.vertices + binding.displacement(u);
        EXPECT_LT((carried - exact).rowwise().norm().maxCoeff(), off * diagonal);
        const double own = roughness(pair.body, carried, exact);
        EXPECT_LT(own, rough);
        const Points pasted = pair.body.vertices + by_closest_triangle(pair.wrap, pair.body.vertices, u);
        EXPECT_GT(roughness(pair.body, pasted, exact), 3 * own) << "what the closest triangle would do";
    }
}

/// A thin tail far from the centres: with few of them a motion of second degree is carried badly, and more are taken.
TEST(WrapBinding, BodiesThatAreCarriedBadlyGetMoreCenters) {
    const Pair pair;
    const auto off = [&](const WrapBindingOptions& options) {
        const WrapBinding binding(pair.wrap, pair.body.vertices, options);
        const double farthest =
            (binding.displacement(displaced(pair.wrap.vertices, bend())) - displaced(pair.body.vertices, bend()))
                .rowwise()
                .norm()
                .maxCoeff();
        return std::pair{binding.centers().size(), farthest / box_diagonal(pair.wrap)};
    };
    WrapBindingOptions few;
    few.centers = few.max_centers = 12;
    const auto [kept, badly] = off(few);
    EXPECT_EQ(kept, 12u);
    ASSERT_GT(badly, 2e-4);
    few.max_centers = 30;
    EXPECT_EQ(off(few).first, 30u) << "no more than allowed";
    few.max_centers = 400;
    const auto [more, well] = off(few);
    EXPECT_GT(more, 30u);
    EXPECT_LT(more, 400u) << "no more than needed";
    EXPECT_LT(well, 2e-4);
    EXPECT_EQ(WrapBinding(pair.wrap, pair.wrap.vertices).centers().size(), 500u) << "carried well: no more";
}

TEST(WrapBinding, TurnsAndScalesWithTheBody) {
    const Pair pair;
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    const Points u = displaced(pair.wrap.vertices, wave());
    const Points here = WrapBinding(pair.wrap, pair.body.vertices).displacement(u);
    const auto carried = [&](const Eigen::Matrix3d& turn, double scale) {
        const auto placed = [&](const Points& x) {
            return Points((scale * x * turn.transpose()).rowwise() + scale * Eigen::RowVector3d(5, -3, 1));
        };
        const WrapBinding binding(with_vertices(pair.wrap, placed(pair.wrap.vertices)), placed(pair.body.vertices));
        return Points(binding.displacement(scale * u * turn.transpose()) / scale * turn);
    };
    // Rounding chooses other centers among those that are equally far: as good, by a tenth of what any choice leaves of
    // the wave.
    EXPECT_LT((carried(Eigen::Matrix3d::Identity(), 1024) - here).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_LT((carried(R, 1000) - here).cwiseAbs().maxCoeff(), 1e-4);
    const auto affine = [&](const Points& x) { return Points(0.1 * x * R + 0.05 * x); };
    const WrapBinding binding(pair.wrap, pair.body.vertices);
    EXPECT_LT((binding.displacement(affine(pair.wrap.vertices)) - affine(pair.body.vertices)).cwiseAbs().maxCoeff(),
              1e-12);
}

TEST(WrapBinding, OneAndTwoThreadsGiveTheSameBits) {
    const Pair pair;
    const Points u = displaced(pair.wrap.vertices, wave()), g = random_points(pair.body.num_vertices(), 2);
    Points moved[2], pulled[2];
    for (const int threads : {1, 2}) {
        set_num_threads(threads);
        const WrapBinding binding(pair.wrap, pair.body.vertices, {{}, 150});
        moved[threads - 1] = binding.displacement(u);
        pulled[threads - 1] = binding.transpose(g);
    }
    set_num_threads(0);
    EXPECT_EQ(moved[0], moved[1]);
    EXPECT_EQ(pulled[0], pulled[1]);
}

TEST(WrapBinding, WrongOnesAreRefused) {
    const Pair pair;
    EXPECT_THROW(WrapBinding(TriMesh{}, pair.body.vertices), InvalidInput);
    EXPECT_THROW(WrapBinding(strip(2, 1, 4, 4), pair.body.vertices), InvalidInput) << "in a plane";
    EXPECT_THROW(WrapBinding(pair.wrap, pair.body.vertices, {{1, 0}, 100}), InvalidInput);
    EXPECT_THROW(WrapBinding(pair.wrap, pair.body.vertices, {{}, 3}), InvalidInput);
    Points bad = pair.body.vertices;
    bad(3, 1) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(WrapBinding(pair.wrap, bad), InvalidInput);
    const WrapBinding binding(pair.wrap, pair.body.vertices, {{}, 50});
    EXPECT_THROW(binding.displacement(Points::Zero(3, 3)), InvalidInput);
    EXPECT_THROW(binding.transpose(Points::Zero(3, 3)), InvalidInput);
}
