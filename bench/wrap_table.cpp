// How a wrap carries bodies: wrap_table FILE|KIND...   (a kind of make_surface; none: all twelve)
// Each row: seconds of CPU for wrap, remeshing, binding and one B u, B^T g; then, for motions of 5 % of the diagonal D
// that are known exactly, given to the wrap's vertices: the body's farthest vertex from the exact motion over D, the
// change of its dihedral angles beyond those of the exact motion (degrees, rms), the largest error of gaps between
// vertices of different parts that are within 1 % of D of each other, and pairs of triangles that intersect
// and did not at rest, carried and under the exact motion; of these, those that do more than touch.
#include "bench/dirty_bodies.hpp"
#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/point_tree.hpp"
#include "core/mesh/topology.hpp"
#include "core/wrap/wrap_map.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <numbers>
#include <vector>

using namespace strake;

namespace {

constexpr double size = 0.05;  ///< of the motions, in diagonals
/// Diagonals by which pairs that touch may pass into each other: coplanar triangles in contact do, by one motion or the
/// other, as their surface bends between their vertices.
constexpr double touch = 1e-6;
constexpr double near = 0.01;  ///< diagonals: parts next to each other

using Motion = std::function<Points(const Points& x)>;  ///< of points in diagonals, about the middle of the body

std::vector<std::pair<const char*, Motion>> motions() {
    return {{"bend",
             [](const Points& x) {
                 Points u = Points::Zero(x.rows(), 3);
                 u.col(2) = 4 * size * x.col(0).array().square();
                 return u;
             }},
            {"twist",
             [](const Points& x) {
                 Points u(x.rows(), 3);
                 for (Eigen::Index v = 0; v < x.rows(); ++v) {
                     const double angle = 4 * size * x(v, 0), c = std::cos(angle) - 1, s = std::sin(angle);
                     u.row(v) << 0, c * x(v, 1) - s * x(v, 2), s * x(v, 1) + c * x(v, 2);
                 }
                 return u;
             }},
            {"taper",
             [](const Points& x) {
                 Points u = x.array().colwise() * (4 * size * x.col(0).array());
                 u.col(0).setZero();
                 return u;
             }},
            {"bump", [](const Points& x) {
                 constexpr double width = 0.3;
                 Points u = Points::Zero(x.rows(), 3);
                 u.col(2) = size * (-x.rowwise().squaredNorm().array() / (width * width)).exp();
                 return u;
             }}};
}

double dihedral_at(const TriMesh& mesh, const std::vector<int>& sides) {
    const Eigen::Vector3d n = area_vector(mesh, sides[0]).normalized(), m = area_vector(mesh, sides[1]).normalized();
    return dihedral(n, m);
}

/// Degrees, rms over edges whose triangles are no slivers.
double roughness(const TriMesh& rest, const Adjacency& adjacent, const TriMesh& exact, const TriMesh& carried) {
    constexpr double sliver = 1e-3;
    double sum = 0, count = 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (!adjacent.is_regular(e)) continue;
        const auto& both = adjacent.edge_triangles[e];
        bool is_sliver = false;
        for (const int t : both) {
            double longest = 0;
            for (int k = 0; k < 3; ++k)
                longest = std::max(longest, (rest.vertices.row(rest.triangles(t, k)) -
                                             rest.vertices.row(rest.triangles(t, (k + 1) % 3)))
                                                .squaredNorm());
            is_sliver |= 2 * area_vector(rest, t).norm() < sliver * longest;
        }
        if (is_sliver) continue;
        const std::vector<int> sides(both.begin(), both.end());
        sum += std::pow(dihedral_at(carried, sides) - dihedral_at(exact, sides), 2);
        ++count;
    }
    return count > 0 ? std::sqrt(sum / count) * 180 / std::numbers::pi : 0;
}

/// How far one of two triangles that intersect must be shifted until they do not: by the axes that can part convex
/// bodies, normals of both planes, products of their edges, and edges' normals within the planes.
double shift_apart(const TriMesh& mesh, int t, int s) {
    std::array<Eigen::Matrix3d, 2> x, edge;  // columns
    std::vector<Eigen::Vector3d> axes;
    for (int side = 0; side < 2; ++side) {
        const Triangles::ConstRowXpr corner = mesh.triangles.row(side == 0 ? t : s);
        for (int k = 0; k < 3; ++k) x[side].col(k) = mesh.vertices.row(corner[k]).transpose();
        for (int k = 0; k < 3; ++k) edge[side].col(k) = x[side].col((k + 1) % 3) - x[side].col(k);
        const Eigen::Vector3d n = edge[side].col(0).cross(edge[side].col(1));
        axes.push_back(n);
        for (int k = 0; k < 3; ++k) axes.push_back(n.cross(edge[side].col(k)));
    }
    for (int k = 0; k < 9; ++k) axes.push_back(edge[0].col(k / 3).cross(edge[1].col(k % 3)));
    double shift = box_diagonal(mesh);
    for (const Eigen::Vector3d& axis : axes) {
        if (axis.norm() == 0) continue;
        const Eigen::RowVector3d n = axis.normalized().transpose(), of_t = n * x[0], of_s = n * x[1];
        shift = std::min({shift, of_t.maxCoeff() - of_s.minCoeff(), of_s.maxCoeff() - of_t.minCoeff()});
    }
    return std::max(0.0, shift);
}

