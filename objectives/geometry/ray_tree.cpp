#include "objectives/geometry/ray_tree.hpp"

#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr int leaf_size = 4;

/// Whether x + s d, 0 <= s <= limit, meets the box.
bool meets(const Vector3d& low, const Vector3d& high, const Vector3d& x, const Vector3d& d, double limit) {
    double from = 0, to = limit;
    for (int c = 0; c < 3; ++c) {
        if (d[c] == 0) {
            if (x[c] < low[c] || x[c] > high[c]) return false;
            continue;
        }
        double near = (low[c] - x[c]) / d[c], far = (high[c] - x[c]) / d[c];
        if (near > far) std::swap(near, far);
        // Slightly wider: rounding must not lose a triangle that lies in a side of the box.
        from = std::max(from, near - 1e-12 * std::abs(near));
        to = std::min(to, far + 1e-12 * std::abs(far));
        if (from > to) return false;
    }
    return true;
}

}  // namespace

RayTree::RayTree(const TriMesh& mesh) : mesh_(mesh), order_(static_cast<std::size_t>(mesh.num_triangles())) {
    std::iota(order_.begin(), order_.end(), 0);
    if (!order_.empty()) build(0, mesh.num_triangles(), triangle_centroids(mesh));
}

int RayTree::build(int begin, int end, const Points& centroid) {
    const int node = static_cast<int>(nodes_.size());
    Node now{Vector3d::Constant(std::numeric_limits<double>::infinity()),
             Vector3d::Constant(-std::numeric_limits<double>::infinity()), begin, end, -1};
    Vector3d low = now.low, high = now.high;
    for (int i = begin; i < end; ++i) {
        for (int k = 0; k < 3; ++k) {
            const Vector3d v = mesh_.vertices.row(mesh_.triangles(order_[i], k));
            now.low = now.low.cwiseMin(v);
            now.high = now.high.cwiseMax(v);
        }
        const Vector3d c = centroid.row(order_[i]);
        low = low.cwiseMin(c);
        high = high.cwiseMax(c);
    }
    nodes_.push_back(now);
    if (end - begin <= leaf_size) return node;
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const int middle = (begin + end) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
        return centroid(a, axis) < centroid(b, axis) || (centroid(a, axis) == centroid(b, axis) && a < b);
    });
    build(begin, middle, centroid);
    const int right = build(middle, end, centroid);
    nodes_[static_cast<std::size_t>(node)].right = right;
    return node;
}

void RayTree::test(int t, const Vector3d& x, const Vector3d& d, int from, RayHit& best) const {
    const auto v = mesh_.triangles.row(t);
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l)
            if (v[k] == mesh_.triangles(from, l)) return;
    std::array<Vector3d, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = Vector3d(mesh_.vertices.row(v[k])) - x;
    Vector3d b;
    for (int k = 0; k < 3; ++k) {
        // From the smaller to the larger vertex: neighbours get the same bits, no ray slips between them.
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        b[k] = v[i] < v[j] ? d.dot(p[i].cross(p[j])) : -d.dot(p[j].cross(p[i]));
    }
    if ((b.array() < 0).any() && (b.array() > 0).any()) return;
    const double sum = b.sum();
    if (sum == 0) return;
    b /= sum;
    const double s = (b[0] * p[0] + b[1] * p[1] + b[2] * p[2]).dot(d) / d.squaredNorm();
    if (!(s > 0) || (best.triangle >= 0 && (s > best.s || (s == best.s && t > best.triangle)))) return;
    best = {t, s, b};
}

RayHit RayTree::first(const Vector3d& x, const Vector3d& d, int from) const {
    RayHit best;
    std::array<int, 128> stack;
    int depth = 0;
    if (!nodes_.empty()) stack[depth++] = 0;
    while (depth > 0) {
        const int at = stack[--depth];
        const Node& node = nodes_[static_cast<std::size_t>(at)];
        const double limit = best.triangle >= 0 ? best.s : std::numeric_limits<double>::max();
        if (!meets(node.low, node.high, x, d, limit)) continue;
        if (node.right < 0) {
            for (int i = node.begin; i < node.end; ++i) test(order_[static_cast<std::size_t>(i)], x, d, from, best);
            continue;
        }
        stack[depth++] = node.right;
        stack[depth++] = at + 1;
    }
    return best;
}

}  // namespace strake
