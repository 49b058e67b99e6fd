#include "core/wrap/wrap_binding.hpp"

#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/point_tree.hpp"
#include "core/parallel.hpp"
#include "core/wrap/cell_sums.hpp"
#include "core/wrap/radial_sums.hpp"
#include "core/wrap/wide_product.hpp"

#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>

namespace strake {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Affine = Eigen::Matrix<double, Eigen::Dynamic, 4>;  ///< 1, x, y, z

constexpr double near_edges = 2, depth_share = 1.5;   ///< radius of the local part: edges plus depths
constexpr double full_until = 2, nothing_beyond = 5;  ///< it fades out between these, in edges from the wrap
constexpr double flat = 1e-9;                         ///< smallest extent of a wrap over its largest
constexpr int block = 64;
constexpr Index rows_a_time = 65536;
constexpr int centers_at_once = 16;
constexpr Index many_points = 100000;  ///< whose boxes are worth it
constexpr double max_stored = 128e3;   ///< bytes of a centre: radial functions of a larger body are evaluated each time
/// A motion of second degree, the simplest that is not affine, by 5 % of the diagonal at its ends; what may be off.
constexpr double bend = 0.05, well_carried = 2.5e-4;  ///< diagonals
constexpr int centers_a_time = 50;

double cube(double squared) { return squared * std::sqrt(squared); }

/// Wendland's function of dimension 3 and smoothness 2.
double wendland(double r) { return r < 1 ? std::pow(1 - r, 4) * (4 * r + 1) : 0; }

double fade(double depth_in_edges) {
    const double s = std::clamp((nothing_beyond - depth_in_edges) / (nothing_beyond - full_until), 0.0, 1.0);
    return s * s * (3 - 2 * s);
}

Affine affine_rows(const Points& x) {
    Affine rows(x.rows(), 4);
    rows.col(0).setOnes();
    rows.rightCols<3>() = x;
    return rows;
}

/// Each as far as possible from those before it; the first one is the farthest from the mean. Ties: the smaller number.
/// @param image with mirror images: a point is taken together with its own.
/// @param chosen the first ones. @param weight of the squared distances, empty: 1
std::vector<int> farthest_points(const Points& x, int count, const std::vector<int>& image,
                                 std::vector<int> chosen = {}, const VectorXd& weight = {}) {
    const auto distances_from = [&](const Eigen::RowVector3d& point) {
        const VectorXd distances = (x.rowwise() - point).rowwise().squaredNorm();
        return weight.size() > 0 ? VectorXd(distances.cwiseProduct(weight)) : distances;
    };
    VectorXd distance = distances_from(x.colwise().mean());
    for (std::size_t k = 0; k < chosen.size(); ++k) {
        const VectorXd now = distances_from(x.row(chosen[k]));
        distance = k == 0 ? now : VectorXd(distance.cwiseMin(now));
    }
    while (static_cast<int>(chosen.size()) < count) {
        Index best = 0;
        if (!(distance.maxCoeff(&best) > 0)) break;  // only copies of those chosen are left
        const auto take = [&](int v) {
            chosen.push_back(v);
            const VectorXd now = distances_from(x.row(v));
            distance = chosen.size() == 1 ? now : VectorXd(distance.cwiseMin(now));
        };
        take(static_cast<int>(best));
        if (!image.empty() && image[static_cast<std::size_t>(best)] != best)
            take(image[static_cast<std::size_t>(best)]);
    }
    return chosen;
}

double mean_edge(const TriMesh& mesh) {
    const Adjacency adjacent = adjacency(mesh);
    double sum = 0;
    for (const auto& [a, b] : adjacent.edges) sum += (mesh.vertices.row(a) - mesh.vertices.row(b)).norm();
    return sum / adjacent.num_edges();
}

void check(const TriMesh& wrap, const Points& body, const WrapBindingOptions& options) {
    if (wrap.num_triangles() == 0 || !(surface_area(wrap) > 0)) throw InvalidInput("wrap: it has no area");
    if (!wrap.vertices.allFinite() || !body.allFinite()) throw InvalidInput("wrap: a coordinate is not finite");
    if (!options.held.empty() && static_cast<Index>(options.held.size()) != body.rows())
        throw InvalidInput(text("wrap: ", options.held.size(), " flags for ", body.rows(), " vertices of the body"));
    if (!options.image.empty() && static_cast<Index>(options.image.size()) != wrap.vertices.rows())
        throw InvalidInput(
            text("wrap: ", options.image.size(), " mirror images of ", wrap.vertices.rows(), " vertices"));
    if (options.centers < 4) throw InvalidInput(text("wrap: centers = ", options.centers, " must be >= 4"));
}

using Row = std::vector<std::pair<int, double>>;

/// Adds rows from `first` on.
void append(const std::vector<Row>& rows, Index first, Index count, Eigen::SparseMatrix<double, Eigen::RowMajor>& out) {
    for (Index i = 0; i < count; ++i) {
        out.startVec(first + i);
        for (const auto& [w, weight] : rows[static_cast<std::size_t>(i)]) out.insertBack(first + i, w) = weight;
    }
}

/// Numbers of a matrix, by those of its first rows.
Index expected_entries(const std::vector<Row>& first, Index count, Index rows) {
    std::size_t entries = 0;
    for (Index i = 0; i < count; ++i) entries += first[static_cast<std::size_t>(i)].size();
    return static_cast<Index>(1.1 * static_cast<double>(entries) * static_cast<double>(rows) /
                              static_cast<double>(count));
}

}  // namespace

