#include "cases/geometry/dirty_body.hpp"

#include "cases/geometry/closed_body.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

namespace strake::example {
namespace {

using Eigen::Matrix3d;
using Eigen::RowVector3d;
using Eigen::RowVector3i;
using Eigen::Vector3d;

/// Numbers in [-1, 1] that are the same with every library.
class Random {
public:
    explicit Random(unsigned seed) : next_(seed) {}
    double operator()() { return static_cast<double>(next_() >> 8) / (1 << 23) - 1; }
    bool is_hit(double share) { return (*this)() < 2 * share - 1; }

private:
    std::mt19937 next_;
};

class Soup {
public:
    int point(const Vector3d& x) {
        points_.push_back(x);
        return static_cast<int>(points_.size()) - 1;
    }
    void triangle(int a, int b, int c) { triangles_.push_back({a, b, c}); }
    /// A parallelogram of cells, oriented along u x v, with vertices of its own.
    void panel(const Vector3d& at, const Vector3d& u, const Vector3d& v, int cells_u, int cells_v) {
        const int first = static_cast<int>(points_.size());
        for (int j = 0; j <= cells_v; ++j)
            for (int i = 0; i <= cells_u; ++i) point(at + u * i / cells_u + v * j / cells_v);
        for (int j = 0; j < cells_v; ++j)
            for (int i = 0; i < cells_u; ++i) {
                const int a = first + j * (cells_u + 1) + i, c = a + cells_u + 2;
                triangle(a, a + 1, c);
                triangle(a, c, c - 1);
            }
    }
    TriMesh mesh() const {
        TriMesh mesh;
        mesh.vertices.resize(static_cast<Eigen::Index>(points_.size()), 3);
        for (std::size_t i = 0; i < points_.size(); ++i) mesh.vertices.row(static_cast<Eigen::Index>(i)) = points_[i];
        mesh.triangles.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            mesh.triangles.row(static_cast<Eigen::Index>(t)) << triangles_[t][0], triangles_[t][1], triangles_[t][2];
        return mesh;
    }

private:
    std::vector<Vector3d> points_;
    std::vector<std::array<int, 3>> triangles_;
};

/// One vertex for all at the same place.
TriMesh welded(const TriMesh& mesh) {
    std::map<std::array<double, 3>, int> known;
    std::vector<int> number(static_cast<std::size_t>(mesh.num_vertices()));
    TriMesh out = mesh;
    int count = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const auto [at, is_new] =
            known.try_emplace({mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2)}, count);
        if (is_new) out.vertices.row(count++) = mesh.vertices.row(v);
        number[static_cast<std::size_t>(v)] = at->second;
    }
    out.vertices.conservativeResize(count, 3);
    for (int& v : out.triangles.reshaped()) v = number[static_cast<std::size_t>(v)];
    return out;
}

/// A box about the origin; per direction its number of cells.
TriMesh box(const Vector3d& size, const std::array<int, 3>& cells) {
    Soup soup;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const Vector3d u = Vector3d::Unit(i) * size[i], v = Vector3d::Unit(j) * size[j];
        const Vector3d corner = -0.5 * size, other = corner + Vector3d::Unit(k) * size[k];
        soup.panel(other, u, v, cells[i], cells[j]);
        soup.panel(corner, v, u, cells[j], cells[i]);
    }
    TriMesh mesh = soup.mesh();
    // Faces meet to the last bit.
    mesh.vertices = (mesh.vertices.array() * 1048576).round() / 1048576;
    return welded(mesh);
}

/// A closed cylinder along x about the origin, rings of cells and caps of fans from their middles.
TriMesh cylinder(double radius, double length, int facets, int rings) {
    Soup soup;
    for (int i = 0; i <= rings; ++i)
        for (int k = 0; k < facets; ++k) {
            const double a = 2 * std::numbers::pi * k / facets;
            soup.point({length * (static_cast<double>(i) / rings - 0.5), radius * std::cos(a), radius * std::sin(a)});
        }
    for (int i = 0; i < rings; ++i)
        for (int k = 0; k < facets; ++k) {
            const int a = i * facets + k, b = i * facets + (k + 1) % facets;
            soup.triangle(a, b + facets, a + facets);
            soup.triangle(a, b, b + facets);
        }
    const int front = soup.point({-length / 2, 0, 0}), back = soup.point({length / 2, 0, 0});
    for (int k = 0; k < facets; ++k) {
        const int next = (k + 1) % facets;
        soup.triangle(front, next, k);
        soup.triangle(back, rings * facets + k, rings * facets + next);
    }
    return soup.mesh();
}

