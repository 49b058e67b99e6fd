#include "core/remesh/passes.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

/// Splits and collapses.
namespace strake {
namespace {

using Eigen::Vector3d;

bool is_longest(const WorkingMesh& mesh, int h, double length2) {
    return mesh.length2(mesh.next(h)) <= length2 && mesh.length2(mesh.prev(h)) <= length2;
}

/// Feature edges are split at a point of the curve, unless a triangle beside them would invert.
bool may_split(const WorkingMesh& mesh, int h) {
    if (mesh.feature[h] < 0) return true;
    const FeatureEdge& edge = mesh.features[mesh.feature[h]];
    if (is_rigid(edge.kind)) return false;
    const Vector3d m = mesh.base->curves.at(edge.curve, mesh.split_place(mesh.feature[h]));
    for (const int side : {h, mesh.twin[h]}) {
        if (side < 0) continue;
        const Vector3d &a = mesh.pos[mesh.from(side)], &b = mesh.pos[mesh.to(side)], &c = mesh.pos[mesh.apex(side)];
        const Vector3d n = (b - a).cross(c - a);
        const double least = 0.1 * n.squaredNorm();
        if (!((m - a).cross(c - a).dot(n) > least && (b - m).cross(c - m).dot(n) > least)) return false;
    }
    return true;
}

/// The worst of the triangles that an operation replaces, or makes.
struct Worst {
    double dot = 2, quality = 2;
    void add(const Facing& f) {
        dot = std::min(dot, f.dot);
        quality = std::min(quality, f.quality);
    }
};

constexpr double cos_at_tips = 0.75;

class Collapse {
public:
    Collapse(WorkingMesh& mesh, const StepGuard& guard, double longest)
        : mesh_(mesh), guard_(guard), longest_(longest) {}

    /// Removes the end a of edge h if all tests pass.
    bool attempt(int h, int a) {
        const int b = mesh_.from(h) + mesh_.to(h) - a, f = mesh_.feature[h];
        if (mesh_.role[a] == VertexRole::fixed || (mesh_.role[a] == VertexRole::ridge && f < 0)) return false;
        if (f >= 0 && is_rigid(mesh_.features[f].kind)) return false;
        if (mesh_.role[a] == VertexRole::free && mesh_.valence[a] + mesh_.valence[b] > 14) return false;
        const bool moves = mesh_.role[a] == VertexRole::free && mesh_.role[b] == VertexRole::free;
        Foot foot{moves ? Vector3d(0.5 * (mesh_.pos[a] + mesh_.pos[b])) : mesh_.pos[b], mesh_.foot[b], 0, 0, 0};
        if (!keeps_short(a, b, foot.point, moves)) return false;  // most fail here, and the test is cheap
        if (!mesh_.can_collapse(h, a)) return false;
        if (f >= 0 && !mesh_.collapse_fits_curve(h, a, guard_.chord_slack)) return false;
        if (moves) foot = project(*mesh_.base, 0.5 * (mesh_.pos[a] + mesh_.pos[b]), mesh_.foot[b], mesh_.size[b]);
        if (!fits_at(a, b, h, foot, moves)) {
            // Vertices split from long needles are as far from the surface as from each other: they merge first, and
            // smoothing moves them onto it.
            if (!moves || !(foot.distance2 > 0.25 * mesh_.length2(h))) return false;
            foot.point = 0.5 * (mesh_.pos[a] + mesh_.pos[b]);
            if (!fits_at(a, b, h, foot, moves)) return false;
        }
        mesh_.collapse(h, a);
        mesh_.pos[b] = foot.point;
        mesh_.foot[b] = foot.triangle;
        return true;
    }

private:
    bool fits_at(int a, int b, int h, const Foot& foot, bool moves) {
        return (!moves || keeps_short(a, b, foot.point, moves)) && faces(a, b, h, foot, moves);
    }
    bool keeps_short(int a, int b, const Vector3d& x, bool moves) const {
        return shorter(a, b, x) && (!moves || shorter(b, b, x));
    }
    bool vanishes(int t, int h) const { return t == h / 3 || (mesh_.twin[h] >= 0 && t == mesh_.twin[h] / 3); }

