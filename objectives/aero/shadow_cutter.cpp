#include "objectives/aero/shadow_cutter.hpp"

#include "core/mesh/geometry.hpp"

#include <cmath>

namespace strake {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double same_depth_rel = 1e-9;  // of the diagonal: touching triangles do not hide each other
constexpr double along_border = 1e-10;   // an edge this close to a triangle's border lies on it

Vector2d centre_of(const ShadowPiece& piece) {
    Vector2d sum = Vector2d::Zero();
    for (const Vector2d& corner : piece) sum += corner;
    return sum / static_cast<double>(piece.size());
}

}  // namespace

double area_of(const ShadowPiece& piece) {
    double double_area = 0;
    for (std::size_t i = 1; i + 1 < piece.size(); ++i)
        double_area += cross(piece[i] - piece[0], piece[i + 1] - piece[0]);
    return 0.5 * double_area;
}

ShadowCutter::ShadowCutter(const TriMesh& m, const Vector3d& u) : mesh(m) {
    int axis = 0;
    u.cwiseAbs().minCoeff(&axis);
    b1 = u.cross(Vector3d::Unit(axis)).normalized();
    b2 = b1.cross(u);  // b1 x b2 = -u: triangles that face the stream run anticlockwise
    at.resize(m.num_vertices(), 2);
    depth.resize(m.num_vertices());
    for (int v = 0; v < m.num_vertices(); ++v) {
        const Vector3d x = m.vertices.row(v);
        at.row(v) << b1.dot(x), b2.dot(x);
        depth[v] = u.dot(x);
    }
    for (int t = 0; t < m.num_triangles(); ++t)
        if (u.dot(area_vector(m, t)) < 0) front.push_back(t);
    for (const int t : front) {
        const double a = depth[m.triangles(t, 0)], b = depth[m.triangles(t, 1)], c = depth[m.triangles(t, 2)];
        nearest.push_back(std::min({a, b, c}));
        farthest.push_back(std::max({a, b, c}));
        boxes.emplace_back(corner(t, 0)).extend(corner(t, 1)).extend(corner(t, 2));
    }
    tolerance = same_depth_rel * box_diagonal(m);
    fill_grid();
}

template <class Visit>
void ShadowCutter::cells_of(int i, const Visit& visit) const {
    const Vector2d from = (boxes[i].min() - low) / cell, to = (boxes[i].max() - low) / cell;
    const auto clamped = [](double x, int count) { return std::clamp(static_cast<int>(x), 0, count - 1); };
    for (int row = clamped(from[1], rows); row <= clamped(to[1], rows); ++row)
        for (int column = clamped(from[0], columns); column <= clamped(to[0], columns); ++column)
            visit(row * columns + column);
}

void ShadowCutter::fill_grid() {
    if (front.empty()) return;
    Eigen::AlignedBox2d all;
    double areas = 0;
    for (const Eigen::AlignedBox2d& box : boxes) {
        all.extend(box);
        areas += box.volume();
    }
    low = all.min();
    const Vector2d size = all.sizes();
    const double count = static_cast<double>(front.size()), longest = size.maxCoeff();
    // About as large as a triangle's box, and never many more cells than triangles.
    cell = std::max({std::sqrt(areas / count), std::sqrt(size.prod() / (2 * count)), longest / (2 * count + 1)});
    if (!(cell > 0)) cell = 1;
    columns = static_cast<int>(size[0] / cell) + 1;
    rows = static_cast<int>(size[1] / cell) + 1;
    begin.assign(static_cast<std::size_t>(columns) * rows + 1, 0);
    for (int i = 0; i < static_cast<int>(front.size()); ++i) cells_of(i, [&](int c) { ++begin[c + 1]; });
    for (std::size_t c = 1; c < begin.size(); ++c) begin[c] += begin[c - 1];
    items.resize(begin.back());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (int i = 0; i < static_cast<int>(front.size()); ++i) cells_of(i, [&](int c) { items[next[c]++] = i; });
    for (std::size_t c = 0; c + 1 < begin.size(); ++c)
        std::sort(items.begin() + begin[c], items.begin() + begin[c + 1],
                  [&](int i, int j) { return std::pair(nearest[i], i) < std::pair(nearest[j], j); });
}

bool ShadowCutter::apart(int t, int o) const {
    for (int turn = 0; turn < 2; ++turn, std::swap(t, o))
        for (int k = 0; k < 3; ++k)
            if (side(t, k, corner(o, 0)) <= 0 && side(t, k, corner(o, 1)) <= 0 && side(t, k, corner(o, 2)) <= 0)
                return true;
    return false;
}

bool ShadowCutter::share_edge(int t, int o) const {
    int shared = 0;
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) shared += mesh.triangles(t, k) == mesh.triangles(o, l);
    return shared >= 2;
}

double ShadowCutter::depth_at(int t, const Vector2d& x) const {
    double sum = 0, total = 0;
    for (int k = 0; k < 3; ++k) {
        const double weight = side(t, k, x);
        sum += weight * depth[mesh.triangles(t, (k + 2) % 3)];
        total += weight;
    }
    return sum / total;
}

