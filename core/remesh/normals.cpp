#include "core/remesh/normals.hpp"

#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake {

using Eigen::Vector3d;

namespace {

/// Of the triangles beside t whose normals are known, the one whose normal agrees best with those of the others and
/// with that of t itself, as far as that means anything; -1: none. Across a crease along its longest side, a sliver
/// would turn the crease's line to its apex.
int likest_beside(const BaseSurface& base, const std::vector<char>& known, int t, int fewest) {
    int best = -1, count = 0;
    double best_fit = 0;
    for (int h = 3 * t; h < 3 * t + 3; ++h) {
        const int beside = base.twin[h] >= 0 ? base.twin[h] / 3 : -1;
        if (beside < 0 || !known[beside]) continue;
        ++count;
        double fit = base.normal[beside].dot(base.normal[t]);
        for (int g = 3 * t; g < 3 * t + 3; ++g)
            if (g != h && base.twin[g] >= 0 && known[base.twin[g] / 3])
                fit += base.normal[beside].dot(base.normal[base.twin[g] / 3]);
        if (best >= 0 && !(fit > best_fit)) continue;
        best = beside;
        best_fit = fit;
    }
    return count >= fewest ? best : -1;
}

}  // namespace

void find_normals(BaseSurface& base) {
    const int m = static_cast<int>(base.tri.size());
    base.normal.resize(m);
    std::vector<int> flat;
    std::vector<char> known(m, 1);
    for (int t = 0; t < m; ++t) {
        const Vector3d a = base.points[base.tri[t][0]], b = base.points[base.tri[t][1]],
                       c = base.points[base.tri[t][2]];
        const Vector3d n = (b - a).cross(c - a);
        const double longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
        const double twice_area = n.norm();
        base.area += 0.5 * twice_area;
        base.mean_edge += (b - a).norm() + (c - b).norm() + (a - c).norm();
        // Thinner than 1e-5 diagonals: its normal is noise and would make each long side a crease.
        known[t] = twice_area > std::max(1e-9 * longest2, 1e-5 * base.diagonal * std::sqrt(longest2));
        base.normal[t] = twice_area > 0 ? Vector3d(n / twice_area) : Vector3d::Zero();
        if (!known[t]) flat.push_back(t);
    }
    base.mean_edge /= std::max(3 * m, 1);
    for (int fewest = 2, round = 0; round < 16 && !flat.empty() && fewest > 0; ++round) {
        std::vector<int> left;
        std::vector<std::pair<int, int>> taken;
        for (const int t : flat) {
            const int like = likest_beside(base, known, t, fewest);
            if (like >= 0)
                taken.push_back({t, like});
            else
                left.push_back(t);
        }
        for (const auto& [t, like] : taken) {
            base.normal[t] = base.normal[like];
            known[t] = 1;
        }
        fewest = taken.empty() ? fewest - 1 : 2;
        flat.swap(left);
    }
}

namespace {

/// Shorter than this share of its own length, and than that one of the wanted length, is the height of a sliver.
constexpr double thin = 0.1, thin_of_wanted = 0.05;

bool is_sliver(const BaseSurface& base, int t) {
    const auto& [a, b, c] = base.tri[t];
    const Vector3d u = base.points[b] - base.points[a], w = base.points[c] - base.points[a];
    const double longest2 = std::max({u.squaredNorm(), w.squaredNorm(), (u - w).squaredNorm()});
    const double height = longest2 > 0 ? u.cross(w).norm() / std::sqrt(longest2) : 0;
    return height < std::min(thin * std::sqrt(longest2), thin_of_wanted * base.edge_length);
}

/// A sliver that deviates from all neighbours by more than these from each other is noise, for example of a scan or a
/// cut, and makes no crease: it takes the normal of one of them.
void level_folded(double angle, BaseSurface& base) {
    const std::vector<char> known(base.tri.size(), 1);
    std::vector<std::pair<int, Vector3d>> taken;
    for (int t = 0; t < static_cast<int>(base.tri.size()); ++t) {
        if (!is_sliver(base, t)) continue;
        std::vector<int> beside;
        for (int h = 3 * t; h < 3 * t + 3; ++h)
            if (base.twin[h] >= 0) beside.push_back(base.twin[h] / 3);
        if (beside.size() < 2) continue;
        double nearest = std::numbers::pi, apart = angle;
        for (std::size_t i = 0; i < beside.size(); ++i) {
            nearest = std::min(nearest, dihedral(base.normal[t], base.normal[beside[i]]));
            for (std::size_t j = 0; j < i; ++j)
                apart = std::max(apart, dihedral(base.normal[beside[i]], base.normal[beside[j]]));
        }
        if (nearest > apart) taken.push_back({t, base.normal[likest_beside(base, known, t, 1)]});
    }
    for (const auto& [t, normal] : taken) base.normal[t] = normal;
}

/// Slivers side by side, folded up and down like a bellows, as in triangulations of twisted ruled surfaces: the fold is
/// an artefact. Each takes the mean of its normal and those at its long sides.
class Bellows {
public:
    Bellows(double angle, BaseSurface& base) : min_turn_(0.5 * angle), base_(base) {}

    void level() {
        const int m = static_cast<int>(base_.tri.size());
        std::vector<char> is_fold(m, 0);
        for (int t = 0; t < m; ++t) is_fold[t] = is_sliver(base_, t) && turns_both_ways(t);
        std::vector<std::pair<int, Vector3d>> taken;
        for (int t = 0; t < m; ++t) {
            if (!is_fold[t]) continue;
            const auto [g, h] = long_sides(t);
            const int before = base_.twin[g] / 3, after = base_.twin[h] / 3;
            if (!is_fold[before] && !is_fold[after]) continue;
            const Vector3d sum = area_vector(before) + 2 * area_vector(t) + area_vector(after);
            const double length = sum.norm();
            if (length > 0) taken.push_back({t, sum / length});
        }
        for (const auto& [t, normal] : taken) base_.normal[t] = normal;
    }

private:
    Vector3d along(int h) const { return base_.points[base_.from(base_.next(h))] - base_.points[base_.from(h)]; }
    std::array<int, 2> long_sides(int t) const {
        int shortest = 3 * t;
        for (int h = 3 * t + 1; h < 3 * t + 3; ++h)
            if (along(h).squaredNorm() < along(shortest).squaredNorm()) shortest = h;
        return {base_.next(shortest), base_.prev(shortest)};
    }
    double turn_at(int h) const {  // > 0: convex
        const Vector3d &n = base_.normal[h / 3], &m = base_.normal[base_.twin[h] / 3];
        return std::atan2(n.cross(m).dot(along(h).normalized()), n.dot(m));
    }
    bool turns_both_ways(int t) const {
        const auto [g, h] = long_sides(t);
        if (base_.twin[g] < 0 || base_.twin[h] < 0) return false;
        const double one = turn_at(g), other = turn_at(h);
        return one * other < 0 && std::min(std::abs(one), std::abs(other)) >= min_turn_;
    }
    Vector3d area_vector(int t) const {
        const auto& [a, b, c] = base_.tri[t];
        const double twice = (base_.points[b] - base_.points[a]).cross(base_.points[c] - base_.points[a]).norm();
        return twice * base_.normal[t];
    }

    double min_turn_;  ///< turn, radians
    BaseSurface& base_;
};

}  // namespace

void level_slivers(double angle, BaseSurface& base) {
    level_folded(angle, base);
    Bellows(angle, base).level();
}

}  // namespace strake