TriMesh placed(TriMesh mesh, const Vector3d& at, const Vector3d& turn = Vector3d::Zero()) {
    const double angle = turn.norm();
    const Matrix3d R =
        angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Matrix3d(Matrix3d::Identity());
    mesh.vertices = (mesh.vertices * R.transpose()).rowwise() + at.transpose();
    return mesh;
}

/// The parts one after another, each a named group.
TriMesh together(const std::vector<std::pair<std::string, TriMesh>>& parts) {
    TriMesh all;
    for (const auto& [name, part] : parts) {
        const int first = all.num_vertices(), row = all.num_triangles();
        all.vertices.conservativeResize(first + part.num_vertices(), 3);
        all.vertices.bottomRows(part.num_vertices()) = part.vertices;
        all.triangles.conservativeResize(row + part.num_triangles(), 3);
        all.triangles.bottomRows(part.num_triangles()) = part.triangles.array() + first;
        all.group.insert(all.group.end(), static_cast<std::size_t>(part.num_triangles()),
                         static_cast<int>(all.group_names.size()));
        all.group_names.push_back(name);
    }
    return all;
}

TriMesh keep_triangles(const TriMesh& mesh, const std::function<bool(int)>& is_kept) {
    TriMesh out = mesh;
    int count = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (is_kept(t)) out.triangles.row(count++) = mesh.triangles.row(t);
    out.triangles.conservativeResize(count, 3);
    out.group.clear();
    out.group_names.clear();
    return out;
}

void turn_over(TriMesh& mesh, int t) { std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2)); }

TriMesh crossing_boxes(Random& random) {
    return together({{"hull", box({4, 1, 0.6}, {24, 6, 4})},
                     {"cabin", placed(box({1.4, 0.8, 0.8}, {8, 5, 5}), {0.2 + 0.2 * random(), 0, 0.4 + 0.05 * random()},
                                      {0, 0.05 * random(), 0})},
                     {"fin", placed(box({0.8, 0.1, 1.0}, {6, 1, 8}), {1.4, 0.02 * random(), 0.6})}});
}

TriMesh crossing_cylinders(Random& random) {
    const auto store = [&](double side) {
        return placed(cylinder(0.15, 1.6, 16, 12), {0.3 + 0.2 * random(), side * (0.45 + 0.03 * random()), -0.1});
    };
    return together({{"body", cylinder(0.5, 4, 32, 30)},
                     {"left_store", store(-1)},
                     {"right_store", store(1)},
                     {"mast", placed(cylinder(0.1, 1, 12, 8), {-0.6, 0, 0.7}, {0, std::numbers::pi / 2, 0})}});
}

TriMesh wing_through_body(Random& random) {
    TriMesh body = tube(1600, {4, 0.35, 0.35});
    body.vertices.col(0).array() -= 2;
    return together({{"fuselage", body},
                     {"wing", placed(superellipsoid(1200, {{0.5, 2.0, 0.06}, 2.2}), {0.1 * random(), 0, -0.05},
                                     {0, 0.03 * random(), 0})},
                     {"tail", placed(superellipsoid(400, {{0.25, 0.7, 0.03}, 2.2}), {1.6, 0, 0.05})},
                     {"fin", placed(superellipsoid(400, {{0.25, 0.03, 0.5}, 2.2}), {1.6, 0, 0.3})}});
}

