#include "core/mesh/surface_map.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/local_gradient.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <cstring>
#include <functional>
#include <random>

/// The map from a surface to other points: exact on the surface, smooth beside it, and with an exact transpose.
namespace strake {
namespace {

Points random_points(Eigen::Index n, unsigned seed, double size = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-size, size);
    Points points(n, 3);
    for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = number(random);
    return points;
}

Points stacked(const Points& a, const Points& b) {
    Points all(a.rows() + b.rows(), 3);
    all << a, b;
    return all;
}

/// Bends and twists: a displacement that is smooth and nowhere rigid.
Points bent(const Points& x, double size) {
    Points u(x.rows(), 3);
    for (Eigen::Index v = 0; v < x.rows(); ++v)
        u.row(v) << size * x(v, 0) * x(v, 2), 0.3 * size * x(v, 1) * x(v, 0), size * x(v, 0) * x(v, 0);
    return u;
}

double inner(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

/// x >= 0 of an ellipsoid, with vertices on the plane x = 0.
TriMesh half_ellipsoid() {
    TriMesh box = box_surface({1, 2, 2}, 6), half;
    std::vector<int> kept;
    for (int t = 0; t < box.num_triangles(); ++t) {
        bool on_plane = true;
        for (int k = 0; k < 3; ++k) on_plane &= box.vertices(box.triangles(t, k), 0) < 1e-12;
        if (!on_plane) kept.push_back(t);
    }
    half.vertices = box.vertices.rowwise() - Eigen::RowVector3d(0, 1, 1);
    for (Eigen::Index v = 0; v < half.vertices.rows(); ++v) {  // the box's faces blown up to a sphere
        const double height = half.vertices.row(v).cwiseAbs().maxCoeff();
        if (height > 0) half.vertices.row(v) *= height / half.vertices.row(v).norm();
    }
    half.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
    for (std::size_t t = 0; t < kept.size(); ++t)
        half.triangles.row(static_cast<Eigen::Index>(t)) = box.triangles.row(kept[t]);
    return half;
}

TEST(LocalRotationTest, GivesTheRotationOfARigidMotionAndTransposesIt) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 2);
    const LocalRotation rotation(mesh);
    const Eigen::RowVector3d w(0.3, -0.2, 0.5);
    Points u(mesh.num_vertices(), 3);
    for (int v = 0; v < mesh.num_vertices(); ++v)
        u.row(v) = w.cross(Eigen::RowVector3d(mesh.vertices.row(v))) + Eigen::RowVector3d(1, 2, 3);
    EXPECT_LT((rotation.apply(u).rowwise() - w).cwiseAbs().maxCoeff(), 1e-12);
    const Points a = random_points(mesh.num_vertices(), 1), g = random_points(mesh.num_vertices(), 2);
    EXPECT_NEAR(inner(g, rotation.apply(a)), inner(rotation.transpose(g), a), 1e-11);
}

TEST(SurfaceMapTest, PointsThatAreVerticesGetTheirBits) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    const Points other = renumbered(mesh, 3).vertices;
    const Points vertices = mesh.vertices + bent(mesh.vertices, 0.1);
    const Points moved = SurfaceMap(mesh, other).moved(vertices);
    const Points expected = renumbered(with_vertices(mesh, vertices), 3).vertices;
    EXPECT_EQ(std::memcmp(moved.data(), expected.data(), sizeof(double) * expected.size()), 0);
}

/// Along a flat surface every affine displacement, also of points of its triangles.
TEST(SurfaceMapTest, StretchedAndShearedPlatesKeepThePlacesOfTheirPoints) {
    const TriMesh plate = strip(2, 1, 7, 5);
    const TriMesh fine = refined(refined(plate));
    Eigen::Matrix3d A;
    A << 0.3, -0.2, 0, 0.1, 0.4, 0, 0.2, -0.1, 0;
    const Points u = plate.vertices * A.transpose(), expected = fine.vertices * A.transpose();
    EXPECT_LT((SurfaceMap(plate, fine.vertices).apply(u) - expected).cwiseAbs().maxCoeff(), 1e-12);
}

/// The largest error at the vertices of a sphere with four times the triangles, in the largest displacement.
double carried_error(int subdivisions, const std::function<Points(const Points&)>& field) {
    const TriMesh mesh = icosphere(subdivisions), fine = icosphere(subdivisions + 1);
    const Points wanted = field(fine.vertices);
    const Points got = SurfaceMap(mesh, fine.vertices).apply(field(mesh.vertices));
    return (got - wanted).rowwise().norm().maxCoeff() / wanted.rowwise().norm().maxCoeff();
}

