#include "core/primo/rest_state.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/primo/prism_order.hpp"

namespace strake {
namespace {

std::string first_few(const std::vector<int>& numbers) {
    std::string list;
    for (std::size_t i = 0; i < numbers.size() && i < 5; ++i) list += (i ? ", " : "") + std::to_string(numbers[i]);
    return list + (numbers.size() > 5 ? ", …" : "");
}

void check(const TriMesh& mesh, const ShellOptions& options, const Adjacency& adjacent, double diagonal) {
    const int m = mesh.num_triangles();
    if (m == 0) throw InvalidInput("shell: the surface has no triangles");
    if (!mesh.vertices.allFinite()) throw InvalidInput("shell: a vertex coordinate is not finite");
    if (options.prism_height.size() != mesh.num_vertices())
        throw InvalidInput(
            text("shell: ", options.prism_height.size(), " prism heights for ", mesh.num_vertices(), " vertices"));
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (!(options.prism_height[v] > 0) || !std::isfinite(options.prism_height[v]))
            throw InvalidInput(text("shell: prism height ", options.prism_height[v], " at vertex ", v, " must be > 0"));
    if (!options.pin.empty() && static_cast<int>(options.pin.size()) != m)
        throw InvalidInput(text("shell: ", options.pin.size(), " pin values for ", m, " triangles"));
    std::vector<int> degenerate, nonmanifold;
    const Eigen::VectorXd areas = triangle_areas(mesh);
    for (int t = 0; t < m; ++t)
        if (!(areas[t] >= 1e-14 * diagonal * diagonal)) degenerate.push_back(t);
    if (!degenerate.empty())
        throw InvalidInput(text("shell: ", degenerate.size(),
                                " degenerate triangles (area below 1e-14 of the squared diagonal): ",
                                first_few(degenerate), "; remove them first"));
    if (options.couple_nonmanifold) return;
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (adjacent.edge_triangles[e].size() > 2) nonmanifold.push_back(e);
    if (nonmanifold.empty()) return;
    const auto& edge = adjacent.edges[nonmanifold[0]];
    throw InvalidInput(text("shell: ", nonmanifold.size(), " edges of more than two triangles (first: vertices ",
                            edge[0], " and ", edge[1], "); split them, or set shell: {nonmanifold: couple}"));
}

void check_plane(const SymmetryPlane& plane) {
    if (!(std::abs(plane.normal.norm() - 1) < 1e-9) || !std::isfinite(plane.offset))
        throw InvalidInput("shell: the symmetry plane needs a unit normal and a finite offset");
}

/// Vertices that lie on the plane; an edge is mirrored when both of its ends do.
std::vector<char> vertices_on_plane(const TriMesh& mesh, const SymmetryPlane& plane, double tolerance) {
    std::vector<char> on(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v)
        on[v] = std::abs(plane.normal.dot(mesh.vertices.row(v)) - plane.offset) <= tolerance;
    return on;
}

/// Vertices of boundary edges that lie on the symmetry plane.
std::vector<char> symmetric_vertices(const TriMesh& mesh, const Adjacency& adjacent, const SymmetryPlane& plane,
                                     double diagonal) {
    const std::vector<char> on = vertices_on_plane(mesh, plane, 1e-6 * diagonal);
    std::vector<char> symmetric(mesh.num_vertices(), 0);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto [a, b] = adjacent.edges[e];
        if (adjacent.edge_triangles[e].size() == 1 && on[a] && on[b]) symmetric[a] = symmetric[b] = 1;
    }
    return symmetric;
}

/// Angle-weighted unit normals; zero where the weighted sum is shorter than 1e-6 (opposite triangles cancel).
Points vertex_normals(const RestState& rest) {
    const Points angles = corner_angles(rest.mesh), normals = triangle_normals(rest.mesh);
    Points sum = Points::Zero(rest.mesh.num_vertices(), 3);
    for (int t = 0; t < rest.num_prisms(); ++t)
        for (int k = 0; k < 3; ++k) sum.row(rest.mesh.triangles(t, k)) += angles(t, k) * normals.row(t);
    for (int v = 0; v < sum.rows(); ++v) {
        if (rest.on_plane[v]) sum.row(v) = (rest.plane_projector * sum.row(v).transpose()).transpose();
        const double length = sum.row(v).norm();
        sum.row(v) = length < 1e-6 ? Eigen::RowVector3d::Zero() : Eigen::RowVector3d(sum.row(v) / length);
    }
    return sum;
}

/// Fills the Gauss arms of a face over the edge (a, b), seen from the centroid of prism i.
Arms face_arms(const RestState& rest, const std::array<int, 2>& edge, const std::array<Eigen::Vector3d, 2>& normal,
               int i) {
    Arms arms;
    for (int g = 0; g < 4; ++g) {
        const auto [u, z] = gauss_points()[g];
        arms.set(g, (1 - u) * (rest.vertex_arm(edge[0], i) + 0.5 * z * rest.height[edge[0]] * normal[0]) +
                        u * (rest.vertex_arm(edge[1], i) + 0.5 * z * rest.height[edge[1]] * normal[1]));
    }
    return arms;
}

/// The face's extrusion directions: the vertex normals, or the normal of prism i where they cancel.
std::array<Eigen::Vector3d, 2> face_normals(const RestState& rest, const std::array<int, 2>& edge, int i) {
    return {corner_normal(rest, edge[0], i), corner_normal(rest, edge[1], i)};
}

void add_faces(RestState& rest, const Adjacency& adjacent) {
    rest.faces.reserve(adjacent.num_edges());
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto triangles = adjacent.edge_triangles[e];
        const std::array<int, 2> edge = adjacent.edges[e];
        const double length2 = (rest.mesh.vertices.row(edge[0]) - rest.mesh.vertices.row(edge[1])).squaredNorm();
        for (std::size_t p = 0; p < triangles.size(); ++p)
            for (std::size_t q = p + 1; q < triangles.size(); ++q) {
                const int i = triangles[p], j = triangles[q];
                const auto normal = face_normals(rest, edge, i);
                rest.faces.push_back({i, j, length2 / (rest.area[i] + rest.area[j]), face_arms(rest, edge, normal, i),
                                      face_arms(rest, edge, normal, j), edge, normal});
            }
        if (triangles.size() == 1 && rest.on_plane[edge[0]] && rest.on_plane[edge[1]]) {
            const int i = triangles[0];
            const auto normal = face_normals(rest, edge, i);
            rest.mirrored.push_back({i, length2 / (2 * rest.area[i]), face_arms(rest, edge, normal, i), edge, normal});
        }
    }
}