/// Vertices of different parts that are next to each other, none farther than `near`.
std::vector<std::array<int, 2>> gaps(const TriMesh& mesh, const Adjacency& adjacent, double near) {
    std::vector<int> part(static_cast<std::size_t>(mesh.num_vertices()), -1);
    const std::vector<Sheet> sheets = sheets_of(mesh, adjacent);
    for (std::size_t s = 0; s < sheets.size(); ++s)
        for (const int t : sheets[s].triangles)
            for (const int v : mesh.triangles.row(t)) part[static_cast<std::size_t>(v)] = static_cast<int>(s);
    const PointTree tree(mesh.vertices);
    std::vector<std::array<int, 2>> found;
    std::vector<int> around;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        tree.within(mesh.vertices.row(v).transpose(), near, around);
        double least = near;
        int other = -1;
        for (const int w : around) {
            const double away = (mesh.vertices.row(w) - mesh.vertices.row(v)).norm();
            if (part[static_cast<std::size_t>(w)] != part[static_cast<std::size_t>(v)] && away <= least)
                least = away, other = w;
        }
        if (other >= 0) found.push_back({v, other});
    }
    return found;
}

/// The largest that a gap differs by, carried and under the exact motion.
double gap_change(const std::vector<std::array<int, 2>>& gaps, const Points& carried, const Points& exact) {
    double largest = 0;
    for (const auto& [v, w] : gaps)
        largest = std::max(largest, (carried.row(v) - carried.row(w) - exact.row(v) + exact.row(w)).norm());
    return largest;
}

struct NewPairs {
    int all = 0, deep = 0;
};

NewPairs new_pairs(const TriMesh& mesh, const std::vector<std::array<int, 2>>& at_rest, double depth) {
    NewPairs found;
    for (const auto& pair : self_intersections(mesh)) {
        if (std::ranges::binary_search(at_rest, pair)) continue;
        ++found.all;
        found.deep += shift_apart(mesh, pair[0], pair[1]) > depth;
    }
    return found;
}

double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void row(const std::string& name, const TriMesh& body) {
    const double diagonal = box_diagonal(body);
    const double begin = cpu();
    const Wrap wrap = wrap_around(body);
    const double wrapped = cpu();
    const WrapMap map(wrap.mesh, body);
    const double bound = cpu();
    const Box box = bounding_box(body);
    const Eigen::RowVector3d middle = 0.5 * (box.min + box.max).transpose();
    const auto scaled = [&](const Points& x) { return Points((x.rowwise() - middle) / diagonal); };
    const Adjacency adjacent = adjacency(body);
    auto at_rest = self_intersections(body);
    std::ranges::sort(at_rest);
    const auto apart = gaps(body, adjacent, near * diagonal);
    std::printf("%-28s %7d %6d alpha %4.1f %%, genus %d, attempts %d: wrap + remesh %5.1f s, binding %4.1f s\n",
                name.c_str(), body.num_triangles(), wrap.mesh.num_triangles(), 100 * wrap.alpha / diagonal, wrap.genus,
                wrap.attempts, wrapped - begin, bound - wrapped);
    for (const auto& [what, motion] : motions()) {
        const Points given = diagonal * motion(scaled(wrap.mesh.vertices)),
                     exact = diagonal * motion(scaled(body.vertices));
        const double then = cpu();
        const Points moved = map.displacement(given);
        const double there = cpu();
        map.transpose(moved);
        const double back = cpu();
        const TriMesh by_map = with_vertices(body, body.vertices + exact),
                      carried = with_vertices(body, body.vertices + moved);
        const NewPairs of_map = new_pairs(by_map, at_rest, touch * diagonal),
                       of_wrap = new_pairs(carried, at_rest, touch * diagonal);
        std::printf(
            "    %-6s off %8.1e D, roughness %6.3f deg, gaps %8.1e D off, new intersections %d (exact %d), "
            "deeper than a touch %d (%d); B u %5.3f s, B^T g %5.3f s\n",
            what, (moved - exact).rowwise().norm().maxCoeff() / diagonal, roughness(body, adjacent, by_map, carried),
            gap_change(apart, moved, exact) / diagonal, of_wrap.all, of_map.all, of_wrap.deep, of_map.deep,
            there - then, back - there);
    }
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) { return table_of_bodies(argc, argv, example::dirty_body_kinds(), row); }