/// The parts of a convex piece on either side of edge k of t.
void ShadowCutter::split(const ShadowPiece& piece, int t, int k, ShadowPiece* inside, ShadowPiece* outside) const {
    const std::size_t n = piece.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Vector2d &a = piece[i], &b = piece[(i + 1) % n];
        const double da = side(t, k, a), db = side(t, k, b);
        if (ShadowPiece* side_of_a = da >= 0 ? inside : outside) side_of_a->push_back(a);
        if ((da >= 0) == (db >= 0)) continue;
        const Vector2d at = a + da / (da - db) * (b - a);
        if (inside) inside->push_back(at);
        if (outside) outside->push_back(at);
    }
}

/// Whether o lies upstream of t where their projections overlap.
bool ShadowCutter::hides(int o, int t) const {
    ShadowPiece common = piece_of(t);
    for (int k = 0; k < 3; ++k) {
        ShadowPiece inside;
        split(common, o, k, &inside, nullptr);
        common = std::move(inside);
        if (common.size() < 3) return false;
    }
    const Vector2d centre = centre_of(common);
    return depth_at(o, centre) < depth_at(t, centre) - tolerance;
}

void ShadowCutter::subtract(std::vector<ShadowPiece>& pieces, int o, double least) const {
    std::vector<ShadowPiece> left;
    for (ShadowPiece& piece : pieces) {
        for (int k = 0; k < 3; ++k) {
            ShadowPiece inside, outside;
            split(piece, o, k, &inside, &outside);
            if (outside.size() >= 3 && area_of(outside) > least) left.push_back(std::move(outside));
            piece = std::move(inside);
            if (piece.size() < 3) break;
        }
    }
    pieces = std::move(left);
}

/// The visible part of triangle front[i]; sets `hiders` to the triangles that hide some of it, ascending. Empty
/// optional when nothing hides it.
auto ShadowCutter::cut_out(int i, double least, std::vector<int>& seen, std::vector<int>& hiders) const
    -> std::optional<std::vector<ShadowPiece>> {
    const int t = front[i];
    std::optional<std::vector<ShadowPiece>> pieces;
    hiders.clear();
    cells_of(i, [&](int c) {
        for (int item = begin[c]; item < begin[c + 1]; ++item) {
            const int j = items[item], o = front[j];
            if (nearest[j] >= farthest[i] - tolerance || (pieces && pieces->empty())) break;
            if (seen[j] == i || j == i) continue;
            seen[j] = i;
            if ((boxes[i].min().array() >= boxes[j].max().array()).any() ||
                (boxes[j].min().array() >= boxes[i].max().array()).any() || apart(t, o) || share_edge(t, o) ||
                !hides(o, t))
                continue;
            if (!pieces) pieces.emplace(1, piece_of(t));
            hiders.push_back(o);
            subtract(*pieces, o, least);
        }
    });
    std::sort(hiders.begin(), hiders.end());
    return pieces;
}

/// The part of the segment from a to b inside o; its border does not count.
Interval ShadowCutter::within(int o, const Vector2d& a, const Vector2d& b, double margin) const {
    Interval found{0, 1};
    for (int k = 0; k < 3; ++k) {
        const double length = (corner(o, (k + 1) % 3) - corner(o, k)).norm();
        const double least = margin * length * (length + (b - a).norm());
        const double fa = side(o, k, a) - least, fb = side(o, k, b) - least;
        if (fa <= 0 && fb <= 0) return {1, 0};
        if (fa < 0) found.from = std::max(found.from, fa / (fa - fb));
        if (fb < 0) found.to = std::min(found.to, fa / (fa - fb));
    }
    return found;
}

/// Whether the triangle across edge k of o is a hider too: then the edge is no border.
bool ShadowCutter::continues(int o, int k, const std::vector<int>& hiders) const {
    const int v = mesh.triangles(o, k), w = mesh.triangles(o, (k + 1) % 3);
    return std::any_of(hiders.begin(), hiders.end(), [&](int other) {
        for (int l = 0; l < 3; ++l)
            if (mesh.triangles(other, l) == w && mesh.triangles(other, (l + 1) % 3) == v) return true;
        return false;
    });
}

/// The parts of edge k of o that border the visible part of t: inside t (or on its own edge) and inside no hider.
std::vector<Interval> ShadowCutter::seen_of_edge(int t, int o, int k, const std::vector<int>& hiders) const {
    const Vector2d a = corner(o, k), b = corner(o, (k + 1) % 3);
    std::vector<Interval> open{o == t ? Interval{0, 1} : within(t, a, b, 0)};
    for (const int hider : hiders) {
        if (hider == o) continue;
        const Interval hidden = within(hider, a, b, along_border);
        std::vector<Interval> left;
        for (const Interval& part : open) {
            if (hidden.from >= hidden.to)
                left.push_back(part);
            else {
                left.push_back({part.from, std::min(part.to, hidden.from)});
                left.push_back({std::max(part.from, hidden.to), part.to});
            }
        }
        std::erase_if(left, [](const Interval& part) { return !(part.from < part.to); });
        open = std::move(left);
    }
    std::erase_if(open, [](const Interval& part) { return !(part.from < part.to); });
    return open;
}

}  // namespace strake
