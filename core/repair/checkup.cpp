#include "core/repair/checkup.hpp"

#include "core/error.hpp"
#include "core/mesh/point_tree.hpp"
#include "core/mesh/weld.hpp"
#include "core/repair/open_vertices.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace strake {
namespace {

void check_input(const TriMesh& mesh) {
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (!mesh.vertices.row(v).allFinite()) throw InvalidInput(text("checkup: vertex ", v, " is not finite"));
    for (int i = 0; i < mesh.triangles.size(); ++i)
        if (mesh.triangles.data()[i] < 0 || mesh.triangles.data()[i] >= mesh.num_vertices())
            throw InvalidInput(text("checkup: triangle ", i / 3, " has vertex ", mesh.triangles.data()[i],
                                    ", limits 0 and ", mesh.num_vertices() - 1));
}

/// Tests all pairs of triangles around a vertex, or around several at one place: seconds up to this limit, hours for a
/// fan of a million.
bool pairs_are_affordable(const TriMesh& mesh, const Adjacency& adjacent) {
    std::vector<int> order(static_cast<std::size_t>(mesh.num_vertices()));
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](int v) {
        return std::array<double, 3>{mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2)};
    };
    std::sort(order.begin(), order.end(), [&](int a, int b) { return place(a) < place(b); });
    double pairs = 0, around = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i > 0 && place(order[i]) != place(order[i - 1])) around = 0;
        const auto more = static_cast<double>(adjacent.vertex_triangles[order[i]].size());
        pairs += 0.5 * more * more + around * more;
        around += more;
    }
    return pairs <= 1e8;
}

/// Plane through the points' mean with the least sum of squares of distances.
void fit_plane(const TriMesh& mesh, BoundaryLoop& loop) {
    Points p(static_cast<Eigen::Index>(loop.vertices.size()), 3);
    for (Eigen::Index i = 0; i < p.rows(); ++i) p.row(i) = mesh.vertices.row(loop.vertices[i]);
    loop.size = (p.colwise().maxCoeff() - p.colwise().minCoeff()).stableNorm();
    loop.center = p.colwise().mean();
    if (!(loop.size > 0)) return;
    const Points arms = (p.rowwise() - loop.center.transpose()) / loop.size;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(Eigen::Matrix3d(arms.transpose() * arms));
    loop.normal = axes.eigenvectors().col(0);
    Eigen::Index largest = 0;
    loop.normal.cwiseAbs().maxCoeff(&largest);
    if (loop.normal[largest] < 0) loop.normal = -loop.normal;
    loop.deviation = (arms * loop.normal).cwiseAbs().maxCoeff() * loop.size;
}

/// A coordinate plane that holds the whole loop and has all of the surface on one side.
void suggest_symmetry(const TriMesh& mesh, const Box& box, double diagonal, BoundaryLoop& loop) {
    for (int k = 0; k < 3 && loop.symmetry_axis < 0; ++k) {
        const double at = mesh.vertices(loop.vertices[0], k);
        bool is_in_plane = true;
        for (const int v : loop.vertices)
            is_in_plane = is_in_plane && std::abs(mesh.vertices(v, k) - at) <= 1e-6 * diagonal;
        const double below = at - box.min[k], above = box.max[k] - at;
        if (!is_in_plane || std::min(below, above) > 1e-6 * diagonal || std::max(below, above) <= 1e-6 * diagonal)
            continue;
        loop.symmetry_axis = k;
        loop.symmetry_at = std::abs(loop.center[k]) > 1e-9 * diagonal ? loop.center[k] : 0;  // the rest is rounding
    }
}

/// From p to the segment that starts at `from` and runs along `side`.
double distance_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& from, const Eigen::Vector3d& side) {
    const double along = side.squaredNorm() > 0 ? std::clamp((p - from).dot(side) / side.squaredNorm(), 0.0, 1.0) : 0;
    return (p - from - along * side).norm();
}

/// Vertices at open edges within the tolerance of another one, or of an open edge that is not theirs.
std::vector<int> find_crack_vertices(const TriMesh& mesh, const Adjacency& adjacent, double tolerance) {
    const mending::OpenVertices open = mending::open_vertices(mesh, adjacent);
    std::vector<char> is_cracked(open.is_open.size());
    std::vector<int> found;
    // Coinciding points are represented by one: a crowd of n would need n^2 tests.
    const std::vector<int> number = equal_points(open.points);
    std::vector<int> crowd(number.size());
    for (const int i : number) ++crowd[i];
    std::vector<int> first;
    for (std::size_t i = 0; i < number.size(); ++i) {
        if (crowd[number[i]] > 1) is_cracked[open.numbers[i]] = 1;
        if (number[i] == static_cast<int>(first.size())) first.push_back(static_cast<int>(i));
    }
    Points places(static_cast<Eigen::Index>(first.size()), 3);
    for (std::size_t i = 0; i < first.size(); ++i) places.row(static_cast<Eigen::Index>(i)) = open.points.row(first[i]);
    const PointTree tree(places);
    std::size_t left = mending::max_looked_at_for_cracks;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (adjacent.edge_triangles[e].size() != 1) continue;
        const auto [a, b] = adjacent.edges[e];
        const int t = adjacent.edge_triangles[e][0];
        const Eigen::Vector3d pa = mesh.vertices.row(a), pb = mesh.vertices.row(b), side = pb - pa;
        tree.near_segment(pa, pb, tolerance, found);
        if (found.size() > left) break;
        left -= found.size();
        for (const int i : found) {
            const int v = open.numbers[first[i]];
            if (v == a || v == b || (mesh.triangles.row(t).array() == v).any()) continue;
            if (distance_to_segment(mesh.vertices.row(v), pa, side) <= tolerance) is_cracked[v] = 1;
        }
    }
    std::vector<int> cracked;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (is_cracked[v]) cracked.push_back(v);
    return cracked;
}

