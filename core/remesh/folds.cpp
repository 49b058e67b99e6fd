#include "core/mesh/geometry.hpp"
#include "core/patches/features.hpp"
#include "core/remesh/vertex_place.hpp"

/// Only the two triangles beside a crease's edge define its sharpness. A crease from noise, or at an open end, is bent
/// only as far as the input's triangles reach, and larger triangles flatten it: moves their apexes to restore the
/// input's fold.
namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double lost_share = 0.55;  ///< of the angle: a crease with a smaller fold is lost
constexpr double safe_share = 0.6;   ///< of the angle: folds of creases beside a lost one may decrease to this
constexpr double weight = 500;       ///< of a fold that is lost, beside 1 / quality^4

class Folds {
public:
    Folds(WorkingMesh& mesh, const StepGuard& guard, double angle) : mesh_(mesh), guard_(guard), angle_(angle) {}

    int run() {
        int count = 0;
        for (int h = 0; h < static_cast<int>(mesh_.corner.size()); ++h)
            if (mesh_.corner[h] >= 0 && mesh_.twin[h] > h && is_lost(h)) count += restore(h);
        return count;
    }

private:
    /// The input's crease along h: its target fold, and the middle of that part.
    Curves::Fold wanted(int h) const {
        const int f = mesh_.feature[h];
        if (f < 0 || mesh_.twin[h] < 0) return {-1, 0};
        const FeatureEdge& edge = mesh_.features[f];
        if (edge.kind != FeatureKind::crease && edge.kind != FeatureKind::held_crease) return {-1, 0};
        const Curves::Fold fold = mesh_.base->curves.largest_fold(edge.curve, edge.s[0], edge.s[1]);
        if (fold.angle < angle_ - angle_slack) return {-1, 0};
        return {std::min(fold.angle, angle_ + angle_slack), fold.s};
    }
    double fold(int h) const { return dihedral(mesh_.area_vector2(h / 3), mesh_.area_vector2(mesh_.twin[h] / 3)); }
    bool is_lost(int h) const { return wanted(h).angle > 0 && fold(h) < lost_share * angle_; }

    bool restore(int h) {
        restored_ = mesh_.feature[h];
        for (int sweep = 0; sweep < 3; ++sweep) {
            for (const int side : {h, mesh_.twin[h]}) {
                to_input(side);
                improve(mesh_.apex(side));
            }
            for (const int side : {h, mesh_.twin[h]}) {
                std::vector<int> beside;
                mesh_.neighbours(mesh_.apex(side), [&](int u) { beside.push_back(u); });
                for (const int u : beside) improve(u);
            }
        }
        return !is_lost(h);
    }

    /// Moves the apex over half-edge h to the best of some places in the input's triangle.
    void to_input(int h) {
        const int v = mesh_.apex(h);
        if (mesh_.role[v] != VertexRole::free) return;
        const BaseSurface& base = *mesh_.base;
        const FeatureEdge& edge = mesh_.features[mesh_.feature[h]];
        int half = base.curves.half_at(edge.curve, wanted(h).s);
        const Vector3d along = base.points[base.from(base.next(half))] - base.points[base.from(half)];
        if (along.dot(mesh_.pos[mesh_.to(h)] - mesh_.pos[mesh_.from(h)]) < 0) half = base.twin[half];
        if (base.patch[half / 3] != mesh_.patch[h / 3]) return;
        const Vector3d m = 0.5 * (mesh_.pos[mesh_.from(h)] + mesh_.pos[mesh_.to(h)]),
                       top = base.points[base.from(base.prev(half))];
        double least = 0.98 * cost(v, place_of(mesh_, v));
        VertexPlace best;
        bool found = false;
        for (const double share : {1.0, 0.85, 0.7, 0.55}) {
            const Vector3d x = m + share * (top - m);
            const VertexPlace place{x, normal_at(base, half / 3, x), half / 3, 0};
            const double c = cost(v, place);
            if (!(c < least)) continue;
            least = c;
            best = place;
            found = true;
        }
        if (found) put(mesh_, v, best);
    }

    void improve(int v) {
        if (mesh_.role[v] == VertexRole::fixed) return;
        const auto cost_of = [&](const VertexPlace& place, double) { return cost(v, place); };
        VertexPlace best;
        if (find_best_place(mesh_, guard_, v, cost(v, place_of(mesh_, v)), cost_of, best)) put(mesh_, v, best);
    }

    double cost(int v, const VertexPlace& place) {
        double sum = shape_cost(mesh_, guard_, v, place);
        if (!std::isfinite(sum)) return sum;
        const Vector3d x = mesh_.pos[v];
        mesh_.pos[v] = place.point;
        mesh_.around(v, [&](int h) {
            for (const int side : {h, mesh_.next(h)}) {
                if (mesh_.twin[side] < 0) continue;
                if (mesh_.feature[side] < 0) {
                    if (fold(side) > 0.95 * angle_) sum += weight;
                    continue;
                }
                const double all = wanted(side).angle;
                const double least = mesh_.feature[side] == restored_ ? all : std::min(all, safe_share * angle_);
                if (least > 0) sum += weight * squared(std::max(0.0, 1 - fold(side) / least));
            }
            return true;
        });
        mesh_.pos[v] = x;
        return sum;
    }
    static double squared(double x) { return x * x; }

    WorkingMesh& mesh_;
    const StepGuard& guard_;
    double angle_;
    int restored_ = -1;  ///< feature
};

}  // namespace

int restore_folds(WorkingMesh& mesh, const StepGuard& guard, double angle) { return Folds(mesh, guard, angle).run(); }

}  // namespace strake
