#include "core/mesh/intersection_tree.hpp"

#include "core/mesh/pair_test.hpp"
#include "core/mesh/weld.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace strake {
namespace {

constexpr int leaf_size = 4;

/// A box in single precision, rounded outward: boxes only tell what needs no look, and those of ten million triangles
/// are half a gigabyte. Relative to a point in the middle of the surface, wherever that is.
struct Bounds {
    Eigen::Vector3f low, high;

    static Bounds around(const Eigen::Vector3d& lowest, const Eigen::Vector3d& highest, const Eigen::Vector3d& middle) {
        constexpr float infinity = std::numeric_limits<float>::infinity();
        Bounds box;
        for (int k = 0; k < 3; ++k) {
            const double from = lowest[k] - middle[k], to = highest[k] - middle[k];
            box.low[k] = static_cast<float>(from);
            box.high[k] = static_cast<float>(to);
            if (box.low[k] > from) box.low[k] = std::nextafter(box.low[k], -infinity);
            if (box.high[k] < to) box.high[k] = std::nextafter(box.high[k], infinity);
        }
        return box;
    }
    void add(const Bounds& other) {
        low = low.cwiseMin(other.low);
        high = high.cwiseMax(other.high);
    }
    bool meets(const Bounds& o) const {
        return low[0] <= o.high[0] && o.low[0] <= high[0] && low[1] <= o.high[1] && o.low[1] <= high[1] &&
               low[2] <= o.high[2] && o.low[2] <= high[2];
    }
};

/// Per vertex the first one with the same coordinates; empty when there are none.
std::vector<int> twins(const Points& vertices) {
    const std::vector<int> number = equal_points(vertices);
    std::vector<int> first(number.size(), -1), twin(number.size());
    bool any = false;
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (first[number[v]] < 0) first[number[v]] = static_cast<int>(v);
        twin[v] = first[number[v]];
        any = any || twin[v] != static_cast<int>(v);
    }
    if (!any) twin.clear();
    return twin;
}

}  // namespace

/// Traverses all pairs of leaves with intersecting boxes and a moved triangle.
struct IntersectionTree::Search {
    const IntersectionTree& tree;
    const Points& vertices;
    const std::vector<int>& id;
    const std::vector<char>& moved;  ///< per triangle; empty: all
    std::vector<Bounds> leaf_box;    ///< in the order of `order_`
    std::vector<Bounds> box;         ///< per node
    std::vector<char> node_moved;
    Intersections found;

    void refit() {
        const Eigen::Vector3d middle =
            0.5 * (tree.rest_->vertices.colwise().minCoeff() + tree.rest_->vertices.colwise().maxCoeff());
        leaf_box.resize(tree.order_.size());
        for (std::size_t i = 0; i < leaf_box.size(); ++i) {
            const auto corner = [&](int k) {
                return Eigen::Vector3d(vertices.row(tree.rest_->triangles(tree.order_[i], k)));
            };
            leaf_box[i] = Bounds::around(corner(0).cwiseMin(corner(1)).cwiseMin(corner(2)),
                                         corner(0).cwiseMax(corner(1)).cwiseMax(corner(2)), middle);
        }
        box.resize(tree.nodes_.size());
        node_moved.assign(tree.nodes_.size(), 0);
        for (int n = static_cast<int>(box.size()) - 1; n >= 0; --n) {
            const Node& node = tree.nodes_[n];
            if (node.right >= 0) {
                box[n] = box[n + 1];
                box[n].add(box[node.right]);
                node_moved[n] = node_moved[n + 1] || node_moved[node.right];
                continue;
            }
            box[n] = leaf_box[node.begin];
            for (int i = node.begin; i < node.end; ++i) {
                box[n].add(leaf_box[i]);
                if (has_moved(tree.order_[i])) node_moved[n] = 1;
            }
        }
    }
    bool has_moved(int t) const { return moved.empty() || moved[t]; }

    void within(int n) {
        const Node& node = tree.nodes_[n];
        if (!node_moved[n]) return;
        if (node.right < 0) {
            for (int i = node.begin; i < node.end; ++i)
                for (int j = i + 1; j < node.end; ++j) examine(i, j);
            return;
        }
        within(n + 1);
        within(node.right);
        between(n + 1, node.right);
    }
    void between(int a, int b) {
        if (!(node_moved[a] || node_moved[b]) || !box[a].meets(box[b])) return;
        const Node &na = tree.nodes_[a], &nb = tree.nodes_[b];
        if (na.right < 0 && nb.right < 0) {
            for (int i = na.begin; i < na.end; ++i)
                if (leaf_box[i].meets(box[b]))
                    for (int j = nb.begin; j < nb.end; ++j) examine(i, j);
        } else if (nb.right < 0 || (na.right >= 0 && na.end - na.begin >= nb.end - nb.begin)) {
            between(a + 1, b);
            between(na.right, b);
        } else {
            between(a, b + 1);
            between(a, nb.right);
        }
    }
    void examine(int i, int j) {
        if (!leaf_box[i].meets(leaf_box[j])) return;
        const int s = std::min(tree.order_[i], tree.order_[j]), t = std::max(tree.order_[i], tree.order_[j]);
        if (!has_moved(s) && !has_moved(t)) return;
        const Corners a = corners(s), b = corners(t);
        if (surely_disjoint(a, b)) return;
        const Meeting meeting = exact_meeting(a, b);
        if (meeting == Meeting::apart) found.apart.push_back({s, t});
        if (meeting == Meeting::adjacent) found.adjacent.push_back({s, t});
    }
    Corners corners(int t) const {
        Corners c;
        for (int k = 0; k < 3; ++k) {
            const int v = tree.rest_->triangles(t, k);
            c.at[k] = vertices.row(v);
            c.id[k] = id.empty() ? v : id[v];
        }
        return c;
    }
};

