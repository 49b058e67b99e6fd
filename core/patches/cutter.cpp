#include "core/patches/cutter.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace strake {

int worth(double x) { return std::max(1, static_cast<int>(std::floor(x + 0.45))); }

void Cutter::cut_into(std::vector<Piece>& pieces, const Piece& piece, int wanted) {
    const TriangleSet& set = piece.triangles;
    std::vector<TriangleSet> found{set};
    bool planned = false;
    if (wanted > 1 && set.size() > 1) {
        found = along_creases(set, wanted);
        if (found.size() < 2) found = two_sides(set, wanted);
        planned = found.size() < 2;
        const std::array<int, 3> axes = axes_by_extent(set);
        for (int j = 0; j < 3 && found.size() < 2; ++j) found = across_axis(set, wanted, axes[j]);
    }
    if (found.size() < 2) {
        pieces.push_back(piece);
        return;
    }
    // If a plane gave two parts of about its target areas, the targets stay; otherwise the actual areas.
    const double total = area(set), first = area(found[0]) / total;
    const int below = wanted / 2, above = wanted - below;
    const int lower = std::abs(first * wanted - below) <= std::abs(first * wanted - above) ? below : above;
    if (planned && found.size() == 2 && std::abs(first * wanted - lower) < 0.2 * below) {
        cut_into(pieces, {found[0], piece.due * lower / wanted}, lower);
        cut_into(pieces, {found[1], piece.due * (wanted - lower) / wanted}, wanted - lower);
        return;
    }
    for (const TriangleSet& part : found) {
        const double share = area(part) / total;
        cut_into(pieces, {part, piece.due * share}, worth(wanted * share));
    }
}

std::vector<TriangleSet> Cutter::along_creases(const TriangleSet& set, int wanted) {
    std::vector<int> key(set.size());
    for (std::size_t i = 0; i < set.size(); ++i) key[i] = creases_.near[set[i]] ? -1 : 0;
    return parts_.split(set, key, true, least(set, wanted));
}

/// A sheet: nearly all normals along one direction d, a quarter of the area at least facing either way. The border runs
/// where the normal is perpendicular to d, which on a rounded leading edge is the same line on every mesh.
std::vector<TriangleSet> Cutter::two_sides(const TriangleSet& set, int wanted) {
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    for (const int t : set) N += body_.features.areas[t] * body_.normals.row(t).transpose() * body_.normals.row(t);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(N / area(set));
    if (!(solver.eigenvalues()[2] >= 0.7)) return {set};
    const Eigen::Vector3d d = solver.eigenvectors().col(2);
    std::vector<int> key(set.size());
    double up = 0, down = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
        const double c = body_.normals.row(set[i]).dot(d);
        key[i] = c > 0.1 ? 1 : c < -0.1 ? 0 : -1;
        if (key[i] == 1) up += body_.features.areas[set[i]];
        if (key[i] == 0) down += body_.features.areas[set[i]];
    }
    if (std::min(up, down) < 0.25 * area(set)) return {set};
    return parts_.split(set, key, false, least(set, wanted));
}

/// Cuts at the plane with the fraction floor(wanted / 2) / wanted of the area below it.
std::vector<TriangleSet> Cutter::across_axis(const TriangleSet& set, int wanted, int axis) {
    std::vector<double> at(set.size());
    for (std::size_t i = 0; i < set.size(); ++i)
        at[i] = body_.axes.col(axis).dot(body_.centroids.row(set[i]).transpose());
    std::vector<int> order(set.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) { return at[a] != at[b] ? at[a] < at[b] : a < b; });
    const double below = area(set) * (wanted / 2) / wanted;
    // Triangles count half at their centroids; between two of these the area grows linearly.
    double sum = 0, previous = 0, where = at[order[0]], plane = at[order.back()];
    for (const int i : order) {
        const double half = 0.5 * body_.features.areas[set[i]];
        if (sum + half >= below) {
            const double gain = sum + half - previous;
            plane = gain > 0 ? where + (at[i] - where) * std::clamp((below - previous) / gain, 0.0, 1.0) : at[i];
            break;
        }
        previous = sum + half, where = at[i], sum += 2 * half;
    }
    // Centroids in the plane itself (structured and mirrored meshes) stay together despite round-off.
    plane += 1e-9 * std::sqrt(body_.area);
    std::vector<int> key(set.size());
    for (std::size_t i = 0; i < set.size(); ++i) key[i] = at[i] > plane;
    return parts_.split(set, key, false, least(set, wanted));
}

/// Principal axes in the order of the set's extent (second moment) along them. The longer axes of the body are
/// preferred by 25 % each: noise must not decide for square parts, a frequent result of halving.
std::array<int, 3> Cutter::axes_by_extent(const TriangleSet& set) const {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero(), square = Eigen::Vector3d::Zero();
    for (const int t : set) {
        const Eigen::Vector3d c = body_.axes.transpose() * (body_.centroids.row(t).transpose() - body_.centre);
        mean += body_.features.areas[t] * c;
        square += body_.features.areas[t] * c.cwiseAbs2();
    }
    const double total = area(set);
    const Eigen::Vector3d spread =
        (square / total - (mean / total).cwiseAbs2()).cwiseProduct(Eigen::Vector3d(1, 0.8, 0.64));
    std::array<int, 3> axes{0, 1, 2};
    std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return spread[a] > spread[b]; });
    return axes;
}

std::vector<Piece> Cutter::without_smallest(const TriangleSet& set, const std::vector<Piece>& pieces) {
    double smallest = area(pieces[0].triangles);
    for (const Piece& piece : pieces) smallest = std::min(smallest, area(piece.triangles));
    std::vector<int> owner(body_.mesh().num_triangles(), -1), key;
    for (std::size_t p = 0; p < pieces.size(); ++p)
        for (const int t : pieces[p].triangles) owner[t] = static_cast<int>(p);
    for (const int t : set) key.push_back(owner[t]);
    std::vector<Piece> fewer;
    for (const TriangleSet& part : parts_.split(set, key, false, smallest * (1 + 1e-9) + 1e-300))
        fewer.push_back({part, area(part)});
    return fewer;
}

}  // namespace strake
