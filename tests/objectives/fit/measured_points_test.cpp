#include "objectives/fit/measured_points.hpp"

#include "ask.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// Points around an ellipsoid, inside and outside.
std::vector<MeasuredPoint> cloud(int count) {
    std::vector<MeasuredPoint> found;
    const Eigen::VectorXd r = random_vector(3 * count, 3);
    for (int i = 0; i < count; ++i) {
        const Eigen::Vector3d direction = Eigen::Vector3d(r.segment<3>(3 * i)).normalized();
        found.push_back({(1 + 0.2 * r[3 * i]) * direction, 1.5 + r[3 * i + 1]});
    }
    return found;
}

}  // namespace

TEST(MeasuredPoints, FaceEdgeAndCornerOfABoxWithTheSignOfTheSide) {
    const TriMesh box = box_surface();
    const std::vector<MeasuredPoint> measured{
        {{0.4, 0.3, 1.5}}, {{0.4, 0.3, 0.9}}, {{0.4, 1.3, 1.4}}, {{1.2, 1.4, 1.4}, 3}};
    const Quantity points = measured_points("scan", box, measured);
    const Residuals at = points.residuals(box, box);
    const double wanted[] = {0.5, -0.1, 0.5, 0.6};
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(at.r[i], std::sqrt((i < 3 ? 1 : 3) / 6.0) * wanted[i], 1e-14) << i;
    EXPECT_NEAR(value(points, box), (0.25 + 0.01 + 0.25 + 3 * 0.36) / 6, 1e-14);
}

TEST(MeasuredPoints, DerivativesAreExact) {
    const TriMesh mesh = ellipsoid({1, 1.1, 0.9}, 2);
    const Quantity scan = measured_points("scan", mesh, cloud(200));
    EXPECT_NEAR(order(scan, mesh, 1, 0, 1e-4), 2, 0.1);
    EXPECT_NEAR(order(scan, mesh, 2, 0, 1e-4), 1, 0.1);
    EXPECT_NEAR(residual_order(scan, mesh, 1, 1e-4), 2, 0.2);
    EXPECT_NEAR(residual_order(scan, mesh, 2, 1e-4), 1, 0.1);
}

TEST(MeasuredPoints, APointOnTheSurfaceHasTheNormalAsDerivative) {
    const TriMesh box = box_surface();
    const Quantity scan = measured_points("scan", box, {{{0.4, 0.3, 1}}, {{1, 0.5, 1}}, {{1, 1, 1}}});
    const Residuals at = scan.residuals(box, box);
    EXPECT_LT(at.r.norm(), 1e-14);
    for (int i = 0; i < 3; ++i) {  // moving all vertices along the outward direction makes the distance negative
        Points up = Points::Zero(box.num_vertices(), 3);
        up.col(2).setOnes();
        EXPECT_LT((at.dr_dv * flat(up))[i], -0.3) << i;
    }
}

TEST(MeasuredPoints, ScalesIgnoresRigidMotionAndRefinement) {
    const TriMesh mesh = ellipsoid({1, 1.1, 0.9}, 2);
    const auto scan = cloud(50);
    const double J = value(measured_points("scan", mesh, scan), mesh);
    EXPECT_NEAR(value(measured_points("scan", refined(mesh), scan), refined(mesh)), J, 1e-13 * J);
    auto far = scan;
    for (MeasuredPoint& p : far) p.at = 1000 * p.at + Eigen::Vector3d(5, -3, 1);
    const TriMesh other = moved(mesh, 1000, {5, -3, 1});
    EXPECT_NEAR(value(measured_points("scan", other, far), other), 1e6 * J, 1e-6 * J);
    const Points g = ask(measured_points("scan", mesh, scan), mesh, true).dJ_dv[0];
    double moment = 0;  // Euler: moving surface and points together by a scale s gives s^2 J
    for (int v = 0; v < mesh.num_vertices(); ++v) moment += g.row(v).dot(mesh.vertices.row(v));
    EXPECT_TRUE(std::isfinite(moment));
    EXPECT_NEAR(value(measured_points("scan", mesh, {{{0, 0, 2}, 1}, {{9, 9, 9}, 0}}), mesh), 1.1 * 1.1, 1e-12);
}

TEST(MeasuredPoints, KeptMatchesAreThePlanesThatWereClosest) {
    const TriMesh box = box_surface();
    const Quantity scan = measured_points("scan", box, {{{0.4, 0.3, 1.5}}});
    EXPECT_NEAR(scan.residuals(moved(box, 1, {7, 0, 0.1}), box).r[0], 0.4, 1e-14);
}

TEST(MeasuredPoints, FilesAreReadAndErrorsNameTheLine) {
    const TemporaryFile good("a.csv", "x,y,z,weight\n# a comment\n1,2,3\n4;5;6;0.5\r\n7 8 9 2\n");
    const auto read = read_measured_points(good.path);
    ASSERT_EQ(read.size(), 3u);
    EXPECT_EQ(read[1].at, Eigen::Vector3d(4, 5, 6));
    EXPECT_EQ(read[1].weight, 0.5);
    const std::pair<const char*, const char*> bad[] = {{"1,2,3\n1,2\n", ":2: 2 numbers"},
                                                       {"1,2,3,4,5\n", ":1: more than 4"},
                                                       {"1,2,3\n1,x,3\n", ":2: expected a number (y), got 'x'"},
                                                       {"1,2,3\n\n1,nan,3\n", ":3: "},
                                                       {"1,2,3,-1\n", ":1: weight = -1 must be >= 0"},
                                                       {"x,y,z\n", "no rows; expected x,y,z,[weight]"},
                                                       {"", "no rows"}};
    for (const auto& [content, words] : bad) {
        const TemporaryFile file("b.csv", content);
        const std::string message = refusal([&] { read_measured_points(file.path); });
        EXPECT_TRUE(has(message, words) && has(message, "b.csv")) << message;
    }
    EXPECT_TRUE(has(refusal([] { read_measured_points("missing.csv"); }), "missing.csv: cannot be read"));
}

TEST(MeasuredPoints, WrongPointsAndSurfacesAreRefused) {
    const TriMesh mesh = icosphere(1);
    EXPECT_THROW(measured_points("scan", mesh, {}), InvalidInput);
    EXPECT_THROW(measured_points("scan", mesh, {{{0, 0, 2}, -1}}), InvalidInput);
    EXPECT_THROW(measured_points("scan", mesh, {{{0, 0, 2}, 0}}), InvalidInput);
    EXPECT_THROW(measured_points("scan", mesh, {{{0, NAN, 2}, 1}}), InvalidInput);
    TriMesh broken = mesh;
    broken.vertices(3, 1) = NAN;
    const Quantity scan = measured_points("scan", mesh, {{{0, 0, 2}}});
    ASSERT_TRUE(ask(scan, broken).failure);
    EXPECT_THROW(scan.residuals(broken, broken), InvalidInput);
}
