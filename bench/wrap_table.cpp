// How a wrap carries bodies: wrap_table FILE|KIND...   (a kind of make_surface; none: all twelve)
// Each row: seconds of CPU for wrap, remeshing, binding and one B u, B^T g; then, for motions of 5 % of the diagonal D
// that are known exactly, given to the wrap's vertices: the body's farthest vertex from the exact motion over D, the
// change of its dihedral angles beyond those of the exact motion (degrees, rms), and intersecting pairs beyond those of
// the exact motion.
#include "bench/dirty_bodies.hpp"
#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/topology.hpp"
#include "core/wrap/wrap_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <numbers>

using namespace strake;

namespace {

constexpr double size = 0.05;  ///< of the motions, in diagonals

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
    std::printf("%-28s %7d %6d alpha %4.1f %%, genus %d, attempts %d: wrap + remesh %5.1f s, binding %4.1f s\n",
                name.c_str(), body.num_triangles(), wrap.mesh.num_triangles(), 100 * wrap.alpha / diagonal, wrap.genus,
                wrap.attempts, wrapped - begin, bound - wrapped);
    for (const auto& [what, motion] : motions()) {
        const Points of_wrap = diagonal * motion(scaled(wrap.mesh.vertices)),
                     exact = diagonal * motion(scaled(body.vertices));
        const double then = cpu();
        const Points moved = map.displacement(of_wrap);
        const double there = cpu();
        map.transpose(moved);
        const double back = cpu();
        const TriMesh by_map = with_vertices(body, body.vertices + exact),
                      carried = with_vertices(body, body.vertices + moved);
        const auto pairs = [](const TriMesh& mesh) { return static_cast<long>(self_intersections(mesh).size()); };
        std::printf("    %-6s off %8.1e D, roughness %6.3f deg, intersections %+ld; B u %5.3f s, B^T g %5.3f s\n", what,
                    (moved - exact).rowwise().norm().maxCoeff() / diagonal, roughness(body, adjacent, by_map, carried),
                    pairs(carried) - pairs(by_map), there - then, back - there);
    }
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) { return table_of_bodies(argc, argv, example::dirty_body_kinds(), row); }