struct WrapBinding::Impl {
    Eigen::RowVector3d middle;
    double scale = 1;     ///< lengths are divided by it: the diagonal
    Points wrap, center;  ///< scaled
    Index num_body = 0;   ///< vertices of the body
    Affine wrap_affine, body_affine;
    Eigen::Matrix<double, 4, Eigen::Dynamic> fit;  ///< u -> coefficients of the nearest affine map
    std::vector<int> centers;
    Eigen::PartialPivLU<MatrixXd> system;
    Eigen::SparseMatrix<double, Eigen::RowMajor> local;  ///< N x n
    /// What the radial functions and the local part make of the weights of the centres: K_body - local K_wrap, N x
    /// centres; empty of a large body.
    MatrixXd by_weights;
    std::vector<char> held;
    double edge = 0, depth = 0;  ///< unscaled
    RadialSums sums = RadialSums::by_boxes;
    CellSums of_body, of_wrap;  ///< where radial functions are not kept

    void choose_centers(int count, const WrapBindingOptions& options, const Points& body, const VectorXd& weight = {});
    VectorXd off_second_degree(const Points& body) const;
    void add_centers(const TriMesh& surface, const WrapBindingOptions& options, const Points& body);
    void factorize();
    void spread(const TriMesh& surface, const Points& body);
    void store(Points body);
    MatrixXd kernel(const Points& at, int begin, int end) const;
    CellSums places(Points at) const {
        const bool by_boxes = sums == RadialSums::by_boxes && at.rows() >= many_points;
        return {std::move(at), center, by_boxes};
    }
    Points radial(const CellSums& at, const MatrixXd& weights) const;
    MatrixXd radial_transpose(const CellSums& at, const MatrixXd& values) const;
    MatrixXd local_transpose(const MatrixXd& of_body) const;
    MatrixXd transposed(const MatrixXd& of_body) const;
    MatrixXd through_centers(const MatrixXd& by_affine, MatrixXd by_wrap, const MatrixXd& by_centers) const;
    template <class Rows>
    void hold(Rows& rows) const;

    /// What of displacements of the wrap is affine, and what the radial functions make of the rest.
    struct Smooth {
        Eigen::Matrix<double, 4, 3> nearest, linear;
        MatrixXd weights;  ///< of the centres
        Points rest;       ///< that the affine part leaves of the displacements
    };
    Smooth smooth(const Points& of_wrap_vertices) const;
    Points carried(const Points& of_wrap_vertices) const;  ///< B u
};

