#include "core/mesh/geometry.hpp"
#include "cases/geometry/closed_body.hpp"
#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/waverider.hpp"
#include "cases/geometry/wing.hpp"
#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/topology.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

namespace strake {
namespace {

constexpr double degree = std::numbers::pi / 180;

struct EdgeCounts {
    int boundary = 0, bad = 0;
};
EdgeCounts edge_counts(const Adjacency& adjacent) {
    EdgeCounts counts;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (adjacent.edge_triangles[e].size() == 1)
            ++counts.boundary;
        else if (!adjacent.is_regular(e))
            ++counts.bad;
    }
    return counts;
}

double smallest_angle_deg(const TriMesh& mesh) { return corner_angles(mesh).minCoeff() / degree; }

/// Dihedral of every edge whose two ends satisfy `on`.
template <class Predicate>
std::vector<double> dihedrals_deg(const TriMesh& mesh, const Adjacency& adjacent, const Predicate& on) {
    const Points normals = triangle_normals(mesh);
    std::vector<double> angles;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (!adjacent.is_regular(e) || !on(adjacent.edges[e][0]) || !on(adjacent.edges[e][1])) continue;
        const auto pair = adjacent.edge_triangles[e];
        angles.push_back(dihedral(normals.row(pair[0]), normals.row(pair[1])) / degree);
    }
    return angles;
}

/// Euler characteristic of the vertices in use.
int euler(const TriMesh& mesh, const Adjacency& adjacent) {
    return mesh.num_vertices() - adjacent.num_edges() + mesh.num_triangles();
}

/// Volume between the half model and its plane y = 0, measured from the origin, which lies in the plane.
double half_model_volume(const TriMesh& mesh) {
    double sum = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::Vector3d a = mesh.vertices.row(mesh.triangles(t, 0));
        sum += a.dot(area_vector(mesh, t)) / 3;
    }
    return sum;
}

class WingOfSize : public testing::TestWithParam<int> {};

TEST_P(WingOfSize, IsAHalfModelOpenOnlyOnThePlane) {
    const TriMesh mesh = example::wing(GetParam());
    const Adjacency adjacent = adjacency(mesh);
    EXPECT_NEAR(mesh.num_triangles(), GetParam(), 0.1 * GetParam());
    EXPECT_EQ(edge_counts(adjacent).bad, 0);
    EXPECT_EQ(euler(mesh, adjacent), 1) << "a disc";
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (adjacent.edge_triangles[e].size() != 1) continue;
        EXPECT_EQ(mesh.vertices(adjacent.edges[e][0], 1), 0.0);
        EXPECT_EQ(mesh.vertices(adjacent.edges[e][1], 1), 0.0);
    }
    EXPECT_GE(mesh.vertices.col(1).minCoeff(), 0.0);
    EXPECT_NEAR(half_model_volume(mesh), 0.03264, 0.001) << "outward";
    EXPECT_GT(smallest_angle_deg(mesh), 20.0);
}

TEST_P(WingOfSize, HasItsProportions) {
    const TriMesh mesh = example::wing(GetParam());
    double root_front = 1, root_back = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (mesh.vertices(v, 1) != 0.0) continue;
        root_front = std::min(root_front, mesh.vertices(v, 0));
        root_back = std::max(root_back, mesh.vertices(v, 0));
    }
    EXPECT_EQ(root_front, 0.0);
    EXPECT_NEAR(root_back, 0.8059, 1e-15);
    const Box box = bounding_box(mesh);
    EXPECT_NEAR(box.max.x(), 1.1963 * std::tan(30 * degree) + 0.562 * 0.8059, 1e-12);
    // The tip's half body of revolution stands out by half of the tip's thickness.
    EXPECT_NEAR(box.max.y(), 1.1963 + 0.5 * 0.098 * 0.562 * 0.8059, 4e-4);
    EXPECT_EQ(box.max.z(), -box.min.z());
}

INSTANTIATE_TEST_SUITE_P(Sizes, WingOfSize, testing::Values(1000, 1500, 4000, 22'000, 60'000));

TEST(Wing, TrailingEdgeIsSharpAndLeadingEdgeIsRound) {
    const TriMesh mesh = example::wing(22'000);
    const Adjacency adjacent = adjacency(mesh);
    const double taper_per_span = (0.562 - 1) * 0.8059 / 1.1963;
    const auto chordwise = [&](int v) {
        const double y = mesh.vertices(v, 1);
        return (mesh.vertices(v, 0) - y * std::tan(30 * degree)) / (0.8059 + taper_per_span * y);
    };
    const auto on_edge = [&](int v, double at) {
        return mesh.vertices(v, 2) == 0.0 && mesh.vertices(v, 1) <= 1.1963 && std::abs(chordwise(v) - at) < 1e-9;
    };
    const auto trailing = dihedrals_deg(mesh, adjacent, [&](int v) { return on_edge(v, 1.0); });
    const auto leading = dihedrals_deg(mesh, adjacent, [&](int v) { return on_edge(v, 0.0); });
    ASSERT_GT(trailing.size(), 80u);
    ASSERT_GT(leading.size(), 80u);
    // dz/dx of the section at the trailing edge is -5 t 0.2335: the two sides meet at 2 x 6.5 degrees.
    EXPECT_GT(*std::min_element(trailing.begin(), trailing.end()), 164.0);
    EXPECT_LT(*std::max_element(leading.begin(), leading.end()), 75.0);
}

TEST(Wing, IsItsOwnMirrorImageInTheChordPlane) {
    const TriMesh mesh = example::wing(3000);
    std::set<std::array<double, 3>> points;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        points.insert({mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2)});
    for (int v = 0; v < mesh.num_vertices(); ++v)
        EXPECT_TRUE(points.count({mesh.vertices(v, 0), mesh.vertices(v, 1), -mesh.vertices(v, 2)})) << v;
}

