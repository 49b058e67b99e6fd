#include "objectives/visible_area.hpp"

#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace strake {

/// A corner of a convex piece; `edge` is the line from here to the next one: 3 triangle + corner.
struct VisibleAreas::Corner {
    Eigen::Vector2d at;
    int edge;
};

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double same_depth_rel = 1e-9;  // of the diagonal: what touches does not hide
constexpr double no_area_rel = 1e-13;    // of a triangle's own projected area

double cross(const Vector2d& a, const Vector2d& b) { return a[0] * b[1] - a[1] * b[0]; }

template <class Piece>
double area_of(const Piece& piece) {
    double twice = 0;
    for (std::size_t i = 1; i + 1 < piece.size(); ++i)
        twice += cross(piece[i].at - piece[0].at, piece[i + 1].at - piece[0].at);
    return 0.5 * twice;
}

template <class Piece>
Vector2d centre_of(const Piece& piece) {
    Vector2d sum = Vector2d::Zero();
    for (const auto& corner : piece) sum += corner.at;
    return sum / static_cast<double>(piece.size());
}

}  // namespace

/// The projected triangles, in a grid of square cells.
struct VisibleAreas::Cutter {
    const TriMesh& mesh;
    Vector3d b1, b2;
    Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> at;  ///< projected vertices
    Eigen::VectorXd depth;                                         ///< along u
    std::vector<int> front;                                        ///< triangles that face the stream
    double cell = 1, tolerance = 0;
    Vector2d low;
    int columns = 1, rows = 1;
    std::vector<int> begin, items;          ///< per cell, places in `front`
    std::vector<double> nearest, farthest;  ///< depths of the front triangles

    Cutter(const TriMesh& m, const Vector3d& u);
    void fill_grid();
    template <class Visit>
    void cells_of(int t, const Visit& visit) const;

    Vector2d corner(int t, int k) const { return at.row(mesh.triangles(t, k)); }
    Piece piece_of(int t) const {
        return {{corner(t, 0), 3 * t}, {corner(t, 1), 3 * t + 1}, {corner(t, 2), 3 * t + 2}};
    }
    /// Twice the area of x with edge k of t: > 0 inside. From the smaller to the larger vertex, so that both triangles
    /// at an edge get the same bits.
    double side(int t, int k, const Vector2d& x) const {
        const int v = mesh.triangles(t, k), w = mesh.triangles(t, (k + 1) % 3);
        const Vector2d p = at.row(std::min(v, w)), q = at.row(std::max(v, w));
        return cross(q - p, x - p) * (v < w ? 1 : -1);
    }
    bool apart(int t, int o) const;
    bool share_edge(int t, int o) const;
    double depth_at(int t, const Vector2d& x) const;
    void split(const Piece& piece, int t, int k, Piece* inside, Piece* outside) const;
    bool hides(int o, int t) const;
    void subtract(std::vector<Piece>& pieces, int o, double least) const;
    std::optional<std::vector<Piece>> cut_out(int i, double least, std::vector<int>& seen) const;
};

VisibleAreas::Cutter::Cutter(const TriMesh& m, const Vector3d& u) : mesh(m) {
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
    }
    tolerance = same_depth_rel * box_diagonal(m);
    fill_grid();
}

template <class Visit>
void VisibleAreas::Cutter::cells_of(int t, const Visit& visit) const {
    const Vector2d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    const Vector2d from = (a.cwiseMin(b).cwiseMin(c) - low) / cell, to = (a.cwiseMax(b).cwiseMax(c) - low) / cell;
    const auto clamped = [](double x, int count) { return std::clamp(static_cast<int>(x), 0, count - 1); };
    for (int j = clamped(from[1], rows); j <= clamped(to[1], rows); ++j)
        for (int i = clamped(from[0], columns); i <= clamped(to[0], columns); ++i) visit(j * columns + i);
}