/// A fixed prism fixes its vertices; otherwise strain-pinned prisms drive them; otherwise
/// all prisms share.
void add_vertex_map(RestState& rest, const Adjacency& adjacent) {
    const int n = rest.mesh.num_vertices();
    rest.fixed_vertex.assign(n, 0);
    for (int v = 0; v < n; ++v) {
        bool strained = false;
        for (const int t : adjacent.vertex_triangles[v]) {
            if (rest.pin[t] == fixed_prism) rest.fixed_vertex[v] = 1;
            if (rest.pin[t] > 0) strained = true;
        }
        if (!rest.fixed_vertex[v])
            for (const int t : adjacent.vertex_triangles[v])
                if (!strained || rest.pin[t] > 0) rest.vertex_prisms.items.push_back(t);
        rest.vertex_prisms.begin.push_back(static_cast<int>(rest.vertex_prisms.items.size()));
    }
}

/// Lists per row, ascending; `for_all(add)` calls add(row, item) for all items and runs twice.
template <class ForAll>
IntLists lists_by_row(int rows, const ForAll& for_all) {
    IntLists lists;
    lists.begin.assign(rows + 1, 0);
    for_all([&](int row, int) { ++lists.begin[row + 1]; });
    for (int r = 0; r < rows; ++r) lists.begin[r + 1] += lists.begin[r];
    std::vector<int> next(lists.begin.begin(), lists.begin.end() - 1);
    lists.items.resize(lists.begin[rows]);
    for_all([&](int row, int item) { lists.items[next[row]++] = item; });
    return lists;
}

/// Fills `face_groups` from `faces`.
void group_faces(RestState& rest) {
    std::vector<int> owner(rest.num_prisms(), -1);
    const IntLists crossing = lists_by_row(rest.num_prisms(), [&](const auto& add) {
        for (int f = 0; f < static_cast<int>(rest.faces.size()); ++f)
            for (const int side : {0, 1}) {
                const int i = side == 0 ? rest.faces[f].i : rest.faces[f].j;
                if (owner[i] < 0) owner[i] = f / FaceGroups::faces;
                if (owner[i] != f / FaceGroups::faces) add(i, 2 * f + side);
            }
    });
    FaceGroups& groups = rest.face_groups;
    groups.apart.assign(rest.faces.size(), {-1, -1});
    for (int i = 0; i < rest.num_prisms(); ++i) {
        if (i % FaceGroups::prisms == 0) groups.begin.push_back(static_cast<int>(groups.prism.size()));
        for (const int item : crossing[i]) {
            groups.apart[item / 2][item % 2] = static_cast<int>(groups.prism.size());
            groups.prism.push_back(i);
        }
    }
    groups.begin.push_back(static_cast<int>(groups.prism.size()));
}

}  // namespace