void WrapBinding::Impl::choose_centers(int count, const WrapBindingOptions& options, const Points& body,
                                       const VectorXd& weight) {
    centers = farthest_points(wrap, count, options.image, std::move(centers), weight);
    center = wrap(centers, Eigen::all);
    factorize();
    store(body);
}

/// How far each vertex is from where motions of second degree move it, in diagonals: at worst, of a coordinate that
/// moves by x^T Q x about the middle, |Q| = 1 in the Frobenius norm, which turns with the body.
VectorXd WrapBinding::Impl::off_second_degree(const Points& body) const {
    const auto motions = [](const Points& x) {
        Points squares = 4 * bend * x.array().square(), products(x.rows(), 3);
        for (int k = 0; k < 3; ++k) products.col(k) = 4 * bend * x.col(k).cwiseProduct(x.col((k + 1) % 3));
        return std::array<Points, 2>{squares, products};
    };
    const std::array<Points, 2> of_wrap = motions(wrap);
    std::array<Points, 2> wanted = motions(body);
    for (Points& rows : wanted) hold(rows);
    return ((carried(of_wrap[0]) - wanted[0]).rowwise().squaredNorm() +
            2 * (carried(of_wrap[1]) - wanted[1]).rowwise().squaredNorm())
        .cwiseSqrt();
}

/// Some at a time, where the wrap is next to what is carried worst.
void WrapBinding::Impl::add_centers(const TriMesh& surface, const WrapBindingOptions& options, const Points& body) {
    std::vector<int> nearest;  // triangle of the wrap, per vertex of the body
    for (int count = options.centers; count < options.max_centers;) {
        const VectorXd off = off_second_degree(body);
        if (!(off.maxCoeff() > well_carried)) return;
        if (nearest.empty()) {
            const ClosestPointTree closest(surface);
            nearest.resize(static_cast<std::size_t>(body.rows()));
            for_blocks(static_cast<int>(body.rows()), block, [&](int begin, int end) {
                for (int v = begin; v < end; ++v)
                    nearest[static_cast<std::size_t>(v)] =
                        closest.find((scale * body.row(v) + middle).transpose()).triangle;
            });
        }
        VectorXd weight = VectorXd::Zero(wrap.rows());
        for (Index v = 0; v < body.rows(); ++v)
            for (const int corner : surface.triangles.row(nearest[static_cast<std::size_t>(v)]))
                weight[corner] = std::max(weight[corner], off[v] * off[v]);
        const std::size_t before = centers.size();
        count = std::min(count + centers_a_time, options.max_centers);
        choose_centers(count, options, body, weight);
        if (centers.size() == before) return;
    }
}

/// [K P; P^T 0] for the weights of the radial functions and a linear part.
void WrapBinding::Impl::factorize() {
    const Index k = center.rows();
    MatrixXd matrix = MatrixXd::Zero(k + 4, k + 4);
    for (Index i = 0; i < k; ++i)
        for (Index j = 0; j < i; ++j) matrix(i, j) = matrix(j, i) = cube((center.row(i) - center.row(j)).squaredNorm());
    matrix.topRightCorner(k, 4) = affine_rows(center);
    matrix.bottomLeftCorner(4, k) = affine_rows(center).transpose();
    system.compute(matrix);
}