void VisibleAreas::Cutter::fill_grid() {
    if (front.empty()) return;
    low = at.row(mesh.triangles(front[0], 0));
    Vector2d high = low;
    double boxes = 0;
    for (const int t : front) {
        const Vector2d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
        const Vector2d from = a.cwiseMin(b).cwiseMin(c), to = a.cwiseMax(b).cwiseMax(c);
        low = low.cwiseMin(from);
        high = high.cwiseMax(to);
        boxes += (to - from).prod();
    }
    const Vector2d size = high - low;
    const double count = static_cast<double>(front.size()), longest = size.maxCoeff();
    // About as large as a triangle's box, and never many more cells than triangles.
    cell = std::max({std::sqrt(boxes / count), std::sqrt(size.prod() / (2 * count)), longest / (2 * count + 1)});
    if (!(cell > 0)) cell = 1;
    columns = static_cast<int>(size[0] / cell) + 1;
    rows = static_cast<int>(size[1] / cell) + 1;
    begin.assign(static_cast<std::size_t>(columns) * rows + 1, 0);
    for (const int t : front) cells_of(t, [&](int c) { ++begin[c + 1]; });
    for (std::size_t c = 1; c < begin.size(); ++c) begin[c] += begin[c - 1];
    items.resize(begin.back());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (std::size_t i = 0; i < front.size(); ++i)
        cells_of(front[i], [&](int c) { items[next[c]++] = static_cast<int>(i); });
}

bool VisibleAreas::Cutter::apart(int t, int o) const {
    for (int turn = 0; turn < 2; ++turn, std::swap(t, o))
        for (int k = 0; k < 3; ++k)
            if (side(t, k, corner(o, 0)) <= 0 && side(t, k, corner(o, 1)) <= 0 && side(t, k, corner(o, 2)) <= 0)
                return true;
    return false;
}

bool VisibleAreas::Cutter::share_edge(int t, int o) const {
    int shared = 0;
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) shared += mesh.triangles(t, k) == mesh.triangles(o, l);
    return shared >= 2;
}

double VisibleAreas::Cutter::depth_at(int t, const Vector2d& x) const {
    double sum = 0, total = 0;
    for (int k = 0; k < 3; ++k) {
        const double weight = side(t, k, x);
        sum += weight * depth[mesh.triangles(t, (k + 2) % 3)];
        total += weight;
    }
    return sum / total;
}

/// The parts of a convex piece on either side of edge k of t.
void VisibleAreas::Cutter::split(const Piece& piece, int t, int k, Piece* inside, Piece* outside) const {
    const std::size_t n = piece.size();
    const int line = 3 * t + k;
    for (std::size_t i = 0; i < n; ++i) {
        const Corner &a = piece[i], &b = piece[(i + 1) % n];
        const double da = side(t, k, a.at), db = side(t, k, b.at);
        const bool in = da >= 0, next_in = db >= 0;
        if (Piece* side_of_a = in ? inside : outside) side_of_a->push_back(a);
        if (in == next_in) continue;
        const Vector2d at = a.at + da / (da - db) * (b.at - a.at);
        // Where the piece leaves a side the border goes on along the line; where it enters, along the piece's edge.
        if (Piece* leaves = in ? inside : outside) leaves->push_back({at, line});
        if (Piece* enters = in ? outside : inside) enters->push_back({at, a.edge});
    }
}

/// Whether o lies upstream of t where both project to the same places.
bool VisibleAreas::Cutter::hides(int o, int t) const {
    Piece common = piece_of(t);
    for (int k = 0; k < 3; ++k) {
        Piece inside;
        split(common, o, k, &inside, nullptr);
        common = std::move(inside);
        if (common.size() < 3) return false;
    }
    const Vector2d centre = centre_of(common);
    return depth_at(o, centre) < depth_at(t, centre) - tolerance;
}

void VisibleAreas::Cutter::subtract(std::vector<Piece>& pieces, int o, double least) const {
    std::vector<Piece> left;
    for (Piece& piece : pieces) {
        for (int k = 0; k < 3; ++k) {
            Piece inside, outside;
            split(piece, o, k, &inside, &outside);
            if (outside.size() >= 3 && area_of(outside) > least) left.push_back(std::move(outside));
            piece = std::move(inside);
            if (piece.size() < 3) break;
        }
    }
    pieces = std::move(left);
}

