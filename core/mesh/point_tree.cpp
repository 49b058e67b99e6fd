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
    build(0, static_cast<int>(points.rows()));
    for (std::size_t i = 0; i < number_.size(); ++i) points_.row(static_cast<Eigen::Index>(i)) = points.row(number_[i]);
}

/// `points_` is in the order of the input until all ranges are divided.
void PointTree::build(int begin, int end) {
    if (end - begin <= leaf) return;
    Eigen::RowVector3d low = points_.row(number_[begin]), high = low;
    for (int i = begin; i < end; ++i) {
        low = low.cwiseMin(points_.row(number_[i]));
        high = high.cwiseMax(points_.row(number_[i]));
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(number_.begin() + begin, number_.begin() + middle, number_.begin() + end, [&](int a, int b) {
        return points_(a, axis) < points_(b, axis) || (points_(a, axis) == points_(b, axis) && a < b);
    });
    axis_[middle] = static_cast<char>(axis);
    build(begin, middle);
    build(middle + 1, end);
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

}  // namespace strake
