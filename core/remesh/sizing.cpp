#include "core/remesh/sizing.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "core/remesh/passes.hpp"

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Sums of the curvature tensor of Cohen-Steiner & Morvan (2003), sum beta |e| e e^T over edges, and of areas.
struct Bending {
    std::vector<Matrix3d> tensor;
    std::vector<double> area;
};

Bending bending_at_points(const BaseSurface& base) {
    Bending sum{std::vector<Matrix3d>(base.points.size(), Matrix3d::Zero()),
                std::vector<double>(base.points.size(), 0)};
    for (int t = 0; t < static_cast<int>(base.tri.size()); ++t) {
        const Vector3d a = base.points[base.tri[t][0]], b = base.points[base.tri[t][1]],
                       c = base.points[base.tri[t][2]];
        const double third = (b - a).cross(c - a).norm() / 6;
        for (const int v : base.tri[t]) sum.area[v] += third;
    }
    for (int h = 0; h < static_cast<int>(base.twin.size()); ++h) {
        if (base.barrier[h] || base.twin[h] < h) continue;
        const int u = base.from(h), v = base.from(base.next(h));
        const Vector3d e = base.points[v] - base.points[u], n = base.normal[h / 3], m = base.normal[base.twin[h] / 3];
        const double length = e.norm();
        if (!(length > 0)) continue;
        const double angle = std::atan2(n.cross(m).dot(e) / length, n.dot(m));
        const Matrix3d part = 0.5 * angle / length * e * e.transpose();
        sum.tensor[u] += part;
        sum.tensor[v] += part;
    }
    return sum;
}

/// Averages each point with its neighbours: single edges are unreliable.
Bending spread(const BaseSurface& base, const Bending& bending) {
    Bending sum = bending;
    for (int h = 0; h < static_cast<int>(base.twin.size()); ++h) {
        if (base.twin[h] > h || base.barrier[h]) continue;
        const int u = base.from(h), v = base.from(base.next(h));
        sum.tensor[u] += bending.tensor[v], sum.area[u] += bending.area[v];
        sum.tensor[v] += bending.tensor[u], sum.area[v] += bending.area[u];
    }
    return sum;
}

/// No length is longer than a neighbour's by more than the gradation times the distance: Dijkstra from the shortest.
void grade_on_base(const BaseSurface& base, double gradation, std::vector<double>& size) {
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const double longest = *std::max_element(size.begin(), size.end());
    for (int v = 0; v < static_cast<int>(size.size()); ++v)
        if (size[v] < longest) queue.push({size[v], v});
    const auto offer = [&](int from, int to) {
        const double s = size[from] + gradation * (base.points[to] - base.points[from]).norm();
        if (s < size[to]) queue.push({size[to] = s, to});
    };
    while (!queue.empty()) {
        const auto [s, v] = queue.top();
        queue.pop();
        if (s > size[v] || base.first_half[v] < 0) continue;
        const int first = base.first_half[v];
        for (int h = first; h >= 0;) {
            offer(v, base.from(base.next(h)));
            offer(v, base.from(base.prev(h)));
            h = base.twin[base.prev(h)];
            if (h == first) break;
        }
    }
}

double size_on_base(const BaseSurface& base, const std::vector<double>& size, int t, const Vector3d& x) {
    const auto [wa, wb, wc] = weights_at(base, t, x);
    return wa * size[base.tri[t][0]] + wb * size[base.tri[t][1]] + wc * size[base.tri[t][2]];
}

/// Propagates shorter lengths from vertex to vertex, starting at those listed.
void grade(WorkingMesh& mesh, double gradation, std::vector<int> queue) {
    std::vector<char> waits(mesh.num_vertices(), 0);
    for (std::size_t i = 0; i < queue.size(); ++i) {
        const int v = queue[i];
        waits[v] = 0;
        mesh.neighbours(v, [&](int u) {
            const double s = mesh.size[v] + gradation * (mesh.pos[u] - mesh.pos[v]).norm();
            if (!(s < mesh.size[u] * (1 - 1e-9))) return;
            mesh.size[u] = s;
            if (!waits[u]) queue.push_back(u);
            waits[u] = 1;
        });
    }
}