/// The local part: for each vertex of the body a weighted mean over vertices of the wrap.
void WrapBinding::Impl::spread(const TriMesh& surface, const Points& body) {
    const VectorXd area = vertex_areas(surface);
    const ClosestPointTree closest(surface);
    const PointTree tree(surface.vertices);
    const auto set_row = [&](Index v, std::vector<int>& found, Row& row) {
        row.clear();
        const Eigen::Vector3d x = (scale * body.row(v) + middle).transpose();
        const double away = closest.find(x).distance;
        const double share = fade(away / edge), radius = near_edges * edge + depth_share * away;
        if (share == 0) return away;
        tree.within(x, radius, found);
        double sum = 0;
        for (const int w : found) {
            const double weight = area[w] * wendland((surface.vertices.row(w).transpose() - x).norm() / radius);
            if (weight > 0) row.emplace_back(w, weight), sum += weight;
        }
        for (auto& [w, weight] : row) weight *= share / sum;
        return away;
    };
    const Index rows = body.rows();
    std::vector<double> depths(static_cast<std::size_t>(rows));
    local.resize(rows, wrap.rows());
    // Some rows at a time: all of them in vectors of their own would be twice the matrix once more.
    std::vector<Row> weights(static_cast<std::size_t>(std::min(rows, rows_a_time)));
    for (Index from = 0; from < rows; from += rows_a_time) {
        const Index count = std::min(rows_a_time, rows - from);
        for_blocks(static_cast<int>(count), block, [&](int begin, int end) {
            std::vector<int> found;
            for (int i = begin; i < end; ++i)
                depths[static_cast<std::size_t>(from + i)] =
                    set_row(from + i, found, weights[static_cast<std::size_t>(i)]);
        });
        if (from == 0) local.reserve(expected_entries(weights, count, rows));
        append(weights, from, count, local);
    }
    local.finalize();
    depth = depths.empty() ? 0 : *std::max_element(depths.begin(), depths.end());
}

/// |x - x_c|^3 of points begin..end, a row each.
MatrixXd WrapBinding::Impl::kernel(const Points& at, int begin, int end) const {
    MatrixXd rows(end - begin, center.rows());
    for (Index c = 0; c < center.rows(); ++c) {
        const Eigen::ArrayXd r2 = (at.middleRows(begin, end - begin).rowwise() - center.row(c)).rowwise().squaredNorm();
        rows.col(c) = r2 * r2.sqrt();
    }
    return rows;
}

void WrapBinding::Impl::store(Points body) {
    const double least = std::min(1.0, static_cast<double>(center.rows()) / WrapBindingOptions().centers);
    const auto is_large = [&](Index rows) { return 8.0 * static_cast<double>(rows) * least > max_stored; };
    if (is_large(body.rows()) || is_large(wrap.rows())) {
        of_body = places(std::move(body));
        of_wrap = places(wrap);
        by_weights.resize(0, 0);
        return;
    }
    MatrixXd by_wrap(wrap.rows(), center.rows());
    for_blocks(static_cast<int>(wrap.rows()), block,
               [&](int begin, int end) { by_wrap.middleRows(begin, end - begin) = kernel(wrap, begin, end); });
    by_weights.resize(body.rows(), center.rows());
    for_blocks(static_cast<int>(body.rows()), block, [&](int begin, int end) {
        by_weights.middleRows(begin, end - begin) =
            kernel(body, begin, end) - local.middleRows(begin, end - begin) * by_wrap;
    });
}

/// sum_c weights_c |x - x_c|^3 at each point.
Points WrapBinding::Impl::radial(const CellSums& places, const MatrixXd& weights) const {
    if (sums != RadialSums::by_products) return places.values(weights);
    const Points& at = places.points();
    Points values(at.rows(), 3);
    for_blocks(static_cast<int>(at.rows()), block,
               [&](int begin, int end) { values.middleRows(begin, end - begin) = kernel(at, begin, end) * weights; });
    return values;
}

/// Its transpose: per centre the sum over the points.
MatrixXd WrapBinding::Impl::radial_transpose(const CellSums& places, const MatrixXd& values) const {
    if (sums != RadialSums::by_products) return places.transpose(values);
    const Points& at = places.points();
    MatrixXd products(center.rows(), values.cols());
    for_blocks(static_cast<int>(center.rows()), centers_at_once, [&](int begin, int end) {
        Eigen::ArrayXd r2(at.rows());
        for (int c = begin; c < end; ++c) {
            r2 = (at.rowwise() - center.row(c)).rowwise().squaredNorm();
            r2 *= r2.sqrt();
            products.row(c) = r2.matrix().transpose() * values;
        }
    });
    return products;
}

