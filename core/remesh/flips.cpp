#include "core/remesh/passes.hpp"

#include <numbers>

/// Flips: towards six edges a vertex, and away from large angles.
namespace strake {
namespace {

using Eigen::Vector3d;

/// Edges that vertex v should have: one triangle for every 60 degrees of each sector between features.
int wanted_valence(const WorkingMesh& mesh, int v) {
    if (mesh.role[v] == VertexRole::free) return 6;
    int first = mesh.half[v];
    if (mesh.twin[first] >= 0)
        mesh.around(v, [&](int h) {
            if (mesh.feature[h] >= 0) first = h;
            return mesh.feature[h] < 0;
        });
    int count = 0;
    double angle = 0;
    const auto close_sector = [&] {
        count += std::max(1, static_cast<int>(std::lround(angle * 3 / std::numbers::pi)));
        angle = 0;
    };
    for (int h = first;;) {
        const Vector3d u = mesh.pos[mesh.to(h)] - mesh.pos[v], w = mesh.pos[mesh.apex(h)] - mesh.pos[v];
        angle += std::atan2(u.cross(w).norm(), u.dot(w));
        h = mesh.twin[mesh.prev(h)];
        if (h < 0 || mesh.feature[h] >= 0 || h == first) close_sector();
        if (h < 0) return count + 1;
        if (h == first) return count;
    }
}


int squared(int x) { return x * x; }

class Flips {
public:
    Flips(WorkingMesh& mesh, const Guard& guard) : mesh_(mesh), guard_(guard), wanted_(mesh.num_vertices()) {
        for (int v = 0; v < mesh.num_vertices(); ++v)
            if (mesh.half[v] >= 0) wanted_[v] = wanted_valence(mesh, v);
    }
    int sweep() {
        int count = 0;
        for (int h = 0; h < static_cast<int>(mesh_.corner.size()); ++h)
            if (mesh_.corner[h] >= 0 && mesh_.twin[h] > h && mesh_.feature[h] < 0) count += attempt(h);
        return count;
    }

private:
    bool attempt(int h) {
        const int g = mesh_.twin[h], a = mesh_.from(h), b = mesh_.from(g), c = mesh_.apex(h), d = mesh_.apex(g);
        const int ka = mesh_.valence[a] - wanted_[a], kb = mesh_.valence[b] - wanted_[b],
                  kc = mesh_.valence[c] - wanted_[c], kd = mesh_.valence[d] - wanted_[d];
        const int gain = squared(ka) + squared(kb) + squared(kc) + squared(kd) - squared(ka - 1) - squared(kb - 1) -
                         squared(kc + 1) - squared(kd + 1);
        const Facing s0 = facing(mesh_, a, b, c), s1 = facing(mesh_, b, a, d);
        const double before = std::min(s0.quality, s1.quality);
        if (gain <= 0 && before > 0.6) return false;
        if (mesh_.valence[a] <= 3 || mesh_.valence[b] <= 3) return false;
        const Facing n0 = facing(mesh_, a, d, c), n1 = facing(mesh_, d, b, c);
        const double after = std::min(n0.quality, n1.quality);
        if (gain > 0 ? after < std::min(before, 0.5) : after < 1.05 * before) return false;
        if (gain < -4 && before > 0.3) return false;
        if (after < 1e-4) return false;
        double dot = 2;
        for (const Facing* n : {&n0, &n1})
            if (has_turned(guard_, s0, *n) && has_turned(guard_, s1, *n)) dot = std::min(dot, n->dot);
        if (dot < allowed_dot(guard_, std::min(s0.dot, s1.dot))) return false;
        if (std::max(n0.dot, n1.dot) > 1 || std::max(s0.dot, s1.dot) > 1) {
            const Vector3d& steady = s0.quality >= s1.quality ? s0.normal : s1.normal;
            if (std::min(n0.normal.dot(steady), n1.normal.dot(steady)) < guard_.cos_natural) return false;
        }
        if (c == d || mesh_.are_neighbours(c, d)) return false;
        mesh_.flip(h);
        return true;
    }

    WorkingMesh& mesh_;
    const Guard& guard_;
    std::vector<int> wanted_;
};

}  // namespace

int flip_edges(WorkingMesh& mesh, const Guard& guard) {
    Flips flips(mesh, guard);
    int total = 0;
    for (int sweep = 0; sweep < 4; ++sweep) {
        const int count = flips.sweep();
        total += count;
        if (count == 0) break;
    }
    return total;
}

}  // namespace strake
