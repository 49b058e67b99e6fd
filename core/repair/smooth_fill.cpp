#include "core/error.hpp"
#include "core/repair/surface_parts.hpp"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <map>
#include <set>

/// Refinement and fairing as in P. Liepa, "Filling holes in meshes", SGP 2003.
namespace strake::mending {
namespace {

constexpr std::size_t max_points = 200'000;

class SmoothPatch {
public:
    SmoothPatch(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<int>& loop, int first_new)
        : mesh_(mesh), adjacent_(adjacent), loop_(loop), first_new_(first_new) {
        for (const int v : loop) {
            double sum = 0;
            int count = 0;
            for (const int n : neighbours_outside(v)) {
                sum += (at(n) - at(v)).norm();
                ++count;
            }
            density_[v] = sum / std::max(1, count);
        }
        is_taken_ = [this](int a, int b) {
            return a < first_new_ && b < first_new_ &&
                   std::binary_search(adjacent_.edges.begin(), adjacent_.edges.end(),
                                      std::array{std::min(a, b), std::max(a, b)});
        };
    }

    Patch made(std::vector<std::array<int, 3>> fill) {
        patch_.triangles = std::move(fill);
        for (int round = 0; round < 30 && refine(); ++round) relax();
        for (int pass = 0; pass < 3 && !patch_.points.empty(); ++pass) {  // weights of the shape it takes
            fair();
            relax();
        }
        return std::move(patch_);
    }

private:
    Eigen::Vector3d at(int v) const {
        return v < first_new_ ? Eigen::Vector3d(mesh_.vertices.row(v)) : patch_.points[v - first_new_];
    }
    std::vector<int> neighbours_outside(int v) const {
        std::set<int> found;
        if (v < adjacent_.vertex_triangles.size())
            for (const int t : adjacent_.vertex_triangles[v])
                for (int k = 0; k < 3; ++k)
                    if (mesh_.triangles(t, k) != v) found.insert(mesh_.triangles(t, k));
        return {found.begin(), found.end()};
    }
    void relax() {
        flip_to_delaunay([this](int v) { return at(v); }, patch_.triangles, is_taken_);
    }

    /// A new vertex in every triangle that is large for its surroundings.
    bool refine() {
        bool any = false;
        const std::size_t before = patch_.triangles.size();
        for (std::size_t t = 0; t < before && patch_.points.size() < max_points; ++t) {
            const auto [a, b, c] = patch_.triangles[t];
            const Eigen::Vector3d center = (at(a) + at(b) + at(c)) / 3;
            const double wanted = (density_[a] + density_[b] + density_[c]) / 3;
            bool is_large = true;
            for (const int v : {a, b, c}) {
                const double reach = std::sqrt(2.0) * (center - at(v)).norm();
                is_large = is_large && reach > wanted && reach > density_[v];
            }
            if (!is_large) continue;
            const int fresh = first_new_ + static_cast<int>(patch_.points.size());
            patch_.points.push_back(center);
            density_[fresh] = wanted;
            patch_.triangles[t] = {a, b, fresh};
            patch_.triangles.push_back({b, c, fresh});
            patch_.triangles.push_back({c, a, fresh});
            any = true;
        }
        return any;
    }

    /// Adds the cotangent weights of a triangle to the edges at its corners, and a third of its area to each.
    void weigh(const std::array<int, 3>& t, std::map<int, std::map<int, double>>& weight,
               std::map<int, double>& area) const {
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
            const Eigen::Vector3d u = at(a) - at(c), w = at(b) - at(c);
            const double sine = u.cross(w).norm();
            // Obtuse corners and slivers would have weights of the wrong sign.
            const double half_cot = sine > 0 ? std::clamp(0.5 * u.dot(w) / sine, 0.02, 20.0) : 0.02;
            weight[a][b] += half_cot;
            weight[b][a] += half_cot;
            area[a] += sine / 6;
        }
    }

    /// Least integral of the squared Laplacian over new vertices and the loop: a thin plate that continues the tangent
    /// planes of its surroundings.
    void fair() {
        std::map<int, std::map<int, double>> weight;
        std::map<int, double> area;
        std::set<int> around;
        for (const int v : loop_)
            for (const int t : adjacent_.vertex_triangles[v]) around.insert(t);
        for (const int t : around)
            weigh({mesh_.triangles(t, 0), mesh_.triangles(t, 1), mesh_.triangles(t, 2)}, weight, area);
        for (const auto& t : patch_.triangles) weigh(t, weight, area);
        const std::set<int> on_loop(loop_.begin(), loop_.end());
        const auto unknowns = static_cast<Eigen::Index>(patch_.points.size());
        std::vector<Eigen::Triplet<double>> entries;
        Points right = Points::Zero(static_cast<Eigen::Index>(weight.size()), 3);
        int row = 0;
        for (const auto& [v, edges] : weight) {
            if (v < first_new_ && !on_loop.count(v)) continue;
            const double scale = 1 / std::sqrt(std::max(area[v], 1e-300));
            const auto add = [&](int vertex, double value) {
                if (vertex >= first_new_)
                    entries.emplace_back(row, vertex - first_new_, value);
                else
                    right.row(row) -= value * at(vertex).transpose();
            };
            for (const auto& [n, w] : edges) {
                add(v, scale * w);
                add(n, -scale * w);
            }
            ++row;
        }
        Eigen::SparseMatrix<double> system(row, unknowns);
        system.setFromTriplets(entries.begin(), entries.end());
        const Eigen::SparseMatrix<double> normal = system.transpose() * system;
        const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
        if (solver.info() != Eigen::Success) return;  // the flat fill is one, too
        const Points place = solver.solve(system.transpose() * right.topRows(row));
        if (!place.allFinite()) return;
        for (Eigen::Index i = 0; i < unknowns; ++i) patch_.points[i] = place.row(i);
    }

    const TriMesh& mesh_;
    const Adjacency& adjacent_;
    const std::vector<int>& loop_;
    int first_new_;
    std::map<int, double> density_;  ///< target mean edge length around a vertex
    IsTaken is_taken_;
    Patch patch_;
};

}  // namespace

Patch smooth_patch(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<int>& loop,
                   std::vector<std::array<int, 3>> fill, int first_new) {
    return SmoothPatch(mesh, adjacent, loop, first_new).made(std::move(fill));
}

}  // namespace strake::mending