IntersectionTree::IntersectionTree(std::shared_ptr<const TriMesh> rest)
    : rest_(std::move(rest)), twin_(twins(rest_->vertices)), seam_(1e-9 * box_diagonal(*rest_)) {
    const Triangles& triangles = rest_->triangles;
    const auto id = [&](int t, int k) { return twin_.empty() ? triangles(t, k) : twin_[triangles(t, k)]; };
    for (int t = 0; t < rest_->num_triangles(); ++t)
        if (id(t, 0) != id(t, 1) && id(t, 1) != id(t, 2) && id(t, 2) != id(t, 0)) order_.push_back(t);
    set_order();
    at_rest_ = search(rest_->vertices, {});
}

void IntersectionTree::set_order() {
    const Points& x = rest_->vertices;
    const Triangles& triangles = rest_->triangles;
    std::vector<Centre> centres;
    centres.reserve(order_.size());
    for (const int t : order_)
        centres.push_back({(x.row(triangles(t, 0)) + x.row(triangles(t, 1)) + x.row(triangles(t, 2))) / 3, t});
    if (!order_.empty()) build(0, static_cast<int>(order_.size()), centres);
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = centres[i].triangle;
}

/// Halves at the median along the longest side of the centroids' box. Equal coordinates are ordered by number.
void IntersectionTree::build(int begin, int end, std::vector<Centre>& centres) {
    const std::size_t self = nodes_.size();
    nodes_.push_back({begin, end, -1});
    if (end - begin <= leaf_size) return;
    Eigen::Vector3d low = centres[begin].at, high = low;
    for (int i = begin; i < end; ++i) low = low.cwiseMin(centres[i].at), high = high.cwiseMax(centres[i].at);
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(centres.begin() + begin, centres.begin() + middle, centres.begin() + end,
                     [axis](const Centre& s, const Centre& t) {
                         return s.at[axis] != t.at[axis] ? s.at[axis] < t.at[axis] : s.triangle < t.triangle;
                     });
    build(begin, middle, centres);
    nodes_[self].right = static_cast<int>(nodes_.size());
    build(middle, end, centres);
}

/// Twins that stayed together get the coordinates and number of the first: pins move both sides of a seam equally only
/// to round-off.
Points IntersectionTree::with_closed_seams(const Points& vertices, std::vector<int>& id) const {
    Points result = vertices;
    id.resize(twin_.size());
    for (std::size_t v = 0; v < twin_.size(); ++v) {
        const bool together = (vertices.row(v) - vertices.row(twin_[v])).norm() <= seam_;
        id[v] = together ? twin_[v] : static_cast<int>(v);
        if (together) result.row(v) = vertices.row(twin_[v]);
    }
    return result;
}

Intersections IntersectionTree::search(const Points& vertices, const std::vector<char>& moved) const {
    if (order_.empty()) return {};
    std::vector<int> id;
    Points closed;
    if (!twin_.empty()) closed = with_closed_seams(vertices, id);
    Search walk{*this, twin_.empty() ? vertices : closed, id, moved, {}, {}, {}, {}};
    walk.refit();
    walk.within(0);
    std::sort(walk.found.apart.begin(), walk.found.apart.end());
    std::sort(walk.found.adjacent.begin(), walk.found.adjacent.end());
    return std::move(walk.found);
}

std::vector<std::array<int, 2>> IntersectionTree::fresh(const Points& vertices) const {
    const Triangles& triangles = rest_->triangles;
    std::vector<char> moved(triangles.rows());
    for (int t = 0; t < triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k)
            if (vertices.row(triangles(t, k)) != rest_->vertices.row(triangles(t, k))) moved[t] = 1;
    const auto joined = [](Intersections all) {
        all.apart.insert(all.apart.end(), all.adjacent.begin(), all.adjacent.end());
        std::sort(all.apart.begin(), all.apart.end());
        return all.apart;
    };
    const std::vector<std::array<int, 2>> now = joined(search(vertices, moved)), before = joined(at_rest_);
    std::vector<std::array<int, 2>> result;
    std::set_difference(now.begin(), now.end(), before.begin(), before.end(), std::back_inserter(result));
    return result;
}

Intersections intersections(const TriMesh& mesh) {
    const std::shared_ptr<const TriMesh> borrowed(std::shared_ptr<const TriMesh>(), &mesh);
    return IntersectionTree(borrowed).at_rest();
}

std::vector<std::array<int, 2>> self_intersections(const TriMesh& mesh) { return intersections(mesh).apart; }

}  // namespace strake