const std::array<GaussPoint, 4>& gauss_points() {
    static const double s = 1 / std::sqrt(3.0);
    static const std::array<GaussPoint, 4> points{
        {{0.5 - 0.5 * s, -s}, {0.5 - 0.5 * s, s}, {0.5 + 0.5 * s, -s}, {0.5 + 0.5 * s, s}}};
    return points;
}

Eigen::Vector3d corner_normal(const RestState& rest, int v, int i) {
    if (rest.normal.row(v).squaredNorm() > 0) return rest.normal.row(v).transpose();
    const Eigen::Vector3d own = area_vector(rest.mesh, i).normalized();
    return rest.on_plane[v] ? Eigen::Vector3d((rest.plane_projector * own).normalized()) : own;
}

void list_by_prism(RestState& rest) {
    group_faces(rest);
    rest.prism_vertices = lists_by_row(rest.num_prisms(), [&](const auto& add) {
        for (int k = 0; k < rest.mesh.num_vertices(); ++k)
            for (const int i : rest.vertex_prisms[k]) add(i, k);
    });
}

RestState rest_state(const TriMesh& mesh, const ShellOptions& options) {
    const Adjacency adjacent = adjacency(mesh);
    RestState rest;
    rest.diagonal = box_diagonal(mesh);
    check(mesh, options, adjacent, rest.diagonal);
    rest.mesh = mesh;
    rest.centroid = triangle_centroids(mesh);
    rest.area = triangle_areas(mesh);
    rest.height = options.prism_height;
    const int m = mesh.num_triangles();
    rest.pin = options.pin.empty() ? std::vector<int>(m, free_prism) : options.pin;
    rest.attached = options.attached;
    if (options.attached)
        for (int t = 0; t < m; ++t)
            if (options.attached->part_of().at(t) >= 0) rest.pin[t] = fixed_prism;
    rest.on_plane.assign(mesh.num_vertices(), 0);
    if (options.symmetry) {
        check_plane(*options.symmetry);
        rest.symmetry = options.symmetry;
        rest.plane_projector -= options.symmetry->normal * options.symmetry->normal.transpose();
        rest.on_plane = symmetric_vertices(mesh, adjacent, *options.symmetry, rest.diagonal);
    }
    rest.prism_height.resize(m);
    rest.prism_radius.resize(m);
    rest.free_index.assign(m, -1);
    for (int t = 0; t < m; ++t) {
        rest.prism_height[t] = 0;
        rest.prism_radius[t] = 0;
        for (int k = 0; k < 3; ++k) {
            const int v = mesh.triangles(t, k);
            rest.prism_height[t] += rest.height[v] / 3;
            rest.prism_radius[t] = std::max(rest.prism_radius[t], rest.vertex_arm(v, t).norm() + rest.height[v] / 2);
        }
        if (rest.pin[t] != free_prism) continue;
        rest.free_index[t] = rest.num_free();
        rest.free_prisms.push_back(t);
    }
    rest.normal = vertex_normals(rest);
    add_faces(rest, adjacent);
    order_locally(rest);
    add_vertex_map(rest, adjacent);
    list_by_prism(rest);
    return rest;
}

Points traction_forces(const TriMesh& rest, const Points& traction) {
    if (traction.rows() != rest.num_triangles())
        throw InvalidInput(
            text("traction_forces: ", traction.rows(), " tractions for ", rest.num_triangles(), " triangles"));
    Points force = Points::Zero(rest.num_vertices(), 3);
    for (int t = 0; t < rest.num_triangles(); ++t) {
        if ((traction.row(t).array() == 0).all()) continue;
        const Eigen::RowVector3d share = traction.row(t) * (area_vector(rest, t).stableNorm() / 3);
        for (int k = 0; k < 3; ++k) force.row(rest.triangles(t, k)) += share;
    }
    return force;
}

Eigen::VectorXd vertex_heights(const TriMesh& mesh, const Eigen::VectorXd& triangle_height) {
    if (triangle_height.size() != mesh.num_triangles())
        throw InvalidInput(
            text("vertex_heights: ", triangle_height.size(), " heights for ", mesh.num_triangles(), " triangles"));
    if (!(triangle_height.array() > 0).all()) throw InvalidInput("vertex_heights: heights must be > 0");
    const Eigen::VectorXd areas = triangle_areas(mesh);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.num_vertices()), weight = sum;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            sum[mesh.triangles(t, k)] += areas[t] * std::log(triangle_height[t]);
            weight[mesh.triangles(t, k)] += areas[t];
        }
    // A vertex of no triangle carries no prism; any positive height will do.
    for (int v = 0; v < sum.size(); ++v) sum[v] = weight[v] > 0 ? std::exp(sum[v] / weight[v]) : triangle_height.mean();
    return sum;
}

}  // namespace strake
