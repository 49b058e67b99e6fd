#include "core/remesh/passes.hpp"

/// Smoothing along the surface and back onto it. Every vertex uses the positions before the pass: order and number of
/// threads do not matter.
namespace strake {
namespace {

using Eigen::Vector3d;

struct Moves {
    std::vector<Vector3d> pos, normal;
    std::vector<int> foot;
    std::vector<double> s;  ///< shift along the curve, of ridges
};

/// Calls f(p, pos of p - pos of v, q, pos of q - pos of v) for every triangle v p q around free vertex v.
template <class F>
void each_triangle_at(const WorkingMesh& mesh, int v, F&& f) {
    const Vector3d x = mesh.pos[v];
    const int first = mesh.half[v];
    int h = first, p = mesh.to(h);
    Vector3d u = mesh.pos[p] - x;
    do {
        const int back = WorkingMesh::prev(h), q = mesh.from(back);
        const Vector3d w = mesh.pos[q] - x;
        f(p, u, q, w);
        p = q;
        u = w;
        h = mesh.twin[back];
    } while (h != first);
}

/// From v to the centre of the triangles around it, weighted by their areas in units of the wanted one.
Vector3d towards_centre(const WorkingMesh& mesh, int v) {
    Vector3d sum = Vector3d::Zero();
    double whole = 0;
    each_triangle_at(mesh, v, [&](int p, const Vector3d& u, int q, const Vector3d& w) {
        const double size = mesh.size[p] + mesh.size[q];
        const double weight = u.cross(w).norm() / (size * size);
        sum += weight * (u + w);
        whole += weight;
    });
    return whole > 0 ? Vector3d(sum / (3 * whole)) : Vector3d::Zero();
}

/// From v to where the triangles around it would be equilateral, weighted by how far they are from it. All vertices
/// move at once: the full step would oscillate.
Vector3d towards_equilateral(const WorkingMesh& mesh, int v) {
    constexpr double share = 0.6, of_wanted = 0.2;
    Vector3d sum = Vector3d::Zero();
    double whole = 0;
    each_triangle_at(mesh, v, [&](int a, const Vector3d& p, int b, const Vector3d& q) {
        const Vector3d across = q - p, up = mesh.normal[v].cross(across);
        const double up2 = up.squaredNorm(), across2 = across.squaredNorm();  // the edge across; seen along the normal
        if (!(up2 > 0)) return;
        const double side = (1 - of_wanted) * std::sqrt(across2) +
                            of_wanted * (0.5 * mesh.size[v] + 0.25 * (mesh.size[a] + mesh.size[b]));
        const double quality = 3.4641016151377544 * p.cross(q).norm() / (p.squaredNorm() + q.squaredNorm() + across2);
        const double weight = std::sqrt(1.02 - quality);
        sum += weight * (0.5 * (p + q) + 0.8660254037844386 * side / std::sqrt(up2) * up);
        whole += weight;
    });
    return whole > 0 ? Vector3d(share / whole * sum) : Vector3d::Zero();
}

void move_free(const WorkingMesh& mesh, Towards goal, int v, Moves& moves) {
    Vector3d shift = goal == Towards::centres ? towards_centre(mesh, v) : towards_equilateral(mesh, v);
    shift -= shift.dot(mesh.normal[v]) * mesh.normal[v];
    const Foot foot = project(*mesh.base, mesh.pos[v] + shift, mesh.foot[v], 0.5 * mesh.size[v]);
    const Vector3d normal = normal_at(*mesh.base, foot);
    if (normal.dot(mesh.normal[v]) < 0.5) return;  // round an edge, or on the other side of a thin part
    moves.pos[v] = foot.point;
    moves.foot[v] = foot.triangle;
    moves.normal[v] = normal;
}

void move_ridge(const WorkingMesh& mesh, const StepGuard& guard, int v, Moves& moves) {
    const auto [before, after] = ridge_edges(mesh, v);
    if (before < 0 || after < 0) return;
    const FeatureEdge &e = mesh.features[before], &f = mesh.features[after];
    const Curves& curves = mesh.base->curves;
    const double left = e.s[1] - e.s[0], right = f.s[1] - f.s[0];
    const double wanted_left = mesh.wanted(e.v[0], v), wanted_right = mesh.wanted(v, f.v[1]);
    const double target = (left + right) * wanted_left / (wanted_left + wanted_right) - left;
    const auto fits = [&](double shift) {
        return shift > -0.9 * left && shift < 0.9 * right &&
               curves.chord_fits(e.curve, e.s[0], e.s[1] + shift, guard.chord_slack) &&
               curves.chord_fits(e.curve, f.s[0] + shift, f.s[1], guard.chord_slack);
    };
    double shift = target;
    if (!fits(shift)) shift = curves.nearest_vertex(e.curve, e.s[1] + target) - e.s[1];
    if (!fits(shift)) return;
    moves.s[v] = shift;
    moves.pos[v] = curves.at(e.curve, e.s[1] + shift);
    moves.foot[v] = curves.triangle_at(e.curve, e.s[1] + shift);
}

/// Whether a triangle is well shaped and faces like the input at its free corners; nearly all are.
bool is_surely_good(const WorkingMesh& mesh, const StepGuard& guard, int a, int b, int c) {
    const Vector3d u = mesh.pos[b] - mesh.pos[a], w = mesh.pos[c] - mesh.pos[a], normal = u.cross(w);
    const double sum = u.squaredNorm() + w.squaredNorm() + (u - w).squaredNorm(), norm2 = normal.squaredNorm();
    if (!(12 * norm2 > 0.3001 * 0.3001 * sum * sum)) return false;
    const double least2 = guard.cos_natural * guard.cos_natural * norm2 * (1 + 1e-12);
    bool is_known = false;
    for (const int v : {a, b, c}) {
        if (mesh.role[v] != VertexRole::free || mesh.bent[v]) continue;
        const double dot = normal.dot(mesh.normal[v]);
        if (!(dot > 0 && dot * dot >= least2)) return false;
        is_known = true;
    }
    return is_known;
}

/// Triangles that the moves would damage; their vertices stay.
bool is_spoilt(const WorkingMesh& mesh, const Moves& before, const StepGuard& guard, int t) {
    const int a = mesh.corner[3 * t], b = mesh.corner[3 * t + 1], c = mesh.corner[3 * t + 2];
    if (mesh.pos[a] == before.pos[a] && mesh.pos[b] == before.pos[b] && mesh.pos[c] == before.pos[c]) return false;
    if (is_surely_good(mesh, guard, a, b, c)) return false;
    const Facing now = facing(mesh, a, b, c);
    if (now.dot <= 1 && now.dot >= guard.cos_natural && now.quality > 0.3) return false;
    Facing old = facing(mesh, a, b, c, before.pos[a], before.pos[b], before.pos[c]);
    old.dot = 2;
    for (const int v : {a, b, c})
        if (mesh.role[v] == VertexRole::free && !mesh.bent[v])
            old.dot = std::min(old.dot, old.normal.dot(before.normal[v]));
    if (now.quality < std::min(0.3, old.quality)) return true;
    if (now.dot > 1) return old.quality > no_area && now.normal.dot(old.normal) < guard.cos_natural;
    if (!has_turned(guard, old, now)) return false;
    return now.dot < std::min(guard.cos_natural, old.dot) || (now.dot < 0 && now.quality > old.quality);
}

void shift_features(WorkingMesh& mesh, const std::vector<double>& s) {
    for (FeatureEdge& edge : mesh.features)
        if (edge.curve >= 0)
            for (int end = 0; end < 2; ++end) edge.s[end] += s[edge.v[end]];
}

/// Undoes moves that damage triangles, and moves that this affects in turn.
void take_back(WorkingMesh& mesh, Moves& before, const StepGuard& guard) {
    const int m = mesh.num_triangles();
    std::vector<char> spoilt(m);
    in_parts(m, guard.threads, [&](int begin, int end) {
        for (int t = begin; t < end; ++t) spoilt[t] = mesh.is_alive(t) && is_spoilt(mesh, before, guard, t);
    });
    std::vector<int> queue;
    for (int t = 0; t < m; ++t)
        if (spoilt[t]) queue.push_back(t);
    for (std::size_t i = 0; i < queue.size(); ++i) {
        const int t = queue[i];
        for (int k = 0; k < 3; ++k) {
            const int v = mesh.corner[3 * t + k];
            if (mesh.pos[v] == before.pos[v]) continue;
            mesh.pos[v] = before.pos[v];
            mesh.normal[v] = before.normal[v];
            mesh.foot[v] = before.foot[v];
            before.s[v] = 0;
            mesh.around(v, [&](int h) {
                if (is_spoilt(mesh, before, guard, h / 3)) queue.push_back(h / 3);
                return true;
            });
        }
    }
}

/// Vertices near which nothing moves any more are settled. @return the largest move in target lengths.
double settle(WorkingMesh& mesh, const Moves& before) {
    constexpr double noticeable = 0.01;
    double largest2 = 0;
    std::vector<int> moved;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (mesh.settled[v]) continue;
        const double move2 = (mesh.pos[v] - before.pos[v]).squaredNorm() / (mesh.size[v] * mesh.size[v]);
        largest2 = std::max(largest2, move2);
        mesh.settled[v] = 1;
        if (move2 > noticeable * noticeable && mesh.half[v] >= 0) moved.push_back(v);
    }
    for (const int v : moved) mesh.wake_around(v);
    return std::sqrt(largest2);
}

}  // namespace

