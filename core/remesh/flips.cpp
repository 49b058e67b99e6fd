#include "core/remesh/passes.hpp"

#include <numbers>

/// Flips: towards six edges per vertex and smaller angles.
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

constexpr double poor = 0.45;  ///< below, quality counts for more than valence

class Flips {
public:
    Flips(WorkingMesh& mesh, const StepGuard& guard)
        : mesh_(mesh), guard_(guard), wanted_(mesh.num_vertices(), 6), quality_(mesh.num_triangles()) {
        for (int v = 0; v < mesh.num_vertices(); ++v)
            if (mesh.half[v] >= 0 && mesh.role[v] != VertexRole::free) wanted_[v] = wanted_valence(mesh, v);
        in_parts(mesh.num_triangles(), guard.threads, [&](int begin, int end) {
            for (int t = begin; t < end; ++t)
                if (mesh.is_alive(t)) quality_[t] = mesh.quality(t);
        });
    }

    /// Visits all edges first, then repeatedly those near a change.
    int run() {
        int count = 0;
        for (int h = 0; h < static_cast<int>(mesh_.corner.size()); ++h)
            if (mesh_.corner[h] >= 0 && mesh_.twin[h] > h) count += attempt(h);
        for (int sweep = 0; sweep < 3 && !changed_.empty(); ++sweep) {
            const std::vector<int> look = std::move(changed_);
            changed_.clear();
            for (const int t : look)
                for (int h = 3 * t; h < 3 * t + 3; ++h) {
                    if (mesh_.twin[h] < 0) continue;
                    const int beyond = mesh_.twin[h];
                    count += attempt(h);
                    if (mesh_.twin[mesh_.next(beyond)] >= 0) count += attempt(mesh_.next(beyond));
                }
        }
        return count;
    }

private:
    bool attempt(int h) {
        const int g = mesh_.twin[h];
        if (mesh_.feature[h] >= 0) return false;
        const int a = mesh_.from(h), b = mesh_.from(g), c = mesh_.apex(h), d = mesh_.apex(g);
        const int ka = mesh_.valence[a] - wanted_[a], kb = mesh_.valence[b] - wanted_[b],
                  kc = mesh_.valence[c] - wanted_[c], kd = mesh_.valence[d] - wanted_[d];
        // Of the squared deviations from the wanted valences.
        const int gain = squared(ka) + squared(kb) + squared(kc) + squared(kd) - squared(ka - 1) - squared(kb - 1) -
                         squared(kc + 1) - squared(kd + 1);
        const double before = std::min(quality_[h / 3], quality_[g / 3]);
        if (gain <= 0 && before > poor) return false;
        if (mesh_.valence[a] <= 3 || mesh_.valence[b] <= 3) return false;
        const Facing n0 = facing(mesh_, a, d, c), n1 = facing(mesh_, d, b, c);
        const double after = std::min(n0.quality, n1.quality);
        if (gain > 0 ? after < std::min(before, poor) * 1.05 : after < 1.05 * before) return false;
        if (after < 1e-4 || !faces_well(a, b, c, d, n0, n1)) return false;
        if (c == d || mesh_.are_neighbours(c, d)) return false;
        mesh_.flip(h);
        quality_[h / 3] = n0.quality;  // h: a to d, in triangle a d c
        quality_[g / 3] = n1.quality;
        changed_.push_back(h / 3);
        changed_.push_back(g / 3);
        return true;
    }

    bool faces_well(int a, int b, int c, int d, const Facing& n0, const Facing& n1) const {
        const Facing s0 = facing(mesh_, a, b, c), s1 = facing(mesh_, b, a, d);
        double dot = 2;
        for (const Facing* n : {&n0, &n1})
            if (has_turned(guard_, s0, *n) && has_turned(guard_, s1, *n)) dot = std::min(dot, n->dot);
        if (dot < allowed_dot(guard_, std::min(s0.dot, s1.dot))) return false;
        if (std::max({n0.dot, n1.dot, s0.dot, s1.dot}) <= 1) return true;
        const Eigen::Vector3d& steady = s0.quality >= s1.quality ? s0.normal : s1.normal;
        return std::min(n0.normal.dot(steady), n1.normal.dot(steady)) >= guard_.cos_natural;
    }

    WorkingMesh& mesh_;
    const StepGuard& guard_;
    std::vector<int> wanted_;
    std::vector<double> quality_;
    std::vector<int> changed_;  ///< triangles
};

}  // namespace

int flip_edges(WorkingMesh& mesh, const StepGuard& guard) { return Flips(mesh, guard).run(); }

}  // namespace strake