/// What is left of triangle front[i] when all that hides some of it is cut out; nothing where nothing does.
auto VisibleAreas::Cutter::cut_out(int i, double least, std::vector<int>& seen) const
    -> std::optional<std::vector<Piece>> {
    const int t = front[i];
    std::optional<std::vector<Piece>> pieces;
    cells_of(t, [&](int c) {
        for (int item = begin[c]; item < begin[c + 1]; ++item) {
            const int j = items[item], o = front[j];
            if (seen[j] == i || j == i || (pieces && pieces->empty())) continue;
            seen[j] = i;
            if (nearest[j] >= farthest[i] - tolerance || apart(t, o) || share_edge(t, o) || !hides(o, t)) continue;
            if (!pieces) pieces = {{piece_of(t)}};
            subtract(*pieces, o, least);
        }
    });
    return pieces;
}

VisibleAreas::VisibleAreas(const TriMesh& mesh, const Vector3d& u) : mesh_(mesh), u_(u) {
    const Cutter cutter(mesh, u);
    area_ = Eigen::VectorXd::Zero(mesh.num_triangles());
    hidden_.assign(static_cast<std::size_t>(mesh.num_triangles()), 0);
    std::vector<int> seen(cutter.front.size(), -1);
    for (std::size_t i = 0; i < cutter.front.size(); ++i) {
        const int t = cutter.front[i];
        const double full = -u.dot(area_vector(mesh, t));
        const auto pieces = cutter.cut_out(static_cast<int>(i), no_area_rel * full, seen);
        hidden_[t] = pieces.has_value();
        if (!pieces)
            area_[t] = full;
        else
            for (const Piece& piece : *pieces) add_piece(cutter, t, piece);
    }
}

void VisibleAreas::add_piece(const Cutter& cutter, int t, const Piece& piece) {
    area_[t] += area_of(piece);
    for (std::size_t c = 0; c < piece.size(); ++c) {
        const int o = piece[c].edge / 3, k = piece[c].edge % 3;
        const int p = mesh_.triangles(o, k), q = mesh_.triangles(o, (k + 1) % 3);
        const Vector2d a = piece[c].at, b = piece[(c + 1) % piece.size()].at, from = cutter.at.row(p);
        const Vector2d line = Vector2d(cutter.at.row(q)) - from;
        if (line.isZero(0)) continue;
        borders_.push_back({t, p, q, line.dot(0.5 * (a + b) - from) / line.squaredNorm(),
                            (b - a)[1] * cutter.b1 - (b - a)[0] * cutter.b2});
    }
}

void VisibleAreas::add_gradient(const Eigen::VectorXd& weight, Points& dJ_dv) const {
    for (int t = 0; t < mesh_.num_triangles(); ++t) {
        if (hidden_[t] || area_[t] == 0 || weight[t] == 0) continue;
        for (int k = 0; k < 3; ++k) {
            const Vector3d opposite = mesh_.vertices.row(mesh_.triangles(t, (k + 2) % 3)) -
                                      mesh_.vertices.row(mesh_.triangles(t, (k + 1) % 3));
            dJ_dv.row(mesh_.triangles(t, k)) -= 0.5 * weight[t] * u_.cross(opposite);
        }
    }
    for (const Border& border : borders_) {
        dJ_dv.row(border.p) += (1 - border.along) * weight[border.triangle] * border.outward;
        dJ_dv.row(border.q) += border.along * weight[border.triangle] * border.outward;
    }
}

/// Turning the stream by du is moving each vertex x by -(u . x) du.
double VisibleAreas::derivative_along(const Eigen::VectorXd& weight, const Vector3d& du) const {
    double sum = 0;
    for (int t = 0; t < mesh_.num_triangles(); ++t)
        if (!hidden_[t] && area_[t] != 0) sum -= weight[t] * du.dot(area_vector(mesh_, t));
    for (const Border& border : borders_) {
        const double depth = (1 - border.along) * u_.dot(mesh_.vertices.row(border.p)) +
                             border.along * u_.dot(mesh_.vertices.row(border.q));
        sum -= weight[border.triangle] * depth * du.dot(border.outward);
    }
    return sum;
}

}  // namespace strake
