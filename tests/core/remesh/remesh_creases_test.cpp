#include "core/remesh/remesh.hpp"

#include "derivatives.hpp"
#include "measure.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

#include <set>

using namespace strake;
using Eigen::Vector3d;

/// The promise about creases, on bodies whose creases bend, zigzag and end: all of the input's are chains of the
/// output's, on the input's to 1e-9 of the diagonal and no farther from it than the longest edges' arcs would be.
namespace {

constexpr double angle_deg = 40, radians = std::numbers::pi / 180;

/// Creases of a surface as chains.
struct Creases {
    std::vector<std::array<int, 2>> edges;
    std::vector<std::vector<int>> at;  ///< numbers of the edges at each vertex
    std::vector<double> turn;          ///< of the chain, at vertices with two edges
    std::vector<char> is_corner;

    Creases(const TriMesh& mesh, double degrees)
        : at(mesh.num_vertices()), turn(mesh.num_vertices(), 0), is_corner(mesh.num_vertices(), 0) {
        const Adjacency adjacent = adjacency(mesh);
        const Points normals = triangle_normals(mesh);
        for (int e = 0; e < adjacent.num_edges(); ++e) {
            const auto pair = adjacent.edge_triangles[e];
            if (dihedral(normals.row(pair[0]), normals.row(pair[1])) < degrees * radians - 1e-9) continue;
            for (const int v : adjacent.edges[e]) at[v].push_back(static_cast<int>(edges.size()));
            edges.push_back(adjacent.edges[e]);
        }
        for (int v = 0; v < mesh.num_vertices(); ++v) {
            if (at[v].size() == 2)
                turn[v] = dihedral(mesh.vertices.row(v) - mesh.vertices.row(other(at[v][0], v)),
                                   mesh.vertices.row(other(at[v][1], v)) - mesh.vertices.row(v));
            is_corner[v] = !at[v].empty() && (at[v].size() != 2 || turn[v] >= degrees * radians);
        }
    }
    int other(int e, int v) const { return edges[e][0] == v ? edges[e][1] : edges[e][0]; }
    /// Sum of the turns from v on along the chain that begins with edge e, up to the length `left`.
    double turns(const TriMesh& mesh, int v, int e, double left) const {
        double sum = 0;
        for (int step = 0; step < 1000; ++step) {
            const int w = other(e, v);
            left -= (mesh.vertices.row(w) - mesh.vertices.row(v)).norm();
            if (left < 0 || is_corner[w]) break;
            sum += turn[w];
            e = at[w][0] == e ? at[w][1] : at[w][0];
            v = w;
        }
        return sum;
    }
    /// 1 / R within the length at edge e.
    double curvature(const TriMesh& mesh, int e, double length) const {
        double most = 0;
        for (const int v : edges[e]) {
            if (is_corner[v]) continue;
            double sum = turn[v];
            for (const int beside : at[v]) sum += turns(mesh, v, beside, 0.5 * length);
            most = std::max(most, sum / length);
        }
        return most;
    }
};

void expect_exact_creases(const TriMesh& mesh, double length, double smallest) {
    const RemeshResult result = remesh(mesh, {.edge_length = length, .angle_deg = angle_deg});
    EXPECT_EQ(result.new_intersections, 0);
    const double diagonal = box_diagonal(mesh), near = 1e-9 * diagonal, longest = 4.0 / 3 * length;
    const Creases was(mesh, angle_deg);
    const auto before = creases_of(mesh, angle_deg);
    std::set<std::array<double, 3>> places;
    for (int v = 0; v < result.mesh.num_vertices(); ++v)
        places.insert({result.mesh.vertices(v, 0), result.mesh.vertices(v, 1), result.mesh.vertices(v, 2)});
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (was.is_corner[v]) {
            EXPECT_TRUE(places.contains({mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2)})) << v;
        }
    std::vector<std::array<Vector3d, 2>> after;  // along which the surface is folded, between points of the creases
    for (const auto& [a, b] : creases_of(result.mesh, 0.5 * angle_deg))
        if (distance(a, before) <= near && distance(b, before) <= near) after.push_back({a, b});
    for (const auto& [a, b] : creases_of(result.mesh, angle_deg))  // and no others
        EXPECT_LE(std::max(distance(a, before), distance(b, before)), near) << a.transpose() << ", " << b.transpose();
    ASSERT_FALSE(after.empty());
    for (std::size_t e = 0; e < was.edges.size(); ++e) {
        const Vector3d a = mesh.vertices.row(was.edges[e][0]), b = mesh.vertices.row(was.edges[e][1]);
        const double allowed =
            1.05 * std::max(1e-4 * diagonal, longest * longest / 8 * was.curvature(mesh, static_cast<int>(e), length));
        for (int i = 0; i <= 8; ++i)
            EXPECT_LE(distance(a + i / 8.0 * (b - a), after), allowed) << "edge " << e << " place " << i;
    }
    EXPECT_GT(shape_of(result.mesh).smallest, smallest);
}