/// The tip of a wedge between two features is as thin as the wedge, however short its edges.
bool is_acute_tip(const WorkingMesh& mesh, int t) {
    for (int h = 3 * t; h < 3 * t + 3; ++h) {
        const int v = mesh.from(h);
        if (mesh.role[v] != VertexRole::fixed || mesh.feature[h] < 0 || mesh.feature[mesh.prev(h)] < 0) continue;
        const Vector3d u = mesh.pos[mesh.to(h)] - mesh.pos[v], w = mesh.pos[mesh.apex(h)] - mesh.pos[v];
        if (std::atan2(u.cross(w).norm(), u.dot(w)) < 0.6) return true;
    }
    return false;
}

/// An edge of t joins two features without being one: no free vertex lies between them.
bool spans_a_strip(const WorkingMesh& mesh, int t) {
    for (int h = 3 * t; h < 3 * t + 3; ++h)
        if (mesh.feature[h] < 0 && mesh.role[mesh.from(h)] != VertexRole::free &&
            mesh.role[mesh.to(h)] != VertexRole::free)
            return true;
    return false;
}

/// Largest principal curvature at each point of the input; 0 where nothing is known, or it is less than `least`.
std::vector<double> curvatures(const BaseSurface& base, double least) {
    const Bending own = bending_at_points(base);
    std::vector<double> result(base.points.size(), 0);
    const auto is_bent = [&](const Bending& bending, std::size_t v) {
        return bending.tensor[v].squaredNorm() > least * least * bending.area[v] * bending.area[v];
    };
    bool is_flat = true;  // and no sum of what is below the limit is above it
    for (std::size_t v = 0; v < base.points.size(); ++v) is_flat = is_flat && !is_bent(own, v);
    if (is_flat) return result;
    const Bending bending = spread(base, spread(base, own));
    for (std::size_t v = 0; v < base.points.size(); ++v) {
        if (!is_bent(bending, v)) continue;
        const Vector3d l =
            Eigen::SelfAdjointEigenSolver<Matrix3d>(bending.tensor[v] / bending.area[v], Eigen::EigenvaluesOnly)
                .eigenvalues();
        result[v] = l.cwiseAbs().maxCoeff();
    }
    return result;
}

/// Expected number of triangles at these lengths.
double expected_triangles(const BaseSurface& base, const std::vector<double>& size) {
    double sum = 0;
    for (const auto& [a, b, c] : base.tri) {
        const double area = 0.5 * (base.points[b] - base.points[a]).cross(base.points[c] - base.points[a]).norm();
        const double mean = (size[a] + size[b] + size[c]) / 3;
        sum += area / (0.4330127 * mean * mean);
    }
    return sum;
}

/// Share of the area whose triangles have a marked corner.
double share_of_area(const BaseSurface& base, const std::vector<char>& marks) {
    double sum = 0;
    for (const auto& [a, b, c] : base.tri)
        if (marks[a] || marks[b] || marks[c])
            sum += 0.5 * (base.points[b] - base.points[a]).cross(base.points[c] - base.points[a]).norm();
    return sum / base.area;
}

/// Maximum turn of the normal along an edge, radians: triangles cannot follow sharper bends.
constexpr double max_turn_per_edge = 0.8;
/// Sharp bends may at most double the number of triangles: they could be everywhere.
constexpr double max_more = 2;

}  // namespace