/// Errors against the finest fall about as the edge length squared, so that a quarter of the triangles has four times
/// the error.
template <class Make>
void expect_convergence(const Make& make) {
    const TriMesh coarse = make(6000), fine = make(24'000), finest = make(384'000);
    for (const auto measure : {enclosed_volume, surface_area}) {
        const double reference = measure(finest);
        const double ratio = (measure(coarse) - reference) / (measure(fine) - reference);
        EXPECT_GT(ratio, 2.5);
        EXPECT_LT(ratio, 8.0);
        EXPECT_LT(std::abs(measure(fine) / reference - 1), 2e-3);
    }
}
TEST(Wing, VolumeAndAreaConverge) {
    expect_convergence([](int n) { return example::wing(n); });
}

TEST(Wing, VolumeIsThatOfItsFormula) {
    // Section area 2 c^2 t 5 x integral of the thickness form; trapezoid of linearly varying chord; plus the tip's half
    // body of revolution, pi/2 c^3 integral z^2.
    const int samples = 200'000;
    double area = 0, square = 0;
    for (int k = 0; k < samples; ++k) {
        const double z = example::naca_half_thickness(0.098, (k + 0.5) / samples);
        area += 2 * z / samples;
        square += z * z / samples;
    }
    const double root = 0.8059, tip = 0.562 * root;
    const double trapezoid = area * 1.1963 * (root * root + root * tip + tip * tip) / 3;
    const double cap = 0.5 * std::numbers::pi * tip * tip * tip * square;
    EXPECT_NEAR(half_model_volume(example::wing(200'000)) / (trapezoid + cap), 1.0, 3e-4);
}

TEST(Superellipsoid, LiesOnItsFormulaAndAnEllipsoidHasItsVolume) {
    const TriMesh ellipsoid = example::superellipsoid(20'000, {{0.5, 0.1, 0.2}, 2});
    EXPECT_NEAR(enclosed_volume(ellipsoid) / (4 * std::numbers::pi / 3 * 0.5 * 0.1 * 0.2), 1, 2e-3);
    const TriMesh body = example::superellipsoid(4'000);
    const Adjacency adjacent = adjacency(body);
    EXPECT_EQ(edge_counts(adjacent).bad + edge_counts(adjacent).boundary, 0);
    EXPECT_EQ(euler(body, adjacent), 2);
    for (int v = 0; v < body.num_vertices(); ++v) {
        const Eigen::Array3d x = body.vertices.row(v).transpose().array() / Eigen::Array3d(0.5, 0.4, 0.35);
        EXPECT_NEAR(x.abs().pow(2.5).sum(), 1, 1e-9);
    }
    EXPECT_THROW(example::superellipsoid(4'000, {{1, 1, 1}, 0.5}), InvalidInput);
}

class BodyOfSize : public testing::TestWithParam<int> {};

TEST_P(BodyOfSize, IsClosedOrientedAndWellShaped) {
    const TriMesh mesh = example::lifting_body(GetParam());
    const Adjacency adjacent = adjacency(mesh);
    EXPECT_NEAR(mesh.num_triangles(), GetParam(), 0.1 * GetParam());
    EXPECT_EQ(edge_counts(adjacent).bad, 0);
    EXPECT_EQ(edge_counts(adjacent).boundary, 0);
    EXPECT_EQ(euler(mesh, adjacent), 2) << "a sphere";
    EXPECT_NEAR(enclosed_volume(mesh), 25.05, 0.5) << "outward";
    EXPECT_GT(smallest_angle_deg(mesh), 20.0);
}

TEST_P(BodyOfSize, HasAFlatBaseWithACreasedRim) {
    const TriMesh mesh = example::lifting_body(GetParam());
    const Adjacency adjacent = adjacency(mesh);
    const Points normals = triangle_normals(mesh);
    double base = 0;
    int rim = 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto pair = adjacent.edge_triangles[e];
        const bool first = normals(pair[0], 0) > 1 - 1e-12, second = normals(pair[1], 0) > 1 - 1e-12;
        if (first == second) continue;
        ++rim;
        EXPECT_GT(dihedral(normals.row(pair[0]), normals.row(pair[1])) / degree, 70.0);
        EXPECT_EQ(mesh.vertices(adjacent.edges[e][0], 0), 8.0);
        EXPECT_EQ(mesh.vertices(adjacent.edges[e][1], 0), 8.0);
    }
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (normals(t, 0) > 1 - 1e-12) base += area_vector(mesh, t).norm();
    EXPECT_GT(rim, 40);
    EXPECT_NEAR(base, 4.85, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Sizes, BodyOfSize, testing::Values(1500, 6000, 30'000, 100'000));

TEST(LiftingBody, VolumeAndAreaConverge) {
    expect_convergence([](int n) { return example::lifting_body(n); });
}

TEST(NacaWing, IsATubeWithASharpTrailingEdge) {
    const TriMesh mesh = example::naca_wing(0.12, 20, 12);
    const Adjacency adjacent = adjacency(mesh);
    EXPECT_EQ(mesh.num_triangles(), 2 * 12 * 40);
    EXPECT_EQ(edge_counts(adjacent).bad, 0);
    EXPECT_EQ(edge_counts(adjacent).boundary, 2 * 40);
    EXPECT_EQ(euler(mesh, adjacent), 0) << "a tube";
    const auto trailing = dihedrals_deg(mesh, adjacent, [&](int v) { return mesh.vertices(v, 0) == 1.0; });
    ASSERT_EQ(trailing.size(), 12u);
    EXPECT_GT(*std::min_element(trailing.begin(), trailing.end()), 160.0);
    EXPECT_GT(triangle_normals(mesh).col(2).cwiseAbs().maxCoeff(), 0.9);
    EXPECT_GT(enclosed_volume(mesh), 0.0) << "outward";
}

TEST(Examples, HaveNoDefects) {
    for (const TriMesh& mesh :
         {example::wing(22'000), example::wing(1500), example::lifting_body(30'000), example::lifting_body(1500)}) {
        const TopologyFacts facts = topology(mesh, adjacency(mesh));
        EXPECT_EQ(facts.components, 1);
        EXPECT_TRUE(facts.nonmanifold_vertices.empty());
        EXPECT_TRUE(facts.degenerate_triangles.empty());
        EXPECT_TRUE(facts.isolated_vertices.empty());
        EXPECT_TRUE(facts.duplicate_vertices.empty());
        const Intersections crossings = intersections(mesh);
        EXPECT_TRUE(crossings.apart.empty()) << crossings.apart.size();
        EXPECT_TRUE(crossings.adjacent.empty()) << crossings.adjacent.size();
    }
}

TEST(Examples, RefuseWrongRequests) {
    EXPECT_THROW(example::wing(999), InvalidInput);
    EXPECT_THROW(example::waverider(999), InvalidInput);
    EXPECT_THROW(example::waverider(5000, {.crowding = 0.5}), InvalidInput);
    EXPECT_THROW(example::lifting_body(0), InvalidInput);
    EXPECT_THROW(example::lifting_body(6'000'000), InvalidInput);
    EXPECT_THROW(example::naca_wing(0.12, 1, 5), InvalidInput);
    EXPECT_THROW(example::naca_wing(0, 10, 5), InvalidInput);
}

double largest_aspect_ratio(const TriMesh& mesh) {
    const Eigen::VectorXd areas = triangle_areas(mesh);
    double largest = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        double longest = 0;
        for (int c = 0; c < 3; ++c)
            longest = std::max(
                longest,
                (mesh.vertices.row(mesh.triangles(t, (c + 1) % 3)) - mesh.vertices.row(mesh.triangles(t, c))).norm());
        largest = std::max(largest, longest * longest / (2 * areas[t]));
    }
    return largest;
}

TEST(Waverider, IsClosedSymmetricAndFullOfLongCells) {
    for (const int wanted : {1000, 12'000}) {
        const TriMesh mesh = example::waverider(wanted);
        EXPECT_NEAR(mesh.num_triangles(), wanted, 0.05 * wanted);
        const Adjacency adjacent = adjacency(mesh);
        const EdgeCounts counts = edge_counts(adjacent);
        EXPECT_EQ(counts.boundary + counts.bad, 0);
        EXPECT_EQ(euler(mesh, adjacent), 2);
        EXPECT_GT(enclosed_volume(mesh), 0);
    }
    EXPECT_NEAR(largest_aspect_ratio(example::waverider(80'000)), 300, 30);
    EXPECT_GT(largest_aspect_ratio(example::waverider(12'000, {.crowding = 400})), 5000);
}

TEST(WingedVehicle, IsClosed) {
    const TriMesh mesh = example::lifting_body(10'000, example::winged_vehicle());
    const EdgeCounts counts = edge_counts(adjacency(mesh));
    EXPECT_EQ(counts.boundary + counts.bad, 0);
    EXPECT_GT(enclosed_volume(mesh), 0);
}

}  // namespace
}  // namespace strake