/// A cylinder over an outline, in `cells` layers, closed by fans; its top bulges by `bulge`.
TriMesh column(const std::vector<Eigen::Vector2d>& outline, double height, int cells, double bulge = 0) {
    const int n = static_cast<int>(outline.size());
    TriMesh mesh;
    mesh.vertices.resize((cells + 1) * n + 2, 3);
    mesh.triangles.resize(2 * n * cells + 2 * n, 3);
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i < n; ++i) mesh.vertices.row(j * n + i) << outline[i].x(), outline[i].y(), height * j / cells;
    mesh.vertices.row((cells + 1) * n) << 0, 0, 0;
    mesh.vertices.row((cells + 1) * n + 1) << 0, 0, height + bulge;
    int t = 0;
    for (int i = 0; i < n; ++i) {
        const int next = (i + 1) % n, top = cells * n;
        for (int j = 0; j < cells; ++j) {
            mesh.triangles.row(t++) << j * n + i, j * n + next, (j + 1) * n + next;
            mesh.triangles.row(t++) << j * n + i, (j + 1) * n + next, (j + 1) * n + i;
        }
        mesh.triangles.row(t++) << next, i, top + n;
        mesh.triangles.row(t++) << top + i, top + next, top + n + 1;
    }
    return mesh;
}

/// Radius 1, the points moved in and out by up to `noise`, the same for every platform.
std::vector<Eigen::Vector2d> noisy_circle(int n, double noise, unsigned seed) {
    const Eigen::VectorXd r = Eigen::VectorXd::Ones(n) + noise * random_vector(n, seed);
    std::vector<Eigen::Vector2d> outline;
    for (int i = 0; i < n; ++i) {
        const double a = 2 * std::numbers::pi * i / n;
        outline.emplace_back(r[i] * std::cos(a), r[i] * std::sin(a));
    }
    return outline;
}

std::vector<Eigen::Vector2d> gear(int teeth, int points) {
    std::vector<Eigen::Vector2d> outline;
    for (int k = 0; k < teeth; ++k)
        for (const bool is_tooth : {true, false})
            for (int i = 0; i < points; ++i) {
                const double a = 2 * std::numbers::pi * (k + (is_tooth ? 0 : 0.5) + 0.4 * i / (points - 1)) / teeth;
                const double r = is_tooth ? 1.0 : 0.8;
                outline.emplace_back(r * std::cos(a), r * std::sin(a));
            }
    return outline;
}

}  // namespace

TEST(RemeshCreases, RimsAndTeethOfCadBodies) {
    expect_exact_creases(column(noisy_circle(24, 0, 1), 0.6, 1), 0.08, 0.3);
    expect_exact_creases(column(noisy_circle(200, 0, 1), 0.6, 3, 0.2), 0.1, 0.3);
    expect_exact_creases(column(gear(8, 5), 0.5, 2), 0.06, 0.25);
}