template <class Rows>
void WrapBinding::Impl::hold(Rows& rows) const {
    for (std::size_t v = 0; v < held.size(); ++v)
        if (held[v]) rows.row(static_cast<Index>(v)).setZero();
}

WrapBinding::WrapBinding(const TriMesh& wrap, const Points& body, const WrapBindingOptions& options)
    : impl_(std::make_unique<Impl>()) {
    check(wrap, body, options);
    Impl& m = *impl_;
    const Box box = bounding_box(wrap);
    m.middle = 0.5 * (box.min + box.max).transpose();
    m.scale = (box.max - box.min).norm();
    m.wrap = (wrap.vertices.rowwise() - m.middle) / m.scale;
    Points scaled = (body.rowwise() - m.middle) / m.scale;
    m.num_body = scaled.rows();
    m.wrap_affine = affine_rows(m.wrap);
    m.body_affine = affine_rows(scaled);
    m.held = options.held;
    m.sums = options.sums;
    m.edge = mean_edge(wrap);
    const VectorXd share = vertex_areas(wrap) / surface_area(wrap);
    const Eigen::Matrix4d moments = m.wrap_affine.transpose() * share.asDiagonal() * m.wrap_affine;
    const Eigen::FullPivLU<Eigen::Matrix4d> inverse(moments);
    if (!(std::abs(inverse.matrixLU()(3, 3)) > flat * flat)) throw InvalidInput("wrap: it lies in a plane");
    m.fit = inverse.solve(Eigen::Matrix<double, 4, Eigen::Dynamic>(m.wrap_affine.transpose() * share.asDiagonal()));
    m.spread(wrap, scaled);
    m.choose_centers(options.centers, options, scaled);
    m.add_centers(wrap, options, scaled);
}

WrapBinding::~WrapBinding() = default;
WrapBinding::WrapBinding(WrapBinding&&) noexcept = default;
WrapBinding& WrapBinding::operator=(WrapBinding&&) noexcept = default;

WrapBinding::Impl::Smooth WrapBinding::Impl::smooth(const Points& of_wrap) const {
    if (of_wrap.rows() != wrap.rows())
        throw InvalidInput(text("wrap: ", of_wrap.rows(), " displacements for ", wrap.rows(), " vertices"));
    const Index k = center.rows();
    Smooth parts;
    parts.nearest = fit * of_wrap;
    parts.rest = of_wrap - wrap_affine * parts.nearest;
    MatrixXd right = MatrixXd::Zero(k + 4, 3);
    right.topRows(k) = parts.rest(centers, Eigen::all);
    const MatrixXd solved = system.solve(right);
    parts.weights = solved.topRows(k);
    parts.linear = solved.bottomRows(4);
    return parts;
}

Points WrapBinding::Impl::carried(const Points& of_wrap_vertices) const {
    const Smooth parts = smooth(of_wrap_vertices);
    Points left = parts.rest - wrap_affine * parts.linear, moved;
    if (by_weights.size() > 0) {
        moved.resize(num_body, 3);
        for_blocks(static_cast<int>(num_body), block, [&](int begin, int end) {
            moved.middleRows(begin, end - begin).noalias() = by_weights.middleRows(begin, end - begin) * parts.weights;
        });
    } else {
        moved = radial(of_body, parts.weights);
        left -= radial(of_wrap, parts.weights);
    }
    moved += body_affine * (parts.nearest + parts.linear) + local * left;
    hold(moved);
    return moved;
}

Points WrapBinding::displacement(const Points& of_wrap) const { return impl_->carried(of_wrap); }

