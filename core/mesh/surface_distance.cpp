#include "core/mesh/surface_distance.hpp"

#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace strake {
namespace {

using Eigen::Vector3d;

class Measure {
public:
    Measure(const TriMesh& from, const TriMesh& to) : from_(from), tree_(to) {
        out_.at_vertices = Eigen::VectorXd::Constant(from.num_vertices(), std::numeric_limits<double>::quiet_NaN());
    }

    SurfaceDistance over(const std::vector<int>& triangles) {
        double area = 0, sum = 0, squares = 0;
        for (const int t : triangles) {
            const double share = area_vector(from_, t).norm() / 3;
            for (int k = 0; k < 3; ++k) {
                const int a = from_.triangles(t, k), b = from_.triangles(t, (k + 1) % 3);
                if (std::isnan(out_.at_vertices[a])) out_.at_vertices[a] = sample(from_.vertices.row(a), t);
                const double d = at_edge(a, b, t);
                sum += share * d;
                squares += share * d * d;
                area += share;
            }
            const Vector3d centroid =
                (from_.vertices.row(from_.triangles(t, 0)) + from_.vertices.row(from_.triangles(t, 1)) +
                 from_.vertices.row(from_.triangles(t, 2))) /
                3;
            sample(centroid, t);
        }
        if (area > 0) out_.mean = sum / area, out_.rms = std::sqrt(squares / area);
        return out_;
    }

private:
    double sample(const Vector3d& x, int t) {
        const ClosestPoint found = tree_.find(x);
        if (found.distance > out_.max || out_.triangle < 0) {
            out_.max = found.distance;
            out_.at = x;
            out_.nearest = found.point;
            out_.triangle = t;
        }
        return found.distance;
    }
    double at_edge(int a, int b, int t) {
        const auto [at, is_new] = edges_.try_emplace({std::min(a, b), std::max(a, b)}, 0.0);
        if (is_new) at->second = sample(0.5 * (from_.vertices.row(a) + from_.vertices.row(b)), t);
        return at->second;
    }

    const TriMesh& from_;
    ClosestPointTree tree_;
    std::map<std::pair<int, int>, double> edges_;
    SurfaceDistance out_;
};

}  // namespace

SurfaceDistance surface_distance(const TriMesh& from, const TriMesh& to, const std::vector<int>& triangles) {
    for (const TriMesh* mesh : {&from, &to}) {
        if (mesh->num_triangles() == 0) throw InvalidInput("surface distance: a surface without triangles");
        if (!mesh->vertices.allFinite()) throw InvalidInput("surface distance: a vertex is not finite");
    }
    std::vector<int> all = triangles;
    if (all.empty()) {
        all.resize(static_cast<std::size_t>(from.num_triangles()));
        std::iota(all.begin(), all.end(), 0);
    }
    return Measure(from, to).over(all);
}

}  // namespace strake