TEST(RemeshCreases, CreasesThatZigzagFromTriangleToTriangle) {
    // Turns of up to 25, 60 and 110 degrees at a vertex: without corners, with some, and with many.
    expect_exact_creases(column(noisy_circle(90, 0.008, 3), 0.6, 9), 0.07, 0.2);
    expect_exact_creases(column(noisy_circle(90, 0.02, 5), 0.6, 9), 0.07, 0.1);
    expect_exact_creases(column(noisy_circle(90, 0.05, 7), 0.6, 9), 0.05, 0.05);
}

TEST(RemeshCreases, NoiseAcrossThemToo) {
    TriMesh mesh = column(noisy_circle(120, 0.004, 9), 0.6, 12, 0.15);
    const Eigen::VectorXd noise = random_vector(mesh.vertices.size(), 11);
    mesh.vertices += 0.002 * Points::Map(noise.data(), mesh.num_vertices(), 3);
    expect_exact_creases(mesh, 0.06, 0.2);
    expect_exact_creases(mesh, 0.03, 0.2);
}

/// A plate of nearly equilateral triangles whose points are moved at random, so that edges here and there are creases.
TriMesh rough_plate(int columns, int rows, unsigned seed) {
    TriMesh mesh;
    mesh.vertices.resize(columns * rows, 3);
    mesh.triangles.resize(2 * (columns - 1) * (rows - 1), 3);
    const Eigen::VectorXd noise = random_vector(3 * columns * rows, seed);
    int t = 0;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const int a = j * columns + i, b = a + 1, c = a + columns, d = c + 1;
            mesh.vertices.row(a) << i + 0.5 * (j % 2) + 0.2 * noise[3 * a],
                std::sqrt(0.75) * j + 0.2 * noise[3 * a + 1], 0.2 * noise[3 * a + 2];
            if (i + 1 == columns || j + 1 == rows) continue;
            mesh.triangles.row(t++) << a, b, (j % 2 == 0 ? c : d);
            mesh.triangles.row(t++) << (j % 2 == 0 ? b : a), d, c;
        }
    return mesh;
}

/// Creases that touch no other.
std::vector<std::array<Vector3d, 2>> lone_creases(const TriMesh& mesh) {
    std::vector<std::array<Vector3d, 2>> alone;
    const auto before = creases_of(mesh, angle_deg);
    for (const auto& [a, b] : before) {
        int touching = 0;
        for (const auto& [p, q] : before) touching += p == a || q == a || p == b || q == b;
        if (touching == 1) alone.push_back({a, b});
    }
    return alone;
}

int count_lost(const std::vector<std::array<Vector3d, 2>>& creases, const TriMesh& result, double degrees) {
    const auto after = creases_of(result, degrees);
    int lost = 0;
    for (const auto& [a, b] : creases)
        lost += std::max({distance(a, after), distance(0.5 * (a + b), after), distance(b, after)}) > 1e-9;
    return lost;
}

TEST(RemeshCreases, SingleEdgesThatEndInTheOpenKeepTheirFold) {
    const TriMesh mesh = rough_plate(80, 70, 17);
    const auto alone = lone_creases(mesh);
    ASSERT_GT(alone.size(), 10u);
    for (const double length : {0.95, 1.0}) {
        const RemeshResult result = remesh(mesh, {.edge_length = length, .angle_deg = angle_deg});
        EXPECT_EQ(count_lost(alone, result.mesh, angle_deg - 1e-6), 0) << "of " << alone.size() << " at " << length;
        EXPECT_EQ(result.kept_edges, 0);
        EXPECT_GT(shape_of(result.mesh).smallest, 0.2);
    }
}

TEST(RemeshCreases, SingleEdgesAmongTrianglesOfAnotherLengthAreStillFolded) {
    const TriMesh mesh = rough_plate(80, 70, 17);
    const auto alone = lone_creases(mesh);
    for (const double length : {0.7, 1.3}) {
        const RemeshResult result = remesh(mesh, {.edge_length = length, .angle_deg = angle_deg});
        EXPECT_EQ(count_lost(alone, result.mesh, 0.5 * angle_deg), 0) << "of " << alone.size() << " at " << length;
        EXPECT_GT(shape_of(result.mesh).smallest, 0.2);
    }
}
