#include "core/remesh/remesh.hpp"

#include "cases/geometry/wing.hpp"
#include "core/error.hpp"
#include "measure.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// A sphere-like body with bumps, its triangles of very different size.
TriMesh bumpy(int subdivisions) {
    TriMesh mesh = icosphere(subdivisions);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Eigen::Vector3d p = mesh.vertices.row(v);
        mesh.vertices.row(v) = (1 + 0.15 * std::sin(5 * p.x()) * std::cos(4 * p.y())) * p + 0.4 * p.x() * p.x() * p;
    }
    return mesh;
}

void expect_closed_manifold(const TriMesh& mesh, int euler_number) {
    const TopologyFacts facts = topology(mesh, adjacency(mesh));
    EXPECT_TRUE(facts.closed);
    EXPECT_TRUE(facts.nonmanifold_edges.empty());
    EXPECT_TRUE(facts.nonmanifold_vertices.empty());
    EXPECT_TRUE(facts.degenerate_triangles.empty());
    EXPECT_TRUE(facts.isolated_vertices.empty());
    EXPECT_EQ(euler(mesh), euler_number);
    const Intersections pairs = intersections(mesh);
    EXPECT_TRUE(pairs.apart.empty() && pairs.adjacent.empty());
    EXPECT_GT(enclosed_volume(mesh), 0);
}

}  // namespace

TEST(Remesh, SmoothBodyIsMadeOfNearlyEquilateralTriangles) {
    const TriMesh mesh = bumpy(5);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.06});
    expect_closed_manifold(result.mesh, 2);
    const Shape shape = shape_of(result.mesh);
    expect_goals(shape);
    EXPECT_NEAR(shape.mean_edge, 0.06, 0.06 * 0.02);
    EXPECT_LT(hausdorff(mesh, result.mesh), 2e-3 * box_diagonal(mesh));
    EXPECT_EQ(result.crease_edges, 0);
    EXPECT_EQ(result.new_intersections, 0);
    const ClosestPointTree tree(mesh);
    for (int v = 0; v < result.mesh.num_vertices(); ++v)  // every vertex is on the input
        ASSERT_LT(tree.find(result.mesh.vertices.row(v)).distance, 1e-12);
}

TEST(Remesh, AutomaticLengthIsTheMeanEdgeAndStaysSo) {
    const TriMesh mesh = bumpy(4);
    const RemeshResult once = remesh(mesh);
    EXPECT_NEAR(shape_of(once.mesh).mean_edge, once.edge_length, 0.03 * once.edge_length);
    const RemeshResult twice = remesh(once.mesh);
    EXPECT_NEAR(twice.edge_length, once.edge_length, 0.03 * once.edge_length);
    int moved = 0;
    for (int v = 0; v < twice.mesh.num_vertices(); ++v)
        moved += (once.mesh.vertices.rowwise() - twice.mesh.vertices.row(v)).rowwise().norm().minCoeff() >
                 0.1 * once.edge_length;
    EXPECT_LT(moved, 0.05 * twice.mesh.num_vertices());
}

TEST(Remesh, SameBitsForOneTwoAndFiveThreads) {
    const TriMesh mesh = bumpy(5);
    const RemeshResult one = remesh(mesh, {.edge_length = 0.03, .iterations = 4, .threads = 1});
    EXPECT_TRUE(same_bits(one.mesh, remesh(mesh, {.edge_length = 0.03, .iterations = 4, .threads = 2}).mesh));
    EXPECT_TRUE(same_bits(one.mesh, remesh(mesh, {.edge_length = 0.03, .iterations = 4, .threads = 5}).mesh));
}

TEST(Remesh, PlaceAndUnitDoNotMatter) {
    const TriMesh mesh = bumpy(4);
    const Shape at_rest = shape_of(remesh(mesh, {.edge_length = 0.1}).mesh);
    TriMesh moved = mesh;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    moved.vertices = (1000 * mesh.vertices * turn.transpose()).rowwise() + Eigen::RowVector3d(500, -3000, 20);
    const RemeshResult result = remesh(moved, {.edge_length = 100});
    const Shape shape = shape_of(result.mesh);
    EXPECT_NEAR(shape.mean, at_rest.mean, 2e-3);
    EXPECT_NEAR(shape.mean_edge, 1000 * at_rest.mean_edge, 10 * at_rest.mean_edge);
    EXPECT_LT(hausdorff(moved, result.mesh), 1.2e-2 * box_diagonal(moved));
}