/// Straight lines between the vertices would be six times worse, at 1 280 triangles.
TEST(SurfaceMapTest, AFinerSurfaceIsCarriedSmoothly) {
    const auto bend = [](const Points& x) { return bent(x, 1); };
    const auto inflate = [](const Points& x) { return Points(0.1 * x); };
    const auto wave = [](const Points& x) {
        Points u = Points::Zero(x.rows(), 3);
        u.col(2) = (3 * x.col(0)).array().sin();
        return u;
    };
    EXPECT_LT(carried_error(3, bend), 2e-3);
    EXPECT_LT(carried_error(3, inflate), 7e-4);
    EXPECT_LT(carried_error(3, wave), 4e-3);
    EXPECT_LT(carried_error(4, bend), carried_error(3, bend) / 3.5);
    EXPECT_LT(carried_error(4, wave), carried_error(3, wave) / 3.5);
}

TEST(LocalGradientTest, IsThatOfARigidMotionAndTransposes) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 2);
    const LocalGradient gradient(mesh);
    Eigen::Matrix3d W;
    W << 0, -0.5, -0.2, 0.5, 0, -0.3, 0.2, 0.3, 0;
    const Points u = (mesh.vertices * W.transpose()).rowwise() + Eigen::RowVector3d(1, 2, 3);
    const Gradients got = gradient.apply(u);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = W;
    for (Eigen::Index v = 0; v < got.rows(); ++v)
        EXPECT_LT((got.row(v) - Eigen::Map<const Gradients>(rows.data(), 1, 9)).cwiseAbs().maxCoeff(), 1e-12);
    const Points a = random_points(mesh.num_vertices(), 1);
    Gradients g(mesh.num_vertices(), 9);
    const Points numbers = random_points(3 * g.rows(), 2);
    std::copy(numbers.data(), numbers.data() + numbers.size(), g.data());
    EXPECT_NEAR(g.cwiseProduct(gradient.apply(a)).sum(), inner(gradient.transpose(g), a), 1e-11);
}

TEST(SurfaceMapTest, TransposeIsExact) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    const Points points = stacked(random_points(400, 4, 1.5), mesh.vertices * 1.01);
    const SurfaceMap map(mesh, points);
    const Points u = random_points(mesh.num_vertices(), 5), g = random_points(points.rows(), 6);
    const double forward = inner(g, map.apply(u)), back = inner(map.transpose(g), u);
    EXPECT_NEAR(forward, back, 1e-12 * g.norm() * map.apply(u).norm());
    EXPECT_GT(std::abs(forward), 1e-3);
}

TEST(SurfaceMapTest, SmallRigidMotionsAreCarriedExactlyWithinTheReach) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    const Points points = random_points(300, 7, 2);
    const SurfaceMap map(mesh, points, {1e5, {}});
    const Eigen::RowVector3d w(0.3, -0.2, 0.5), t(1, 2, 3);
    const auto rigid = [&](const Points& x) {
        Points u(x.rows(), 3);
        for (Eigen::Index i = 0; i < x.rows(); ++i) u.row(i) = w.cross(Eigen::RowVector3d(x.row(i))) + t;
        return u;
    };
    EXPECT_LT((map.apply(rigid(mesh.vertices)) - rigid(points)).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(SurfaceMapTest, NothingMovesBeyondTheReach) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 2);
    Points points(2, 3);
    points << 0, 0, 0.4 + 0.51 * box_diagonal(mesh), 0, 0, 0.4 + 0.3 * box_diagonal(mesh);
    const Points u = SurfaceMap(mesh, points, {0.5, {}}).apply(bent(mesh.vertices, 1));
    EXPECT_EQ(u.row(0).norm(), 0);
    EXPECT_GT(u.row(1).norm(), 0);
}

/// Largest |u(a) - u(b)| / |a - b| over neighbours on a line of `count` points.
double steepest(const TriMesh& mesh, const Points& u, const Eigen::RowVector3d& from, const Eigen::RowVector3d& to,
                int count) {
    Points line(count, 3);
    for (int i = 0; i < count; ++i) line.row(i) = from + (to - from) * i / (count - 1.0);
    const Points moved = SurfaceMap(mesh, line).apply(u);
    return (moved.bottomRows(count - 1) - moved.topRows(count - 1)).rowwise().norm().maxCoeff() /
           ((to - from).norm() / (count - 1));
}

TEST(SurfaceMapTest, HasNoJumpsOutside) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    const Points u = bent(mesh.vertices, 0.2);
    const Eigen::RowVector3d a(-1.7, 0.35, 0.5), b(1.6, -0.4, 0.45), c(0.1, 0.2, 0.38), d(0.3, 0.1, 3);
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{c, d}}) {
        const double coarse = steepest(mesh, u, from, to, 501), fine = steepest(mesh, u, from, to, 50001);
        EXPECT_LT(coarse, 1.5);
        EXPECT_LT(fine, 1.1 * coarse + 0.05) << "a jump would be a hundred times steeper";
    }
}

