#include "core/mesh/surface_unmap.hpp"

#include "core/mesh/geometry.hpp"

#include <Eigen/LU>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int max_rounds = 40;
constexpr double enough = 1e-14;  // diagonals: round-off of the map

struct Open {
    int point;
    Vector3d x, miss;  ///< miss = x + u(x) - moved
    Matrix3d inverse = Matrix3d::Identity();
};

Points misses(const TriMesh& rest, const Points& vertices, const Points& at, const Points& wanted,
              const SurfaceMapOptions& options) {
    return SurfaceMap(rest, at, options).moved(vertices) - wanted;
}

/// Takes the step and updates the inverse of the Jacobian (Sherman-Morrison).
void learn(Open& open, const Vector3d& step, const Vector3d& miss) {
    const Vector3d change = open.inverse * (miss - open.miss);
    const double scale = step.dot(change);
    if (std::abs(scale) > 1e-3 * step.squaredNorm())
        open.inverse += (step - change) * (step.transpose() * open.inverse) / scale;
    open.miss = miss;
}

}  // namespace

Unmapped unmap(const TriMesh& rest, const Points& vertices, const Points& moved, const SurfaceMapOptions& options) {
    const double diagonal = box_diagonal(rest);
    Unmapped out;
    out.points = SurfaceMap(with_vertices(rest, vertices), moved, options).moved(rest.vertices);
    const Points first = misses(rest, vertices, out.points, moved, options);
    Eigen::VectorXd miss = first.rowwise().norm();
    std::vector<Open> open;
    for (Eigen::Index p = 0; p < moved.rows(); ++p)
        if (!(miss[p] <= enough * diagonal)) open.push_back({static_cast<int>(p), out.points.row(p), first.row(p)});
    for (; !open.empty() && out.rounds < max_rounds; ++out.rounds) {
        const auto count = static_cast<Eigen::Index>(open.size());
        Points at(count, 3), wanted(count, 3);
        std::vector<Vector3d> steps;
        for (Eigen::Index i = 0; i < count; ++i) {
            Open& one = open[static_cast<std::size_t>(i)];
            Vector3d step = -one.inverse * one.miss;
            const double most = 4 * one.miss.norm();  // the map is close to the identity: steps are short
            if (step.norm() > most) step *= most / step.norm();
            steps.push_back(step);
            one.x += step;
            at.row(i) = one.x;
            wanted.row(i) = moved.row(one.point);
        }
        const Points now = misses(rest, vertices, at, wanted, options);
        std::vector<Open> left;
        for (Eigen::Index i = 0; i < count; ++i) {
            Open& one = open[static_cast<std::size_t>(i)];
            learn(one, steps[static_cast<std::size_t>(i)], now.row(i));
            if (one.miss.norm() < miss[one.point]) {
                miss[one.point] = one.miss.norm();
                out.points.row(one.point) = at.row(i);
            }
            if (miss[one.point] > enough * diagonal) left.push_back(one);
        }
        open = std::move(left);
    }
    if (miss.size() == 0) return out;
    Eigen::Index worst = 0;
    out.residual = miss.maxCoeff(&worst);
    out.worst = static_cast<int>(worst);
    out.num_unsolved = static_cast<int>((miss.array() > unmap_tolerance * diagonal).count());
    return out;
}

}  // namespace strake