TEST(Remesh, CurvatureShortensEdgesWithinTheGradation) {
    const TriMesh mesh = ellipsoid({3, 1, 0.3}, 5);
    const RemeshResult uniform = remesh(mesh, {.edge_length = 0.3});
    const RemeshResult graded = remesh(mesh, {.edge_length = 0.3, .chord_error = 0.003});
    EXPECT_GT(graded.mesh.num_triangles(), 1.5 * uniform.mesh.num_triangles());
    EXPECT_LT(hausdorff(mesh, graded.mesh), 0.5 * hausdorff(mesh, uniform.mesh));
    const Shape shape = shape_of(graded.mesh);
    EXPECT_GT(shape.mean, 0.91);
    EXPECT_GT(shape.smallest, 0.4);
    const Adjacency adjacent = adjacency(graded.mesh);  // neighbours in size: no edge twice as long as the next
    for (int t = 0; t < graded.mesh.num_triangles(); ++t) {
        double shortest = 1e9, longest = 0;
        for (int k = 0; k < 3; ++k) {
            const auto [a, b] = adjacent.edges[adjacent.triangle_edges(t, k)];
            const double l = (graded.mesh.vertices.row(a) - graded.mesh.vertices.row(b)).norm();
            shortest = std::min(shortest, l), longest = std::max(longest, l);
        }
        ASSERT_LT(longest, 3.0 * shortest);
    }
}

TEST(Remesh, NeedlesOfAStructuredWingGo) {
    const TriMesh mesh = example::naca_wing(0.12, 60, 8, 4.0);  // cells up to 300 times longer than wide
    EXPECT_LT(shape_of(mesh).smallest, 0.01);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.05});
    const TopologyFacts facts = topology(result.mesh, adjacency(result.mesh));
    EXPECT_EQ(facts.boundary_loops.size(), 2u);
    EXPECT_TRUE(facts.nonmanifold_edges.empty());
    EXPECT_EQ(result.new_intersections, 0);
    const Shape shape = shape_of(result.mesh);
    EXPECT_GT(shape.mean, 0.93);
    EXPECT_GT(shape.smallest, 0.2);
    EXPECT_LT(hausdorff(mesh, result.mesh), 2e-3 * box_diagonal(mesh));
}

/// As CAD programs hand out wings: two cells along the span, 350 points on each side of the section, crowded at its
/// nose, a knife edge, and ends that are fans of needles from it: 4 196 triangles, hardly one of a quality above 1e-2.
TriMesh wing_of_needles() {
    constexpr int n = 350, cells = 2, m = 2 * n;
    TriMesh mesh;
    mesh.vertices.resize((cells + 1) * m, 3);
    mesh.triangles.resize(2 * cells * m + 2 * (m - 2), 3);
    const auto half = [](double x) {  // NACA 0012, closed
        return 0.6 * (0.2969 * std::sqrt(x) - x * (0.1260 + x * (0.3516 - x * (0.2843 - 0.1036 * x))));
    };
    for (int s = 0; s <= cells; ++s)
        for (int i = 0; i < m; ++i) {
            const double x = 0.5 * (1 + std::cos(std::numbers::pi * i / n)), y = 4.0 * s / cells, chord = 1 - 0.1 * y;
            const double z = i == 0 ? 0 : (i <= n ? 1 : -1) * half(std::max(0.0, x));
            mesh.vertices.row(s * m + i) << 0.15 * y + chord * x, y, chord * z;
        }
    int t = 0;
    for (int s = 0; s < cells; ++s)
        for (int i = 0; i < m; ++i) {
            const int a = s * m + i, b = s * m + (i + 1) % m;
            mesh.triangles.row(t++) << a, b + m, b;
            mesh.triangles.row(t++) << a, a + m, b + m;
        }
    for (int i = 1; i + 1 < m; ++i) {
        mesh.triangles.row(t++) << 0, i, i + 1;
        mesh.triangles.row(t++) << cells * m, cells * m + i + 1, cells * m + i;
    }
    return mesh;
}

TEST(Remesh, AWingOfNeedlesBecomesOneOfGoodTriangles) {
    const TriMesh wing = wing_of_needles();
    ASSERT_EQ(wing.num_triangles(), 4196);
    EXPECT_LT(shape_of(wing).mean, 0.01);
    RemeshOptions options;
    options.edge_length = 0.0258;
    options.threads = 1;
    const RemeshResult result = remesh(wing, options);
    EXPECT_EQ(result.new_intersections, 0);
    EXPECT_EQ(result.frozen_triangles, 0);
    EXPECT_GT(result.mesh.num_triangles(), 20000);
    EXPECT_LT(result.mesh.num_triangles(), 30000);
    const Shape shape = shape_of(result.mesh);
    EXPECT_GT(shape.mean, 0.97);
    EXPECT_GT(shape.smallest, 0.3);
    EXPECT_NEAR(surface_area(result.mesh), surface_area(wing), 3e-3 * surface_area(wing));
}