    /// No edge of v becomes too long when v moves to x and becomes b, or longer than before.
    bool shorter(int v, int b, const Vector3d& x) const {
        bool fits = true;
        mesh_.neighbours(v, [&](int n) {
            const double limit = longest_ * mesh_.wanted(n, b), length2 = (mesh_.pos[n] - x).squaredNorm();
            if (length2 > limit * limit && length2 > (mesh_.pos[n] - mesh_.pos[v]).squaredNorm()) fits = false;
        });
        return fits;
    }

    /// The apex of a cone: its triangles turn by an angle that depends on their number, not on their size.
    bool is_tip(int v) const {
        if (mesh_.role[v] != VertexRole::fixed) return false;
        bool is_alone = true;
        mesh_.around(v, [&](int h) { return is_alone = mesh_.feature[h] < 0 && mesh_.twin[h] >= 0; });
        return is_alone;
    }

    /// A triangle that turns only as far as the apex of a cone among its corners makes it.
    bool is_at_tip(const Facing& made, const std::array<int, 3>& corners) const {
        return made.dot >= cos_at_tips && std::any_of(corners.begin(), corners.end(), [&](int v) { return is_tip(v); });
    }

    /// The triangles left face the way that the input does, and are no worse than those before.
    bool faces(int a, int b, int h, const Foot& foot, bool moves) {
        Worst before, after;
        old_.clear();
        const auto look_at = [&](int v) {
            mesh_.around(v, [&](int out) {
                const bool stays = !vanishes(out / 3, h);
                if (v != a && !stays) return true;
                const Facing old = facing(mesh_, v, mesh_.to(out), mesh_.apex(out));
                before.add(old);
                if (stays) old_.push_back(old);
                return true;
            });
        };
        bool fits = true;
        std::size_t next = 0;
        const auto try_at = [&](int v) {
            mesh_.around(v, [&](int out) {
                if (vanishes(out / 3, h)) return true;
                const int p = mesh_.to(out), q = mesh_.apex(out);
                const Facing made = facing(mesh_, b, p, q, foot.point, mesh_.pos[p], mesh_.pos[q]);
                const Facing& old = old_[next++];
                after.quality = std::min(after.quality, made.quality);
                if (has_turned(guard_, old, made) && !is_at_tip(made, {p, q, b}))
                    after.dot = std::min(after.dot, made.dot);
                if (made.dot > 1 && old.quality > no_area && made.normal.dot(old.normal) < guard_.cos_natural)
                    fits = false;
                return true;
            });
        };
        look_at(a);
        if (moves) look_at(b);
        const Vector3d normal_before = mesh_.normal[b];
        if (moves) mesh_.normal[b] = normal_at(*mesh_.base, foot);
        if (moves && std::min(mesh_.normal[b].dot(normal_before), mesh_.normal[b].dot(mesh_.normal[a])) < 0.5)
            fits = false;
        try_at(a);
        if (moves) try_at(b);
        fits = fits && after.quality >= std::min(0.3, before.quality) &&
               after.quality > std::min(1e-4, before.quality) && after.dot >= allowed_dot(guard_, before.dot);
        if (!fits) mesh_.normal[b] = normal_before;
        return fits;
    }

