#include "core/primo/coarse_shell.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/parallel.hpp"
#include "core/primo/energy.hpp"

namespace strake {
namespace {

constexpr double strong = 0.25;              // of connections, relative to a prism's strongest
constexpr double min_share = 0.05;           // of a face parallel to the line between its centres
constexpr int coarse_prisms_at_once = 1024;  // per block of a parallel loop
constexpr int smoothing_sweeps = 6;          // roughly the radius of two clusters

using Eigen::Vector3d;

Vector3d row_of(const Points& points, int k) { return points.row(k).transpose(); }

/// Free prisms that share a face, and its weight.
Graph connections(const RestState& rest) {
    const int n = rest.num_free();
    Graph graph;
    graph.begin.assign(n + 1, 0);
    const auto each = [&](auto&& take) {
        for (const SharedFace& face : rest.faces)
            if (const int i = rest.free_index[face.i], j = rest.free_index[face.j]; i >= 0 && j >= 0)
                take(i, j, face.weight), take(j, i, face.weight);
    };
    each([&](int i, int, double) { ++graph.begin[i + 1]; });
    for (int i = 0; i < n; ++i) graph.begin[i + 1] += graph.begin[i];
    graph.neighbour.resize(graph.begin[n]);
    graph.strength.resize(graph.begin[n]);
    std::vector<int> at(graph.begin.begin(), graph.begin.end() - 1);
    each([&](int i, int j, double weight) {
        graph.neighbour[at[i]] = j;
        graph.strength[at[i]++] = static_cast<float>(weight);
    });
    return graph;
}

/// Numbers of the coarse prisms: clusters of free ones first, then one for each pinned region.
std::vector<int> numbers(const RestState& rest, const Graph& neighbours, int radius, std::vector<int>& pins) {
    const Clusters clusters = aggregate(strong_connections(neighbours, strong), radius);
    pins.assign(clusters.count, free_prism);
    std::map<int, int> region;
    std::vector<int> of(rest.num_prisms());
    for (int i = 0; i < rest.num_prisms(); ++i) {
        if (const int f = rest.free_index[i]; f >= 0) {
            of[i] = clusters.of[f];
            continue;
        }
        const auto [known, is_new] = region.try_emplace(rest.pin[i], static_cast<int>(pins.size()));
        if (is_new) pins.push_back(rest.pin[i]);
        of[i] = known->second;
    }
    return of;
}

/// Each vertex follows the coarse prisms of its prisms: a single one if they agree, else each as often as it occurs.
void add_vertices(const RestState& fine, CoarseShell& coarse) {
    IntLists& lists = coarse.rest.vertex_prisms;
    for (int k = 0; k < fine.mesh.num_vertices(); ++k) {
        const auto begin = static_cast<std::ptrdiff_t>(lists.items.size());
        for (const int i : fine.vertex_prisms[k]) lists.items.push_back(coarse.of[i]);
        const auto first = lists.items.begin() + begin;
        if (first != lists.items.end() && std::count(first, lists.items.end(), *first) == lists.items.end() - first)
            lists.items.erase(first + 1, lists.items.end());
        lists.begin.push_back(static_cast<int>(lists.items.size()));
    }
}

void add_prisms(const RestState& fine, CoarseShell& coarse) {
    RestState& rest = coarse.rest;
    const auto n = static_cast<Eigen::Index>(rest.pin.size());
    rest.centroid = Points::Zero(n, 3);
    rest.area = rest.prism_height = rest.prism_radius = Eigen::VectorXd::Zero(n);
    for (int i = 0; i < fine.num_prisms(); ++i) {
        const int c = coarse.of[i];
        rest.centroid.row(c) += fine.area[i] * fine.centroid.row(i);
        rest.prism_height[c] += fine.area[i] * fine.prism_height[i];
        rest.area[c] += fine.area[i];
    }
    rest.centroid = rest.area.cwiseInverse().asDiagonal() * rest.centroid;
    rest.prism_height = rest.prism_height.cwiseQuotient(rest.area);
    for (int i = 0; i < fine.num_prisms(); ++i) {
        const int c = coarse.of[i];
        const double reach = (fine.centroid.row(i) - rest.centroid.row(c)).norm() + fine.prism_radius[i];
        rest.prism_radius[c] = std::max(rest.prism_radius[c], reach);
    }
    rest.free_index.assign(n, -1);
    for (int c = 0; c < n; ++c) {
        if (rest.pin[c] != free_prism) continue;
        rest.free_index[c] = rest.num_free();
        rest.free_prisms.push_back(c);
    }
}

/// The same points as seen from the centre of the coarse prism.
Arms moved(const Arms& arms, const Vector3d& by) {
    Arms result;
    for (int g = 0; g < 4; ++g) result.set(g, arms[g] + by);
    return result;
}

void add_faces(const RestState& fine, CoarseShell& coarse) {
    RestState& rest = coarse.rest;
    const auto shift = [&](int i) -> Vector3d {
        return row_of(fine.centroid, i) - row_of(rest.centroid, coarse.of[i]);
    };
    // Pinned regions are large: use the prism at their border.
    const auto centre = [&](int i) {
        return rest.pin[coarse.of[i]] == free_prism ? row_of(rest.centroid, coarse.of[i]) : row_of(fine.centroid, i);
    };
    for (const SharedFace& face : fine.faces) {
        const int i = coarse.of[face.i], j = coarse.of[face.j];
        if (i == j) continue;
        const Vector3d along =
            (row_of(fine.mesh.vertices, face.vertex[1]) - row_of(fine.mesh.vertices, face.vertex[0])).normalized();
        Vector3d across = row_of(fine.centroid, face.j) - row_of(fine.centroid, face.i);
        across -= across.dot(along) * along;
        const Vector3d apart = centre(face.j) - centre(face.i);
        // No face becomes stiffer, not even where the centres coincide and the ratio is NaN.
        const double share =
            std::min(1.0, std::max(across.dot(apart) / apart.squaredNorm(), min_share * across.norm() / apart.norm()));
        SharedFace shared = face;
        shared.i = i;
        shared.j = j;
        shared.weight = face.weight * share;
        shared.arm_i = moved(face.arm_i, shift(face.i));
        shared.arm_j = moved(face.arm_j, shift(face.j));
        rest.faces.push_back(shared);
    }
    for (const MirroredFace& face : fine.mirrored) {
        MirroredFace mirrored = face;
        mirrored.i = coarse.of[face.i];
        const double before =
            std::abs(rest.symmetry->normal.dot(row_of(fine.centroid, face.i)) - rest.symmetry->offset);
        const double now =
            std::abs(rest.symmetry->normal.dot(row_of(rest.centroid, mirrored.i)) - rest.symmetry->offset);
        if (rest.pin[mirrored.i] == free_prism && now > before) mirrored.weight *= before / now;
        mirrored.arm = moved(face.arm, shift(face.i));
        rest.mirrored.push_back(mirrored);
    }
}

}  // namespace

CoarseShell coarsen(const RestState& fine, int radius) {
    CoarseShell coarse;
    RestState& rest = coarse.rest;
    coarse.neighbours = connections(fine);
    coarse.of = numbers(fine, coarse.neighbours, radius, rest.pin);
    rest.mesh = fine.mesh;
    rest.diagonal = fine.diagonal;
    rest.fixed_vertex = fine.fixed_vertex;
    rest.on_plane = fine.on_plane;
    rest.symmetry = fine.symmetry;
    rest.plane_projector = fine.plane_projector;
    add_vertices(fine, coarse);
    add_prisms(fine, coarse);
    add_faces(fine, coarse);
    list_by_prism(rest);
    return coarse;
}

Poses prolonged(const RestState& rest, const CoarseShell& shell, const RestState& coarse, const Poses& poses) {
    const int n = rest.num_prisms();
    const std::vector<Eigen::Matrix3d> turn = rotation_differences(poses);
    Poses fine{std::vector<Eigen::Quaterniond>(n), Points(n, 3)};
    for (int i = 0; i < n; ++i) {
        const int c = shell.of[i];
        fine.rotation[i] = poses.rotation[c];
        fine.displacement.row(i) =
            poses.displacement.row(c) + (turn[c] * (row_of(rest.centroid, i) - row_of(coarse.centroid, c))).transpose();
    }
    const Graph& graph = shell.neighbours;
    for (int sweep = 0; sweep < smoothing_sweeps; ++sweep) {
        const std::vector<Eigen::Matrix3d> now = rotation_differences(fine);
        const Poses before = fine;
        for_blocks(rest.num_free(), coarse_prisms_at_once, [&](int begin, int end) {
            for (int f = begin; f < end; ++f) {
                const int i = rest.free_prisms[f], count = graph.begin[f + 1] - graph.begin[f];
                Eigen::Vector4d rotation = before.rotation[i].coeffs();
                Vector3d displacement = row_of(before.displacement, i);
                for (int k = graph.begin[f]; k < graph.begin[f + 1]; ++k) {
                    const int j = rest.free_prisms[graph.neighbour[k]];
                    const Eigen::Vector4d other = before.rotation[j].coeffs();
                    rotation += other.dot(before.rotation[i].coeffs()) < 0 ? Eigen::Vector4d(-other) : other;
                    displacement +=
                        row_of(before.displacement, j) + now[j] * (row_of(rest.centroid, i) - row_of(rest.centroid, j));
                }
                fine.rotation[i].coeffs() = rotation.normalized();
                fine.displacement.row(i) = displacement.transpose() / (count + 1);
            }
        });
    }
    return fine;
}

}  // namespace strake