std::shared_ptr<const CellSums> WrapBinding::places(const Points& at) const {
    return std::make_shared<const CellSums>(impl_->places((at.rowwise() - impl_->middle) / impl_->scale));
}

std::vector<Eigen::Matrix3d> WrapBinding::local_maps(const Points& of_wrap, const Points& at) const {
    return local_maps(of_wrap, *places(at));
}

std::vector<Eigen::Matrix3d> WrapBinding::local_maps(const Points& of_wrap, const CellSums& at) const {
    std::vector<Eigen::Matrix3d> maps(static_cast<std::size_t>(at.points().rows()));
    each_local_map(of_wrap, at, [&](Index p, const Eigen::Matrix3d& map) { maps[static_cast<std::size_t>(p)] = map; });
    return maps;
}

void WrapBinding::each_local_map(const Points& of_wrap, const CellSums& at,
                                 const std::function<void(Index, const Eigen::Matrix3d&)>& consume) const {
    const Impl& m = *impl_;
    const Impl::Smooth parts = m.smooth(of_wrap);
    const Eigen::Matrix3d affine = (parts.nearest + parts.linear).bottomRows<3>().transpose();
    const auto take = [&](Index p, const Eigen::Matrix3d& radial) {
        consume(p, Eigen::Matrix3d::Identity() + (affine + radial) / m.scale);
    };
    if (m.sums != RadialSums::by_products) return at.each_slope(parts.weights, take);
    const Points& x = at.points();
    for_blocks(static_cast<int>(x.rows()), block, [&](int begin, int end) {
        for (int p = begin; p < end; ++p) {
            Points away = (-m.center).rowwise() + x.row(p);
            const VectorXd slope = 3 * away.rowwise().norm();  // of r^3: 3 r times the vector
            const Eigen::Matrix3d radial =
                parts.weights.transpose() * (away.array().colwise() * slope.array()).matrix();
            take(p, radial);
        }
    });
}

/// Adds local^T g to a matrix of as many columns: what they add to a vertex of the wrap stands together.
template <int columns>
void add_local_transpose(const Eigen::SparseMatrix<double, Eigen::RowMajor>& local, const MatrixXd& g, Index first,
                         MatrixXd& sums) {
    Eigen::Matrix<double, Eigen::Dynamic, columns, Eigen::RowMajor> of_wrap =
        Eigen::Matrix<double, Eigen::Dynamic, columns, Eigen::RowMajor>::Zero(local.cols(), columns);
    for (Index v = 0; v < local.outerSize(); ++v) {
        const Eigen::Matrix<double, 1, columns> now = g.block<1, columns>(v, first);
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator at(local, v); at; ++at)
            of_wrap.row(at.col()) += at.value() * now;
    }
    sums.middleCols<columns>(first) = of_wrap;
}

/// Of several functionals: two at a time.
MatrixXd WrapBinding::Impl::local_transpose(const MatrixXd& g) const {
    MatrixXd sums(wrap.rows(), g.cols());
    Index first = 0;
    for (; first + 6 <= g.cols(); first += 6) add_local_transpose<6>(local, g, first, sums);
    if (first < g.cols()) add_local_transpose<3>(local, g, first, sums);
    return sums;
}

/// B^T of several functionals side by side, N x 3m.
MatrixXd WrapBinding::Impl::transposed(const MatrixXd& g) const {
    const Index k = center.rows();
    const MatrixXd by_affine = body_affine.transpose() * g;
    MatrixXd by_wrap = local_transpose(g);
    MatrixXd by_centers(k, g.cols());
    if (by_weights.size() > 0)
        by_centers = wide_product(by_weights, g);
    else
        by_centers = radial_transpose(of_body, g) - radial_transpose(of_wrap, by_wrap);
    return through_centers(by_affine, std::move(by_wrap), by_centers);
}