RidgeEdges ridge_edges(const WorkingMesh& mesh, int v) {
    RidgeEdges edges;
    const auto note = [&](int f) {
        if (f >= 0) (mesh.features[f].v[1] == v ? edges.before : edges.after) = f;
    };
    mesh.around(v, [&](int h) {
        note(mesh.feature[h]);
        if (mesh.twin[mesh.prev(h)] < 0) note(mesh.feature[mesh.prev(h)]);
        return true;
    });
    return edges;
}

double smooth(WorkingMesh& mesh, const StepGuard& guard, Towards goal) {
    const int n = mesh.num_vertices();
    Moves moves{mesh.pos, mesh.normal, mesh.foot, std::vector<double>(n, 0.0)};
    in_parts(n, guard.threads, [&](int begin, int end) {
        for (int v = begin; v < end; ++v) {
            if (mesh.half[v] < 0 || mesh.settled[v]) continue;
            if (mesh.role[v] == VertexRole::free)
                move_free(mesh, goal, v, moves);
            else if (mesh.role[v] == VertexRole::ridge)
                move_ridge(mesh, guard, v, moves);
        }
    });
    mesh.pos.swap(moves.pos);
    mesh.normal.swap(moves.normal);
    mesh.foot.swap(moves.foot);
    take_back(mesh, moves, guard);
    shift_features(mesh, moves.s);
    return settle(mesh, moves);
}

}  // namespace strake
