#include "core/mesh/point_tree.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace strake {
namespace {

constexpr int leaf = 8;  // points that are looked at one by one

}  // namespace

PointTree::PointTree(const Points& points)
    : points_(points), number_(static_cast<std::size_t>(points.rows())), axis_(number_.size(), 0) {
    std::iota(number_.begin(), number_.end(), 0);
    std::size_t nodes = 1;
    for (Eigen::Index count = points.rows(); count > leaf; count /= 2) nodes = 2 * nodes + 1;
    box_.resize(nodes);
    build(0, static_cast<int>(points.rows()), 0);
    for (std::size_t i = 0; i < number_.size(); ++i) points_.row(static_cast<Eigen::Index>(i)) = points.row(number_[i]);
}

/// `points_` is in the order of the input until all ranges are divided.
void PointTree::build(int begin, int end, std::size_t node) {
    if (begin == end) return;
    Eigen::RowVector3d low = points_.row(number_[begin]), high = low;
    for (int i = begin; i < end; ++i) {
        low = low.cwiseMin(points_.row(number_[i]));
        high = high.cwiseMax(points_.row(number_[i]));
    }
    box_[node] = {low, high};
    if (end - begin <= leaf) return;
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(number_.begin() + begin, number_.begin() + middle, number_.begin() + end, [&](int a, int b) {
        return points_(a, axis) < points_(b, axis) || (points_(a, axis) == points_(b, axis) && a < b);
    });
    axis_[middle] = static_cast<char>(axis);
    build(begin, middle, 2 * node + 1);
    build(middle + 1, end, 2 * node + 2);
}

void PointTree::search(int begin, int end, const Eigen::Vector3d& x, int& best, double& least) const {
    const auto look_at = [&](int i) {
        const double distance = (points_.row(i).transpose() - x).norm();
        if (distance < least || (distance == least && number_[i] < best)) best = number_[i], least = distance;
    };
    if (end - begin <= leaf) {
        for (int i = begin; i < end; ++i) look_at(i);
        return;
    }
    const int middle = begin + (end - begin) / 2;
    const double beyond = x[axis_[middle]] - points_(middle, axis_[middle]);
    look_at(middle);
    const bool is_low = beyond < 0;
    search(is_low ? begin : middle + 1, is_low ? middle : end, x, best, least);
    if (std::abs(beyond) <= least) search(is_low ? middle + 1 : begin, is_low ? end : middle, x, best, least);
}

std::pair<int, double> PointTree::nearest(const Eigen::Vector3d& x) const {
    int best = -1;
    double least = std::numeric_limits<double>::infinity();
    search(0, static_cast<int>(number_.size()), x, best, least);
    return {best, least};
}

void PointTree::collect(int begin, int end, const Eigen::Vector3d& x, double radius, std::vector<int>& found) const {
    const auto look_at = [&](int i) {
        if ((points_.row(i).transpose() - x).norm() <= radius) found.push_back(number_[i]);
    };
    if (end - begin <= leaf) {
        for (int i = begin; i < end; ++i) look_at(i);
        return;
    }
    const int middle = begin + (end - begin) / 2;
    const double beyond = x[axis_[middle]] - points_(middle, axis_[middle]);
    look_at(middle);
    if (beyond <= radius) collect(begin, middle, x, radius, found);
    if (beyond >= -radius) collect(middle + 1, end, x, radius, found);
}

void PointTree::within(const Eigen::Vector3d& x, double radius, std::vector<int>& found) const {
    found.clear();
    collect(0, static_cast<int>(number_.size()), x, radius, found);
    std::sort(found.begin(), found.end());
}

namespace {

bool is_near(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& x, double radius) {
    const Eigen::Vector3d side = q - p;
    const double along = side.squaredNorm() > 0 ? std::clamp((x - p).dot(side) / side.squaredNorm(), 0.0, 1.0) : 0;
    return (x - p - along * side).norm() <= radius;
}

/// The segment from p to q comes as near as `radius` to the box, or a little farther, at a corner.
bool meets(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::RowVector3d& low,
           const Eigen::RowVector3d& high, double radius) {
    double from = 0, to = 1;
    for (int k = 0; k < 3; ++k) {
        const double begin = low[k] - radius - p[k], end = high[k] + radius - p[k], way = q[k] - p[k];
        if (begin > std::max(0.0, way) || end < std::min(0.0, way)) return false;
        if (way == 0) continue;
        from = std::max(from, (way > 0 ? begin : end) / way);
        to = std::min(to, (way > 0 ? end : begin) / way);
    }
    constexpr double rounding = 1e-9;  // of shares of the way
    return from <= to + rounding;
}

}  // namespace

void PointTree::collect(int begin, int end, std::size_t node, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                        double radius, std::vector<int>& found) const {
    if (begin == end || !meets(p, q, box_[node].low, box_[node].high, radius)) return;
    const auto look_at = [&](int i) {
        if (is_near(p, q, points_.row(i), radius)) found.push_back(number_[i]);
    };
    if (end - begin <= leaf) {
        for (int i = begin; i < end; ++i) look_at(i);
        return;
    }
    const int middle = begin + (end - begin) / 2;
    look_at(middle);
    collect(begin, middle, 2 * node + 1, p, q, radius, found);
    collect(middle + 1, end, 2 * node + 2, p, q, radius, found);
}

void PointTree::near_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& q, double radius,
                             std::vector<int>& found) const {
    found.clear();
    constexpr double rounding = 1e-12;  // of the size of the coordinates
    const double size = std::max(p.cwiseAbs().maxCoeff(), q.cwiseAbs().maxCoeff());
    collect(0, static_cast<int>(number_.size()), 0, p, q, radius + rounding * (size + radius), found);
    std::sort(found.begin(), found.end());
}

}  // namespace strake