TEST(Remesh, TinyAndHugeLengthsEndWell) {
    const TriMesh tetrahedron = [] {
        TriMesh t;
        t.vertices.resize(4, 3);
        t.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
        t.triangles.resize(4, 3);
        t.triangles << 0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2;
        return t;
    }();
    const RemeshResult coarse = remesh(tetrahedron, {.edge_length = 100});
    EXPECT_EQ(coarse.mesh.num_triangles(), 4);
    EXPECT_EQ(coarse.corners, 4);
    expect_closed_manifold(remesh(tetrahedron, {.edge_length = 0.1}).mesh, 2);
    const RemeshResult ball = remesh(icosphere(4), {.edge_length = 50});  // normals hold it
    expect_closed_manifold(ball.mesh, 2);
    EXPECT_GT(enclosed_volume(ball.mesh), 3.0);
    EXPECT_LT(ball.mesh.num_triangles(), icosphere(4).num_triangles());
    try {
        remesh(tetrahedron, {.edge_length = 1e-6});
        FAIL();
    } catch (const InvalidInput& e) {
        EXPECT_NE(std::string(e.what()).find("20000000"), std::string::npos) << e.what();
    }
}

TEST(Remesh, WrongInputIsRefusedWithItsPlace) {
    const TriMesh mesh = icosphere(1);
    EXPECT_THROW(remesh(TriMesh{}), InvalidInput);
    EXPECT_THROW(remesh(mesh, {.edge_length = -1}), InvalidInput);
    EXPECT_THROW(remesh(mesh, {.edge_length = std::nan("")}), InvalidInput);
    EXPECT_THROW(remesh(mesh, {.angle_deg = 0}), InvalidInput);
    EXPECT_THROW(remesh(mesh, {.angle_deg = 91}), InvalidInput);
    EXPECT_THROW(remesh(mesh, {.iterations = 0}), InvalidInput);
    EXPECT_THROW(remesh(mesh, {.gradation = 0}), InvalidInput);
    EXPECT_THROW(remesh(mesh, {.threads = -1}), InvalidInput);
    TriMesh broken = mesh;
    broken.triangles(7, 1) = 999;
    EXPECT_THROW(remesh(broken), InvalidInput);
    broken = mesh;
    broken.vertices(3, 2) = std::nan("");
    EXPECT_THROW(remesh(broken), InvalidInput);
    TriMesh flat = mesh;
    flat.vertices.setZero();
    EXPECT_THROW(remesh(flat), InvalidInput);
}

TEST(Remesh, CanBeCancelledAfterEveryPassWithAValidSurface) {
    const TriMesh mesh = bumpy(4);
    for (const int stop : {1, 2, 5}) {
        const RemeshResult result =
            remesh(mesh, {.edge_length = 0.05}, [&](const RemeshRecord& r) { return r.iteration < stop; });
        EXPECT_TRUE(result.cancelled);
        EXPECT_EQ(static_cast<int>(result.records.size()), stop);
        const TopologyFacts facts = topology(result.mesh, adjacency(result.mesh));
        EXPECT_TRUE(facts.closed);
    }
}

TEST(Remesh, DegenerateAndRepeatedCornersDoNotHarm) {
    TriMesh mesh = icosphere(3);
    const int n = mesh.num_vertices(), m = mesh.num_triangles();
    // An edge gets a vertex on it with two triangles of zero area; one triangle repeats a corner.
    const int a = mesh.triangles(0, 0), b = mesh.triangles(0, 1), c = mesh.triangles(0, 2);
    mesh.vertices.conservativeResize(n + 1, 3);
    mesh.vertices.row(n) = 0.5 * (mesh.vertices.row(a) + mesh.vertices.row(b));
    mesh.triangles.conservativeResize(m + 3, 3);
    mesh.triangles.row(0) << n, b, c;
    mesh.triangles.row(m) << a, n, c;
    mesh.triangles.row(m + 1) << a, b, n;  // on a line
    mesh.triangles.row(m + 2) << a, a, b;
    const RemeshResult result = remesh(mesh, {.edge_length = 0.2});
    expect_closed_manifold(result.mesh, 2);
    EXPECT_GT(shape_of(result.mesh).smallest, 0.3);
}
