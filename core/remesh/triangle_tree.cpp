#include "core/remesh/triangle_tree.hpp"

#include <algorithm>

namespace strake {
namespace {

using Eigen::Vector3d;
constexpr int leaf_size = 4;

double box_distance2(const Vector3d& low, const Vector3d& high, const Vector3d& x) {
    return (x - x.cwiseMax(low).cwiseMin(high)).squaredNorm();
}

}  // namespace

TriangleTree::TriangleTree(const std::vector<Vector3d>& points, const std::vector<std::array<int, 3>>& tri,
                           double piece) {
    pieces_.reserve(tri.size() + tri.size() / 2);
    for (int t = 0; t < static_cast<int>(tri.size()); ++t)
        cut(points[tri[t][0]], points[tri[t][1]], points[tri[t][2]], t, piece, 0);
    nodes_.reserve(pieces_.size());
    const bool is_in_order = pieces_.size() == tri.size();  // no piece is long, so halves of the list are compact
    if (!pieces_.empty()) build(0, static_cast<int>(pieces_.size()), is_in_order);
}

/// Halves the longest side until it is short.
void TriangleTree::cut(const Vector3d& a, const Vector3d& b, const Vector3d& c, int t, double piece, int depth) {
    const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
    if (depth >= 8 || std::max({ab, bc, ca}) <= piece * piece) {
        pieces_.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), t});
    } else if (ab >= bc && ab >= ca) {
        const Vector3d m = 0.5 * (a + b);
        cut(a, m, c, t, piece, depth + 1);
        cut(m, b, c, t, piece, depth + 1);
    } else if (bc >= ca) {
        cut(b, c, a, t, piece, depth);
    } else {
        cut(c, a, b, t, piece, depth);
    }
}

void TriangleTree::build(int begin, int end, bool is_in_order) {
    const std::size_t self = nodes_.size();
    nodes_.push_back({pieces_[begin].low, pieces_[begin].high, begin, end, -1});
    if (end - begin <= leaf_size) {
        for (int i = begin; i < end; ++i) {
            nodes_[self].low = nodes_[self].low.cwiseMin(pieces_[i].low);
            nodes_[self].high = nodes_[self].high.cwiseMax(pieces_[i].high);
        }
        return;
    }
    const int middle = begin + (end - begin) / 2;
    if (!is_in_order) part(begin, middle, end);
    build(begin, middle, is_in_order);
    const int right = nodes_[self].right = static_cast<int>(nodes_.size());
    build(middle, end, is_in_order);
    nodes_[self].low = nodes_[self + 1].low.cwiseMin(nodes_[right].low);
    nodes_[self].high = nodes_[self + 1].high.cwiseMax(nodes_[right].high);
}

/// Puts the lower half along the longest side of the centres' box first.
void TriangleTree::part(int begin, int middle, int end) {
    Vector3d low = pieces_[begin].low + pieces_[begin].high, high = low;
    for (int i = begin; i < end; ++i) {
        const Vector3d twice_centre = pieces_[i].low + pieces_[i].high;
        low = low.cwiseMin(twice_centre);
        high = high.cwiseMax(twice_centre);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    std::nth_element(pieces_.begin() + begin, pieces_.begin() + middle, pieces_.begin() + end,
                     [axis](const Piece& p, const Piece& q) {
                         const double x = p.low[axis] + p.high[axis], y = q.low[axis] + q.high[axis];
                         return x != y ? x < y : p.triangle < q.triangle;
                     });
}

int TriangleTree::closest(const std::vector<Vector3d>& points, const std::vector<std::array<int, 3>>& tri,
                          const std::vector<int>& patch, int wanted, const Vector3d& x, double below2) const {
    int best = -1;
    double best2 = below2;
    std::array<std::pair<int, double>, 128> stack;  // depth is below 64: halves of at most 2^31 pieces
    int top = 0;
    if (!nodes_.empty()) stack[top++] = {0, 0.0};
    while (top > 0) {
        const auto [n, bound] = stack[--top];
        if (bound > best2) continue;
        const Node& node = nodes_[n];
        if (node.right >= 0) {
            const double left = box_distance2(nodes_[n + 1].low, nodes_[n + 1].high, x);
            const double right = box_distance2(nodes_[node.right].low, nodes_[node.right].high, x);
            if (left <= right) {
                stack[top++] = {node.right, right};
                stack[top++] = {n + 1, left};
            } else {
                stack[top++] = {n + 1, left};
                stack[top++] = {node.right, right};
            }
            continue;
        }
        for (int i = node.begin; i < node.end; ++i) {
            const int t = pieces_[i].triangle;
            if (patch[t] != wanted || box_distance2(pieces_[i].low, pieces_[i].high, x) > best2) continue;
            const Vector3d p = closest_on_triangle(points[tri[t][0]], points[tri[t][1]], points[tri[t][2]], x).point;
            const double d2 = (p - x).squaredNorm();
            if (d2 < best2 || (d2 == best2 && t < best)) {
                best2 = d2;
                best = t;
            }
        }
    }
    return best;
}

}  // namespace strake