    WorkingMesh& mesh_;
    const StepGuard& guard_;
    double longest_;
    std::vector<Facing> old_;  ///< current triangles of the tested collapse
};

}  // namespace

namespace {

/// The half-edge that represents an edge.
int first_half(const WorkingMesh& mesh, int h) {
    const int g = mesh.twin[h];
    return g >= 0 && g < h ? g : h;
}

/// Edges to revisit.
class EdgeMarks {
public:
    void note(const WorkingMesh& mesh, int h) {
        const std::size_t first = first_half(mesh, h);
        if (first >= is_marked_.size()) is_marked_.resize(mesh.corner.size(), 0);
        is_marked_[first] = 1;
        lowest_ = std::min(lowest_, first);
        highest_ = std::max(highest_, first);
    }
    void note_triangle(const WorkingMesh& mesh, int t) {
        for (int h = 3 * t; h < 3 * t + 3; ++h) note(mesh, h);
    }
    bool is_empty() const { return lowest_ > highest_; }
    /// Calls f(h) in the order of their numbers, and forgets them.
    template <class F>
    void take_all(const F& f) {
        for (std::size_t h = lowest_; h <= highest_; ++h) {
            const void* at = std::memchr(&is_marked_[h], 1, highest_ + 1 - h);
            if (at == nullptr) break;
            h = static_cast<std::size_t>(static_cast<const char*>(at) - is_marked_.data());
            is_marked_[h] = 0;
            f(static_cast<int>(h));
        }
        lowest_ = std::numeric_limits<std::size_t>::max();
        highest_ = 0;
    }

private:
    std::vector<char> is_marked_;
    std::size_t lowest_ = std::numeric_limits<std::size_t>::max(), highest_ = 0;
};

/// Visits all edges, then repeatedly those with a change, in the order of their numbers. visit(h, next) marks edges to
/// revisit in `next`. @return the sum of its results
template <class Visit>
int sweep_edges(const WorkingMesh& mesh, int max_sweeps, const Visit& visit) {
    EdgeMarks look, next;
    int total = 0;
    for (int h = 0; h < static_cast<int>(mesh.corner.size()); ++h)
        if (mesh.corner[h] >= 0 && first_half(mesh, h) == h) total += visit(h, next);
    for (int sweep = 1; sweep < max_sweeps && !next.is_empty(); ++sweep) {
        std::swap(look, next);
        look.take_all([&](int h) {
            if (mesh.corner[h] >= 0 && first_half(mesh, h) == h) total += visit(h, next);
        });
    }
    return total;
}

}  // namespace

int split_long(WorkingMesh& mesh, double factor) {
    return sweep_edges(mesh, 200, [&](int h, EdgeMarks& next) {
        const int g = mesh.twin[h];
        const double length2 = mesh.length2(h), limit = factor * mesh.wanted(mesh.from(h), mesh.to(h));
        if (!(length2 > limit * limit) || !may_split(mesh, h)) return 0;
        if (!is_longest(mesh, h, length2) || (g >= 0 && !is_longest(mesh, g, length2))) return 0;  // these come first
        const int before = mesh.num_triangles();
        mesh.split(h);
        next.note_triangle(mesh, h / 3);
        if (g >= 0) next.note_triangle(mesh, g / 3);
        for (int t = before; t < mesh.num_triangles(); ++t) next.note_triangle(mesh, t);
        return 1;
    });
}

int collapse_short(WorkingMesh& mesh, const StepGuard& guard, double factor, double longest) {
    Collapse collapse(mesh, guard, longest);
    return sweep_edges(mesh, 4, [&](int h, EdgeMarks& next) {
        const double limit = factor * mesh.wanted(mesh.from(h), mesh.to(h));
        if (!(mesh.length2(h) < limit * limit)) return 0;
        const int a = mesh.from(h), b = mesh.to(h);
        const bool a_goes = collapse.attempt(h, a);
        const bool is_alike = mesh.role[a] == VertexRole::free && mesh.role[b] == VertexRole::free;  // b as a, then
        if (!a_goes && (is_alike || !collapse.attempt(h, b))) return 0;
        mesh.neighbours(a_goes ? b : a, [&](int u) {
            mesh.around(u, [&](int out) {
                next.note(mesh, out);
                return true;
            });
        });
        return 1;
    });
}

}  // namespace strake