/// Facets that span the whole length, and caps whose triangles meet in one vertex of the rim.
TriMesh cad_slivers(Random& random) {
    constexpr int facets = 180;
    const auto radius = [&](double s) { return 0.45 * std::sqrt(std::max(0.0, 1 - std::pow(2 * s - 1, 4))) + 0.05; };
    std::vector<double> stations{0};
    for (int i = 1; i < 8; ++i) stations.push_back(i / 8.0 + 0.03 * random());
    stations.insert(stations.end(), {0.5005, 1});
    std::sort(stations.begin(), stations.end());
    Soup soup;
    for (const double s : stations)
        for (int k = 0; k < facets; ++k) {
            const double a = 2 * std::numbers::pi * k / facets;
            soup.point({4 * s - 2, radius(s) * std::cos(a), radius(s) * std::sin(a)});
        }
    const int rows = static_cast<int>(stations.size());
    for (int i = 0; i + 1 < rows; ++i)
        for (int k = 0; k < facets; ++k) {
            const int a = i * facets + k, b = i * facets + (k + 1) % facets;
            soup.triangle(a, b + facets, a + facets);
            soup.triangle(a, b, b + facets);
        }
    for (int k = 1; k + 1 < facets; ++k) {
        soup.triangle(0, k + 1, k);
        soup.triangle((rows - 1) * facets, (rows - 1) * facets + k, (rows - 1) * facets + k + 1);
    }
    return soup.mesh();
}

/// Cut across, the aft part moved away by a thousandth of the length.
TriMesh gaps(Random& random) {
    const TriMesh whole = superellipsoid(2000, {{2, 0.5, 0.4}, 2.3});
    const Points centre = triangle_centroids(whole);
    const double cut = 0.3 * random();
    const TriMesh fore = keep_triangles(whole, [&](int t) { return centre(t, 0) < cut; });
    return together(
        {{"fore", fore},
         {"aft", placed(keep_triangles(whole, [&](int t) { return centre(t, 0) >= cut; }), {0.004, 0, 0})}});
}

/// Panels with cells of their own, which meet along the edges of a box.
TriMesh t_junctions(Random& random) {
    Soup soup;
    const Vector3d size(4, 1, 0.7);
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const Vector3d u = Vector3d::Unit(i) * size[i], v = Vector3d::Unit(j) * size[j];
        const auto cells = [&](int axis) {
            return static_cast<int>(std::lround(7 * size[axis] * (1.2 + 0.4 * random())));
        };
        const int nu = cells(i), nv = cells(j), mu = cells(i) + 1, mv = cells(j) + 1;
        soup.panel(-0.5 * size + Vector3d::Unit(k) * size[k], u, v, nu, nv);
        soup.panel(-0.5 * size, v, u, mv, mu);
    }
    return soup.mesh();
}

TriMesh flipped_parts(Random& random) {
    TriMesh mesh = crossing_boxes(random);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (mesh.group[static_cast<std::size_t>(t)] == 1) turn_over(mesh, t);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (mesh.group[static_cast<std::size_t>(t)] == 0 && random.is_hit(0.1)) turn_over(mesh, t);
    return mesh;
}

TriMesh doubled_faces(Random& random) {
    const TriMesh body = superellipsoid(1500, {{2, 0.6, 0.4}, 3});
    const TriMesh twice = keep_triangles(body, [&](int) { return random.is_hit(0.2); });
    return together({{"body", body}, {"copies", twice}});
}

TriMesh holes(Random& random) {
    const TriMesh body = superellipsoid(2500, {{2, 0.6, 0.45}, 2.5});
    const Points centre = triangle_centroids(body);
    std::vector<RowVector3d> middles;
    for (int k = 0; k < 5; ++k)
        middles.push_back(centre.row(static_cast<int>((0.5 + 0.499 * random()) * body.num_triangles())));
    return keep_triangles(body, [&](int t) {
        return std::none_of(middles.begin(), middles.end(),
                            [&](const RowVector3d& at) { return (centre.row(t) - at).norm() < 0.12; });
    });
}

