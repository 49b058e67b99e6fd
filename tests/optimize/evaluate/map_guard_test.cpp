#include "optimize/evaluate/validity.hpp"

#include "core/error.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <cmath>

using namespace strake;

namespace {

using Map = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

ValidityOptions by_map() {
    ValidityOptions options;
    options.by_map = true;
    return options;
}

TriMesh joined(const TriMesh& a, const TriMesh& b) {
    TriMesh out;
    out.vertices.resize(a.num_vertices() + b.num_vertices(), 3);
    out.vertices << a.vertices, b.vertices;
    out.triangles.resize(a.num_triangles() + b.num_triangles(), 3);
    out.triangles << a.triangles, Triangles(b.triangles.array() + a.num_vertices());
    return out;
}

TriMesh shifted(TriMesh mesh, const Eigen::RowVector3d& by) {
    mesh.vertices.rowwise() += by;
    return mesh;
}

/// What the guard says of the surface after the map, with the map's linear parts by central differences.
std::string defect_after(const TriMesh& mesh, const Map& map) {
    const ValidityGuard guard(mesh, adjacency(mesh), by_map());
    Points moved = mesh.vertices;
    for (int v = 0; v < mesh.num_vertices(); ++v) moved.row(v) = map(mesh.vertices.row(v)).transpose();
    std::vector<Eigen::Matrix3d> linear;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        Eigen::Vector3d c = Eigen::Vector3d::Zero();
        for (int k = 0; k < 3; ++k) c += mesh.vertices.row(mesh.triangles(t, k)).transpose() / 3;
        Eigen::Matrix3d F;
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d h = 1e-5 * Eigen::Vector3d::Unit(k);
            F.col(k) = (map(c + h) - map(c - h)) / 2e-5;
        }
        linear.push_back(F);
    }
    return guard.defect(moved, linear);
}

Map bend(double by) {
    return [by](const Eigen::Vector3d& x) { return Eigen::Vector3d(x[0], x[1], x[2] + by * x[0] * x[0]); };
}

}  // namespace

TEST(MapGuard, PartsThatPassThroughEachOtherMayBend) {
    const TriMesh one = box_surface({4, 1, 1}, 6), other = shifted(box_surface({1, 0.6, 2}, 5), {1.3, 0.17, 0.31});
    EXPECT_EQ(defect_after(joined(one, other), [](const Eigen::Vector3d& x) { return x; }), "");
    EXPECT_EQ(defect_after(joined(one, other), bend(0.05)), "");
}

TEST(MapGuard, PartsThatWereApartMayNotMeet) {
    const TriMesh two = joined(box_surface({1, 1, 1}, 3), shifted(box_surface({1, 1, 1}, 3), {1.2, 0.1, 0.1}));
    EXPECT_EQ(defect_after(two, bend(0.05)), "");
    const auto shut = [](const Eigen::Vector3d& x) {
        return Eigen::Vector3d(x[0] > 1.1 ? x[0] - 0.3 : x[0], x[1], x[2]);
    };
    EXPECT_NE(defect_after(two, shut).find("intersect"), std::string::npos);
}

/// A part that pierces another at rest is no licence: far from the cut nothing new is allowed.
TEST(MapGuard, ACutMayWanderByTheChordErrorOnly) {
    const TriMesh one = box_surface({4, 1, 1}, 6), other = shifted(box_surface({1, 0.6, 2}, 5), {1.3, 0.17, 0.31});
    const TriMesh both = joined(one, other);
    const int n = one.num_vertices();
    const ValidityGuard guard(both, adjacency(both), by_map());
    const std::vector<Eigen::Matrix3d> still(static_cast<std::size_t>(both.num_triangles()),
                                             Eigen::Matrix3d::Identity());
    Points slid = both.vertices;
    slid.bottomRows(both.num_vertices() - n).col(0).array() += 0.5;  // as if another map moved this part
    EXPECT_NE(guard.defect(slid, still).find("intersect"), std::string::npos);
}

TEST(MapGuard, TJunctionsMayOverlapByTheChordError) {
    // Three cells on one side of the edge y = 1, five on the other.
    TriMesh sheet = joined(strip(3, 1, 3, 1), shifted(strip(3, 1, 5, 1), {0, 1, 0}));
    const auto arch = [](double by) {
        return [by](const Eigen::Vector3d& x) {
            return Eigen::Vector3d(x[0], x[1] + by * std::sin(x[0]), x[2] + 0.02 * x[0] * x[0]);
        };
    };
    EXPECT_EQ(defect_after(sheet, arch(0.05)), "");
    EXPECT_EQ(defect_after(sheet, arch(-0.05)), "");
}