Sizing sizing_of(const BaseSurface& base, double longest, double shortest, double gradation, double chord_error) {
    Sizing sizing{longest, shortest, gradation, {}, {}};
    const double least = chord_error > 0 ? std::min(max_turn_per_edge / longest, 8 * chord_error / (longest * longest))
                                         : max_turn_per_edge / longest;  // less does not matter
    const std::vector<double> curvature = curvatures(base, least);
    if (!(*std::max_element(curvature.begin(), curvature.end()) > least)) return sizing;
    const std::size_t n = base.points.size();
    const double uniform = base.area / (0.4330127 * longest * longest);
    for (double floor = shortest; true; floor *= 2) {
        sizing.on_base.assign(n, longest);
        sizing.bent.assign(n, 0);
        for (std::size_t v = 0; v < n; ++v) {
            if (!(curvature[v] > 0)) continue;
            sizing.bent[v] = max_turn_per_edge / curvature[v] < floor;
            double wanted = std::clamp(max_turn_per_edge / curvature[v], std::min(floor, longest), longest);
            if (chord_error > 0) wanted = std::min(wanted, std::sqrt(8 * chord_error / curvature[v]));
            sizing.on_base[v] = std::max(wanted, shortest);
        }
        if (share_of_area(base, sizing.bent) > 0.05) sizing.bent.assign(n, 0);  // no tip: the edges are far too long
        grade_on_base(base, gradation, sizing.on_base);
        if (chord_error > 0 || floor >= longest || expected_triangles(base, sizing.on_base) <= max_more * uniform)
            return sizing;
    }
}

double longest_beside_features(const BaseSurface& base) {
    double length = 0, pieces = 0;
    for (int c = 0; c < base.curves.size(); ++c) {
        length += base.curves.length(c);
        pieces += base.curves.is_closed(c) ? 3 : 1;
    }
    for (const FeatureEdge& edge : base.features)
        if (edge.curve < 0) {
            length += (base.points[edge.v[1]] - base.points[edge.v[0]]).norm();
            ++pieces;
        }
    constexpr double infinite = std::numeric_limits<double>::infinity(), triangles_per_vertex = 2;
    if (!(length > 0)) return infinite;
    const double longest = 1.4 * length / pieces;  // from about twice on, needles cost more than length saves
    const double vertices = base.area / (0.4330127 * longest * longest) / triangles_per_vertex;
    return pieces > 0.5 * vertices ? longest : infinite;
}

/// Ridges of curves that bend: without them the chord would be off the curve by more than `slack`. Corners bend more.
std::vector<char> bent_ridges(const BaseSurface& base, double slack) {
    std::vector<std::array<int, 2>> beside(base.points.size(), {-1, -1});
    const auto note = [&](int v, int u) {
        if (beside[v][0] < 0)
            beside[v][0] = u;
        else if (beside[v][0] != u)
            beside[v][1] = u;
    };
    for (int h = 0; h < static_cast<int>(base.twin.size()); ++h) {
        if (!base.barrier[h]) continue;
        const int u = base.from(h), v = base.from(base.next(h));
        note(u, v);
        note(v, u);
    }
    std::vector<char> marks(base.points.size(), 0);
    for (std::size_t v = 0; v < marks.size(); ++v) {
        if (base.role[v] != VertexRole::ridge || beside[v][1] < 0) continue;
        const Vector3d &a = base.points[beside[v][0]], &b = base.points[beside[v][1]];
        const Vector3d chord = b - a, x = base.points[v] - a;
        const double off2 = chord.cross(x).squaredNorm(), limit2 = slack * slack * chord.squaredNorm();
        if (off2 > limit2) marks[v] = 1;
    }
    return marks;
}

