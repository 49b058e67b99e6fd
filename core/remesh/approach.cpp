#include "core/remesh/vertex_place.hpp"

#include <algorithm>

/// Flips the edges that deviate most from the input, or moves the vertices around them closer.
namespace strake {
namespace {

using Eigen::Vector3d;

double fourth(double x) { return (x * x) * (x * x); }

class Approach {
public:
    Approach(WorkingMesh& mesh, const StepGuard& guard, double share, double max_fold)
        : mesh_(mesh), guard_(guard), share_(share), cos_fold_(std::cos(max_fold)) {}

    int run() {
        const std::vector<int> far = farthest_edges();
        std::vector<int> look;
        std::vector<char> is_listed(mesh_.num_vertices(), 0), is_done(mesh_.num_vertices(), 0);
        for (const int h : far)
            for (const int v : {mesh_.from(h), mesh_.to(h), mesh_.apex(h), mesh_.apex(mesh_.twin[h])}) {
                if (mesh_.role[v] == VertexRole::free && !is_listed[v]) look.push_back(v);
                is_listed[v] = 1;
            }
        int count = 0;
        for (const int h : far) count += flip(h);
        for (int sweep = 0; sweep < 3; ++sweep)
            for (const int v : look) {
                if (is_done[v]) continue;
                is_done[v] = !move(v);
                if (is_done[v]) continue;
                ++count;
                mesh_.neighbours(v, [&](int u) { is_done[u] = 0; });
            }
        return count;
    }

private:
    /// Edges of deviations above 1, as far as there are few of them; else the farthest, and the share is theirs.
    std::vector<int> farthest_edges() {
        std::vector<double> deviations(mesh_.corner.size(), 0);
        in_parts(static_cast<int>(mesh_.corner.size()), guard_.threads, [&](int begin, int end) {
            for (int h = begin; h < end; ++h)
                if (mesh_.corner[h] >= 0 && mesh_.feature[h] < 0 && mesh_.twin[h] > h && may_be_far(mesh_, h))
                    deviations[h] = deviation(mesh_.from(h), mesh_.to(h));
        });
        std::vector<int> far;
        for (int h = 0; h < static_cast<int>(deviations.size()); ++h)
            if (deviations[h] > 1) far.push_back(h);
        const std::size_t few = 16 + mesh_.num_triangles() / 1000;
        if (far.size() <= few) return far;
        std::stable_sort(far.begin(), far.end(), [&](int g, int h) { return deviations[g] > deviations[h]; });
        far.resize(few);
        share_ *= deviations[far.back()];
        return far;
    }

    /// Deviation of the edge between vertices a and b from the input; 1: the share of its target length.
    double deviation(int a, int b) const { return deviation(a, mesh_.pos[a], mesh_.foot[a], b); }
    double deviation(int a, const Vector3d& x, int foot, int b) const {
        const int hint = mesh_.role[a] == VertexRole::free ? foot : mesh_.foot[b];
        double farthest2 = 0;
        for (const double t : {0.5, 0.3, 0.7}) {
            const Foot there = project(*mesh_.base, x + t * (mesh_.pos[b] - x), hint, mesh_.size[b]);
            farthest2 = std::max(farthest2, there.distance2);
        }
        return std::sqrt(farthest2) / (share_ * mesh_.wanted(a, b));
    }

    bool flip(int h) {
        const int g = mesh_.twin[h], a = mesh_.from(h), b = mesh_.to(h), c = mesh_.apex(h), d = mesh_.apex(g);
        if (mesh_.role[c] != VertexRole::free && mesh_.role[d] != VertexRole::free) return false;
        if (mesh_.valence[a] <= 4 || mesh_.valence[b] <= 4 || c == d || mesh_.are_neighbours(c, d)) return false;
        const Facing n0 = facing(mesh_, a, d, c), n1 = facing(mesh_, d, b, c);
        if (std::min(n0.quality, n1.quality) < std::min({well_shaped, mesh_.quality(h / 3), mesh_.quality(g / 3)}))
            return false;
        if (std::min(n0.dot, n1.dot) < guard_.cos_natural || n0.normal.dot(n1.normal) < guard_.cos_natural)
            return false;
        const double before =
            fourth(deviation(a, b)) + fourth(1 / mesh_.quality(h / 3)) + fourth(1 / mesh_.quality(g / 3));
        const double after = fourth(deviation(c, d)) + fourth(1 / n0.quality) + fourth(1 / n1.quality);
        if (after > 0.95 * before) return false;
        mesh_.flip(h);
        if (std::min(sharpest(c), sharpest(d)) >= cos_fold_) return true;
        mesh_.flip(WorkingMesh::next(h));  // from d to c, back
        return false;
    }

    bool move(int v) {
        const double no_bound = std::numeric_limits<double>::infinity();
        const auto cost_below = [&](const VertexPlace& place, double bound) { return cost(v, place, bound); };
        VertexPlace best;
        if (!find_best_place(mesh_, guard_, v, cost(v, place_of(mesh_, v), no_bound), cost_below, best)) return false;
        if (sharpens(v, best)) return false;
        put(mesh_, v, best);
        return true;
    }
    /// Of the shapes of v's triangles and the deviations of its edges.
    double cost(int v, const VertexPlace& place, double bound) const {
        double sum = shape_cost(mesh_, guard_, v, place, true);
        if (sum > bound) return sum;
        mesh_.around(v, [&](int h) {
            sum += fourth(deviation(v, place.point, place.foot, mesh_.to(h)));
            return sum <= bound;
        });
        return sum;
    }

    /// Cosine of the sharpest edge of v's triangles that is not a feature.
    double sharpest(int v) const {
        double least = 1;
        mesh_.around(v, [&](int h) {
            for (const int side : {h, mesh_.next(h)}) {
                if (mesh_.feature[side] >= 0 || mesh_.twin[side] < 0) continue;
                const Vector3d n = mesh_.area_vector2(side / 3), m = mesh_.area_vector2(mesh_.twin[side] / 3);
                least = std::min(least, n.dot(m) / (n.norm() * m.norm()));
            }
            return true;
        });
        return least;
    }
    /// Must not create creases.
    bool sharpens(int v, const VertexPlace& at) {
        const double before = sharpest(v);
        const Vector3d x = mesh_.pos[v];
        mesh_.pos[v] = at.point;
        const double after = sharpest(v);
        mesh_.pos[v] = x;
        return after < std::min(before, cos_fold_);
    }

    WorkingMesh& mesh_;
    const StepGuard& guard_;
    double share_;  ///< allowed deviation of an edge from the input, relative to its target length
    double cos_fold_;
};

}  // namespace

int approach(WorkingMesh& mesh, const StepGuard& guard, double share, double max_fold) {
    return Approach(mesh, guard, share, max_fold).run();
}

}  // namespace strake