/// Two walls inside whose edges are those of the hull.
TriMesh inner_walls(Random&) {
    TriMesh hull = box({4, 1, 0.75}, {16, 4, 3});
    Soup walls;
    for (const double x : {-0.5, 1.0}) walls.panel({x, -0.5, -0.375}, {0, 1, 0}, {0, 0, 0.75}, 4, 3);
    return welded(together({{"hull", hull}, {"walls", walls.mesh()}}));
}

/// Edges with a vertex in their middle on one side only, a triangle of no area between.
TriMesh zero_areas(Random& random) {
    TriMesh mesh = superellipsoid(1500, {{2, 0.55, 0.4}, 2.5});
    const int m = mesh.num_triangles();
    std::vector<std::array<int, 3>> more;
    std::vector<Vector3d> points;
    for (int t = 0; t < m; ++t) {
        if (!random.is_hit(0.15)) continue;
        const int a = mesh.triangles(t, 0), b = mesh.triangles(t, 1), c = mesh.triangles(t, 2);
        const int d = mesh.num_vertices() + static_cast<int>(points.size());
        points.emplace_back(0.5 * (mesh.vertices.row(a) + mesh.vertices.row(b)));
        mesh.triangles.row(t) << a, d, c;
        more.push_back({d, b, c});
        more.push_back({a, b, d});
    }
    const int n = mesh.num_vertices();
    mesh.vertices.conservativeResize(n + static_cast<int>(points.size()), 3);
    for (std::size_t k = 0; k < points.size(); ++k) mesh.vertices.row(n + static_cast<int>(k)) = points[k];
    mesh.triangles.conservativeResize(m + static_cast<int>(more.size()), 3);
    for (std::size_t k = 0; k < more.size(); ++k)
        mesh.triangles.row(m + static_cast<int>(k)) << more[k][0], more[k][1], more[k][2];
    return mesh;
}

TriMesh rough_cut(Random& random) {
    TriMesh body = superellipsoid(2500, {{2, 0.6, 0.45}, 2.5});
    const Points centre = triangle_centroids(body);
    TriMesh half = keep_triangles(body, [&](int t) { return centre(t, 1) > 0; });
    const double depth = 2e-5 * box_diagonal(body);
    const auto away = [](double r) { return 0.7 * r + (r < 0 ? -0.3 : 0.3); };  // no vertex lies on the plane
    for (int v = 0; v < half.num_vertices(); ++v)
        if (std::abs(half.vertices(v, 1)) < 1e-12) half.vertices(v, 1) = depth * away(random());
    std::vector<int> number(static_cast<std::size_t>(half.num_vertices()), -1);
    TriMesh out;
    out.triangles = half.triangles;
    out.vertices.resize(half.num_vertices(), 3);
    int count = 0;
    for (int& v : out.triangles.reshaped<Eigen::RowMajor>()) {
        int& at = number[static_cast<std::size_t>(v)];
        if (at < 0) {
            out.vertices.row(count) = half.vertices.row(v);
            at = count++;
        }
        v = at;
    }
    out.vertices.conservativeResize(count, 3);
    return out;
}

using Maker = TriMesh (*)(Random&);
const std::vector<std::pair<std::string, Maker>>& makers() {
    static const std::vector<std::pair<std::string, Maker>> all{
        {"crossing_boxes", crossing_boxes},
        {"crossing_cylinders", crossing_cylinders},
        {"wing_through_body", wing_through_body},
        {"cad_slivers", cad_slivers},
        {"gaps", gaps},
        {"t_junctions", t_junctions},
        {"flipped_parts", flipped_parts},
        {"doubled_faces", doubled_faces},
        {"holes", holes},
        {"inner_walls", inner_walls},
        {"zero_areas", zero_areas},
        {"rough_cut", rough_cut},
    };
    return all;
}

}  // namespace

const std::vector<std::string>& dirty_body_kinds() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const auto& [name, make] : makers()) all.push_back(name);
        return all;
    }();
    return names;
}

TriMesh dirty_body(const std::string& kind, unsigned seed) {
    for (const auto& [name, make] : makers())
        if (name == kind) {
            Random random(seed);
            return make(random);
        }
    throw InvalidInput(text("dirty_body: there is no kind '", kind, "'"));
}

}  // namespace strake::example