/// Layers of prisms on the surface, from a thousandth of an edge to a diagonal away, none turned over.
TEST(SurfaceMapTest, CellsAroundABodyThatBendsKeepTheirVolume) {
    const TriMesh mesh = ellipsoid({1, 0.3, 0.2}, 3);
    Points normals = Points::Zero(mesh.num_vertices(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) normals.row(mesh.triangles(t, k)) += area_vector(mesh, t).transpose();
    normals.rowwise().normalize();
    Points points = mesh.vertices;
    double height = 1e-4;
    for (int layer = 0; layer < 30; ++layer, height *= 1.35)
        points = stacked(points, Points(points.bottomRows(mesh.num_vertices()) + height * normals));
    const Points u = bent(mesh.vertices, 0.15);
    const Points moved = SurfaceMap(mesh, points).moved(mesh.vertices + u);
    const int n = mesh.num_vertices();
    const auto volume = [&](const Points& x, int layer, int t, int k) {  // a corner of a prism
        const auto at = [&](int level, int corner) {
            return Eigen::Vector3d(x.row((layer + level) * n + mesh.triangles(t, corner % 3)));
        };
        return (at(0, k + 1) - at(0, k)).cross(at(0, k + 2) - at(0, k)).dot(at(1, k) - at(0, k));
    };
    double worst = 1;
    for (int layer = 0; layer < 30; ++layer)
        for (int t = 0; t < mesh.num_triangles(); ++t)
            for (int k = 0; k < 3; ++k)
                worst = std::min(worst, volume(moved, layer, t, k) / volume(points, layer, t, k));
    EXPECT_GT(worst, 0.4);
}

TEST(SurfaceMapTest, HalfABodyMovesAsTheWholeOneAndLeavesThePlaneWhereItIs) {
    const TriMesh half = half_ellipsoid();
    SurfaceMapOptions options;
    options.symmetry = SymmetryPlane{Eigen::Vector3d::UnitX(), 0};
    Points points = random_points(300, 8, 1.5);
    points.col(0) = points.col(0).cwiseAbs();
    points.topRows(100).col(0).setZero();
    const SurfaceMap map(half, points, options);
    Points u = random_points(half.num_vertices(), 9, 0.1);
    for (int v = 0; v < half.num_vertices(); ++v)
        if (half.vertices(v, 0) < 1e-12) u(v, 0) = 0;
    const Points moved = map.apply(u);
    EXPECT_EQ(moved.topRows(100).col(0).cwiseAbs().maxCoeff(), 0);
    EXPECT_GT(moved.topRows(100).cwiseAbs().maxCoeff(), 0.001);
    Points mirrored = points;
    mirrored.col(0) *= -1;
    Points image = SurfaceMap(half, mirrored, options).apply(u);
    image.col(0) *= -1;
    EXPECT_LT((image - moved).cwiseAbs().maxCoeff(), 1e-12);
    const Points g = random_points(points.rows(), 10);
    EXPECT_NEAR(inner(g, moved), inner(map.transpose(g), u), 1e-12);
}

TEST(SurfaceMapTest, AThinMeshOfVeryUnequalTrianglesIsCovered) {
    TriMesh mesh = strip(1, 1, 40, 3);
    for (int v = 0; v < mesh.num_vertices(); ++v) mesh.vertices(v, 0) = std::pow(mesh.vertices(v, 0), 6);
    const Points points = stacked(random_points(200, 11, 1), mesh.vertices);
    const Points one = Points::Ones(mesh.num_vertices(), 3);
    const Points u = SurfaceMap(mesh, points, {1e5, {}}).apply(one);
    EXPECT_LT((u.array() - 1).abs().maxCoeff(), 1e-7);
}

TEST(SurfaceMapTest, RefusesWhatIsNoSurfaceOrNoPoint) {
    const TriMesh mesh = icosphere(1);
    Points points = Points::Zero(2, 3);
    EXPECT_THROW(SurfaceMap(mesh, points, {0, {}}), InvalidInput);
    EXPECT_THROW(SurfaceMap(with_vertices(mesh, 0 * mesh.vertices), points), InvalidInput);
    EXPECT_THROW(SurfaceMap(mesh, points).apply(points), InvalidInput);
    EXPECT_THROW(SurfaceMap(mesh, points).transpose(mesh.vertices), InvalidInput);
    points(1, 2) = std::nan("");
    EXPECT_THROW(SurfaceMap(mesh, points), InvalidInput);
    EXPECT_EQ(SurfaceMap(mesh, Points(0, 3)).moved(mesh.vertices).rows(), 0);
}

}  // namespace
}  // namespace strake