/// @param by_wrap by what the radial part leaves; then, here, by what the affine part leaves
MatrixXd WrapBinding::Impl::through_centers(const MatrixXd& by_affine, MatrixXd by_wrap,
                                            const MatrixXd& by_centers) const {
    const Index k = center.rows();
    MatrixXd right(k + 4, by_wrap.cols());
    right.topRows(k) = by_centers;
    right.bottomRows(4) = by_affine - wrap_affine.transpose() * by_wrap;
    const MatrixXd solved = system.transpose().solve(right);
    for (Index c = 0; c < k; ++c) by_wrap.row(centers[static_cast<std::size_t>(c)]) += solved.row(c);
    const MatrixXd by_fit = by_affine - wrap_affine.transpose() * by_wrap;
    return by_wrap + fit.transpose() * by_fit;
}

std::vector<Points> WrapBinding::transpose(const std::vector<Points>& of_body) const {
    const Impl& m = *impl_;
    MatrixXd all(m.num_body, 3 * static_cast<Index>(of_body.size()));
    for (std::size_t i = 0; i < of_body.size(); ++i) {
        if (of_body[i].rows() != m.num_body)
            throw InvalidInput(
                text("wrap: ", of_body[i].rows(), " derivatives for ", m.num_body, " vertices of the body"));
        all.middleCols<3>(3 * static_cast<Index>(i)) = of_body[i];
    }
    m.hold(all);
    const MatrixXd by_wrap = m.transposed(all);
    std::vector<Points> of_wrap;
    for (std::size_t i = 0; i < of_body.size(); ++i)
        of_wrap.emplace_back(by_wrap.middleCols<3>(3 * static_cast<Index>(i)));
    return of_wrap;
}

std::vector<Points> WrapBinding::transpose_at(const std::vector<int>& vertex, const Points& of_body) const {
    const Impl& m = *impl_;
    if (static_cast<Index>(vertex.size()) != of_body.rows())
        throw InvalidInput(text("wrap: ", of_body.rows(), " derivatives for ", vertex.size(), " vertices"));
    for (const int v : vertex)
        if (v < 0 || v >= m.num_body) throw InvalidInput(text("wrap: vertex ", v, " is not in [0, ", m.num_body, ")"));
    if (m.by_weights.size() > 0 || m.sums == RadialSums::by_products) {  // small bodies, and earlier runs
        std::vector<Points> whole(vertex.size(), Points::Zero(m.num_body, 3));
        for (std::size_t i = 0; i < vertex.size(); ++i) whole[i].row(vertex[i]) = of_body.row(static_cast<Index>(i));
        return transpose(whole);
    }
    const Index columns = 3 * of_body.rows();
    Points g = of_body;
    MatrixXd by_affine(4, columns), by_wrap = MatrixXd::Zero(m.wrap.rows(), columns);
    for (Index i = 0; i < g.rows(); ++i) {
        const int v = vertex[static_cast<std::size_t>(i)];
        if (!m.held.empty() && m.held[static_cast<std::size_t>(v)]) g.row(i).setZero();
        for (Index c = 0; c < 3; ++c) by_affine.col(3 * i + c) = m.body_affine.row(v).transpose() * g(i, c);
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator at(m.local, v); at; ++at)
            by_wrap.block<1, 3>(at.col(), 3 * i) += at.value() * g.row(i);
    }
    const MatrixXd by_centers = m.of_body.transpose_at(vertex, g) - m.radial_transpose(m.of_wrap, by_wrap);
    const MatrixXd all = m.through_centers(by_affine, by_wrap, by_centers);
    std::vector<Points> of_wrap;
    for (Index i = 0; i < g.rows(); ++i) of_wrap.emplace_back(all.middleCols<3>(3 * i));
    return of_wrap;
}

Points WrapBinding::transpose(const Points& of_body) const { return transpose(std::vector<Points>{of_body})[0]; }

const std::vector<int>& WrapBinding::centers() const { return impl_->centers; }
double WrapBinding::edge_length() const { return impl_->edge; }
double WrapBinding::largest_depth() const { return impl_->depth; }

}  // namespace strake