/// Triangles that share a corner are as near as can be: that alone is no contact.
TEST(MapGuard, NeighboursMayNotPierceEachOther) {
    TriMesh mesh = hinge(1, 1);
    const int n = mesh.num_vertices();
    const Eigen::RowVector3i first = mesh.triangles.row(0);
    const Eigen::RowVector3d at = mesh.vertices.row(first[0]),
                             middle = mesh.vertices(first, Eigen::all).colwise().mean();
    // A third triangle hangs at a corner: through the first one, and, turned in its own plane, away from it.
    const Eigen::RowVector3d above = middle + Eigen::RowVector3d(0, 0, 0.2),
                             below = 2 * middle - at - Eigen::RowVector3d(0, 0, 0.2);
    mesh.vertices.conservativeResize(n + 2, 3);
    mesh.vertices.row(n) = 2 * at - above;
    mesh.vertices.row(n + 1) = 2 * at - below;
    mesh.triangles.conservativeResize(3, 3);
    mesh.triangles.row(2) << first[0], n, n + 1;
    const ValidityGuard guard(mesh, adjacency(mesh), by_map());
    const std::vector<Eigen::Matrix3d> still(3, Eigen::Matrix3d::Identity());
    ASSERT_EQ(guard.defect(mesh.vertices, still), "");
    Points moved = mesh.vertices;
    moved.row(n) = above;
    moved.row(n + 1) = below;
    EXPECT_NE(guard.defect(moved, still).find("intersect"), std::string::npos) << guard.defect(moved, still);
}

TEST(MapGuard, FoldsOfSpaceAreTold) {
    const TriMesh box = box_surface({1, 1, 1}, 2);
    const auto through = [](const Eigen::Vector3d& x) { return Eigen::Vector3d(x[0], x[1], -0.5 * x[2]); };
    EXPECT_NE(defect_after(box, through).find("fold space at triangle 0"), std::string::npos)
        << defect_after(box, through);
    const auto flat = [](const Eigen::Vector3d& x) { return Eigen::Vector3d(x[0], x[1], 0.04 * x[2]); };
    EXPECT_NE(defect_after(box, flat).find("fold space"), std::string::npos);
}

TEST(MapGuard, NeedlesAreNotJudgedButSoundTrianglesAre) {
    TriMesh mesh = hinge(1, 1);  // apexes at x = -1 and 1, edge along y
    const int n = mesh.num_vertices();
    mesh.vertices.conservativeResize(n + 1, 3);
    mesh.vertices.row(n) = 0.5 * (mesh.vertices.row(mesh.triangles(0, 0)) + mesh.vertices.row(mesh.triangles(0, 1)));
    mesh.vertices(n, 2) = 1e-5;
    mesh.triangles.conservativeResize(3, 3);
    mesh.triangles.row(2) << mesh.triangles(0, 0), mesh.triangles(0, 1), n;
    const ValidityGuard guard(mesh, adjacency(mesh), by_map());
    const std::vector<Eigen::Matrix3d> still(3, Eigen::Matrix3d::Identity());
    Points moved = mesh.vertices;
    moved(n, 2) = -1e-5;  // the needle turns over
    EXPECT_EQ(guard.defect(moved, still), "");
    moved = mesh.vertices;
    moved(3, 0) = -0.5;
    EXPECT_NE(guard.defect(moved, still).find("triangle 1 is inverted"), std::string::npos);
}

TEST(MapGuard, IsMadeForItOrRefuses) {
    const TriMesh box = box_surface({1, 1, 1}, 1);
    const std::vector<Eigen::Matrix3d> still(12, Eigen::Matrix3d::Identity());
    EXPECT_THROW(ValidityGuard(box, adjacency(box)).defect(box.vertices, still), InvalidInput);
    const std::vector<Eigen::Matrix3d> few(3, Eigen::Matrix3d::Identity());
    EXPECT_THROW(ValidityGuard(box, adjacency(box), by_map()).defect(box.vertices, few), InvalidInput);
}