std::vector<char> tight_places(const BaseSurface& base, double longest, double slack) {
    constexpr double own_turn = 0.5 * max_turn_per_edge, longest_turn = 0.8 * max_turn_per_edge;
    std::vector<char> marks = bent_ridges(base, slack);
    for (int h = 0; h < static_cast<int>(base.twin.size()); ++h) {
        if (base.barrier[h] || base.twin[h] < h) continue;
        const int u = base.from(h), v = base.from(base.next(h));
        const Vector3d &n = base.normal[h / 3], &m = base.normal[base.twin[h] / 3];
        const double length = (base.points[v] - base.points[u]).norm();
        // Centres of equilateral triangles are 1 / sqrt 3 of an edge apart.
        const double turn = std::numbers::sqrt3 * std::acos(std::clamp(n.dot(m), -1.0, 1.0));
        const bool is_bent = turn > own_turn && turn * longest > longest_turn * length;
        const bool spans = base.role[u] != VertexRole::free && base.role[v] != VertexRole::free;
        if (is_bent || spans) marks[u] = marks[v] = 1;
    }
    return marks;
}

int note_thin_places(WorkingMesh& mesh, const Sizing& sizing, bool everywhere) {
    int count = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.is_alive(t)) continue;
        const std::array<int, 3> v{mesh.corner[3 * t], mesh.corner[3 * t + 1], mesh.corner[3 * t + 2]};
        const bool spans = spans_a_strip(mesh, t);
        if (!spans && !everywhere) continue;
        if (mesh.quality(t) > (spans ? 0.5 : 0.35) || is_acute_tip(mesh, t)) continue;
        const double twice_area = mesh.area_vector2(t).norm();
        const double longest =
            std::sqrt(std::max({mesh.length2(3 * t), mesh.length2(3 * t + 1), mesh.length2(3 * t + 2)}));
        const double limit = std::max(sizing.shortest, 2.0 * twice_area / longest);
        for (const int i : v)
            if (limit < mesh.limit[i] && limit < mesh.size[i]) {
                mesh.limit[i] = limit;
                ++count;
            }
    }
    return count;
}

int note_far_edges(WorkingMesh& mesh, const Sizing& sizing, double far, int threads) {
    const int halves = static_cast<int>(mesh.corner.size());
    std::vector<char> is_far(halves, 0);
    in_parts(halves, threads, [&](int begin, int end) {
        for (int h = begin; h < end; ++h) {
            if (mesh.corner[h] < 0 || mesh.feature[h] >= 0 || mesh.twin[h] < h) continue;
            const int a = mesh.from(h), b = mesh.to(h);
            if (!may_be_far(mesh, h)) continue;
            const Vector3d middle = 0.5 * (mesh.pos[a] + mesh.pos[b]);
            const int hint = mesh.foot[mesh.role[a] == VertexRole::free ? a : b];
            is_far[h] = project(*mesh.base, middle, hint, far).distance2 > far * far;
        }
    });
    int count = 0;
    for (int h = 0; h < halves; ++h) {
        if (!is_far[h]) continue;
        for (const int v : {mesh.from(h), mesh.to(h), mesh.apex(h), mesh.apex(mesh.twin[h])}) {
            const double limit = std::max(sizing.shortest, 0.7 * mesh.size[v]);
            if (!(limit < mesh.limit[v])) continue;
            mesh.limit[v] = limit;
            ++count;
        }
    }
    return count;
}

void update_sizes(WorkingMesh& mesh, const Sizing& sizing) {
    std::vector<int> limited;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const double here = sizing.on_base.empty() || mesh.half[v] < 0
                                ? sizing.longest
                                : size_on_base(*mesh.base, sizing.on_base, mesh.foot[v], mesh.pos[v]);
        mesh.size[v] = std::min(here, mesh.limit[v]);
        if (!sizing.bent.empty() && mesh.half[v] >= 0) {
            const auto& t = mesh.base->tri[mesh.foot[v]];
            mesh.bent[v] = sizing.bent[t[0]] || sizing.bent[t[1]] || sizing.bent[t[2]];
        }
        if (mesh.limit[v] < here && mesh.half[v] >= 0) limited.push_back(v);
    }
    grade(mesh, sizing.gradation, std::move(limited));
}

}  // namespace strake