bool is_copy(const TriMesh& mesh, int s, int t) {
    for (int k = 0; k < 3; ++k)
        if (!(mesh.triangles.row(t).array() == mesh.triangles(s, k)).any()) return false;
    return true;
}

std::vector<int> find_inverted(const TriMesh& mesh, const Adjacency& adjacent) {
    const Points normals = triangle_normals(mesh), angles = corner_angles(mesh);
    std::vector<char> is_folded(static_cast<std::size_t>(mesh.num_triangles()));
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (!adjacent.is_regular(e)) continue;
        const int s = adjacent.edge_triangles[e][0], t = adjacent.edge_triangles[e][1];
        if (is_copy(mesh, s, t)) continue;
        if (dihedral(normals.row(s), normals.row(t)) > 170 * std::numbers::pi / 180) is_folded[s] = is_folded[t] = 1;
    }
    Points sum = Points::Zero(mesh.num_vertices(), 3);
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(mesh.num_vertices());
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            sum.row(mesh.triangles(t, k)) += angles(t, k) * normals.row(t);
            weight[mesh.triangles(t, k)] += angles(t, k);
        }
    std::vector<int> inverted;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!is_folded[t]) continue;
        double along = 0;
        for (int k = 0; k < 3; ++k) {
            const int v = mesh.triangles(t, k);
            along += normals.row(t).dot(sum.row(v)) / std::max(weight[v], 1e-300);
        }
        if (along < -0.5) inverted.push_back(t);
    }
    return inverted;
}

/// Components whose every edge has two triangles that agree, with a negative volume.
int count_inward(const TriMesh& mesh, const Adjacency& adjacent) {
    const std::vector<int> component = edge_components(mesh, adjacent);
    const int count = component.empty() ? 0 : *std::max_element(component.begin(), component.end()) + 1;
    std::vector<char> is_closed(static_cast<std::size_t>(count), 1);
    std::vector<int> first(is_closed.size(), -1);
    std::vector<double> volume(is_closed.size());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const int c = component[t];
        if (first[c] < 0) first[c] = mesh.triangles(t, 0);
        for (int k = 0; k < 3; ++k)
            if (!adjacent.is_regular(adjacent.triangle_edges(t, k))) is_closed[c] = 0;
        const Eigen::Vector3d origin = mesh.vertices.row(first[c]);
        volume[c] += area_vector(mesh, t).dot(mesh.vertices.row(mesh.triangles(t, 0)).transpose() - origin);
    }
    int inward = 0;
    for (int c = 0; c < count; ++c) inward += is_closed[c] && volume[c] < 0;
    return inward;
}

}  // namespace

std::vector<BoundaryLoop> measured_loops(const TriMesh& mesh, const Adjacency& adjacent,
                                         const std::vector<std::vector<int>>& loops) {
    const Box box = bounding_box(mesh);
    const double diagonal = box_diagonal(mesh);
    std::vector<int> loop_of(static_cast<std::size_t>(mesh.num_vertices()), -1);
    std::vector<BoundaryLoop> measured;
    for (const auto& vertices : loops) {
        for (const int v : vertices) loop_of[v] = static_cast<int>(measured.size());
        BoundaryLoop loop;
        loop.vertices = vertices;
        fit_plane(mesh, loop);
        loop.is_planar = loop.deviation <= 1e-6 * diagonal;
        suggest_symmetry(mesh, box, diagonal, loop);
        measured.push_back(std::move(loop));
    }
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (const auto [a, b] = adjacent.edges[e]; adjacent.edge_triangles[e].size() == 1 && loop_of[a] >= 0)
            measured[loop_of[a]].length += (mesh.vertices.row(a) - mesh.vertices.row(b)).stableNorm();
    return measured;
}

Checkup checkup(const TriMesh& mesh) {
    check_input(mesh);
    Checkup c;
    c.vertices = mesh.num_vertices();
    c.triangles = mesh.num_triangles();
    c.adjacent = adjacency(mesh);
    c.facts = topology(mesh, c.adjacent);
    if (pairs_are_affordable(mesh, c.adjacent)) c.pairs = intersections(mesh);
    c.box = bounding_box(mesh);
    c.diagonal = box_diagonal(mesh);
    c.area = surface_area(mesh);
    c.volume = enclosed_volume(mesh);
    c.loops = measured_loops(mesh, c.adjacent, c.facts.boundary_loops);
    c.crack_vertices = find_crack_vertices(mesh, c.adjacent, 1e-5 * c.diagonal);
    c.inverted_triangles = find_inverted(mesh, c.adjacent);
    c.inward_components = count_inward(mesh, c.adjacent);
    c.quality = surface_quality(mesh, c.adjacent);
    return c;
}

}  // namespace strake
