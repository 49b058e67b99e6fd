#include "core/wrap/cell_sums.hpp"

#include "core/parallel.hpp"
#include "core/wrap/cell_polynomials.hpp"
#include "core/wrap/radial_sums.hpp"

#include <numeric>

namespace strake {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double tolerance = 3e-11;    ///< of |x - x_c|^3
constexpr double thinnest = 0.1;       ///< extents over the largest: slopes have all directions
constexpr int few_terms = 60000;       ///< points times near centres of a box that is not halved
constexpr int few_points = 1200;       ///< of a box that is not halved
constexpr double points_a_node = 1.5;  ///< fewer points are summed one by one
constexpr double worth_it = 0.8;       ///< of the terms one by one: boxes that cost more are forgotten
constexpr int min_degree = 3;

bool is_split(int points, std::size_t near) {
    return points >= few_points && static_cast<double>(near) * points >= few_terms;
}

/// The least degree along an axis: by Bernstein's ellipse through the singularity of |x - c|^3 on that line of the box
/// where it is nearest, and the power 5/2 of the degree with which the coefficients fall besides.
int needed_degree(int axis, const Vector3d& middle, const Vector3d& half, const Vector3d& center) {
    double beside = 0;
    for (int k = 0; k < 3; ++k)
        if (k != axis) beside += std::pow(std::max(0.0, std::abs(center[k] - middle[k]) - half[k]), 2);
    const double h = half[axis], a = std::abs(center[axis] - middle[axis]) / h, b2 = beside / (h * h);
    const double sum = 0.5 * (std::sqrt((a - 1) * (a - 1) + b2) + std::sqrt((a + 1) * (a + 1) + b2));
    const double radius = sum + std::sqrt(std::max(0.0, sum * sum - 1));
    double size = std::pow(h * radius, 3) / tolerance;
    for (int n = 1; n <= max_degree; ++n)
        if ((size /= radius) < n * n * std::sqrt(static_cast<double>(n))) return n;
    return max_degree + 1;
}

Vector3d row(const Points& x, Index i) { return x.row(i).transpose(); }

std::array<MatrixXd, 3> coefficients_of(const Degree& n) {
    return {chebyshev_coefficients(n[0]), chebyshev_coefficients(n[1]), chebyshev_coefficients(n[2])};
}

std::array<MatrixXd, 3> transposed(std::array<MatrixXd, 3> all) {
    for (MatrixXd& one : all) one.transposeInPlace();
    return all;
}

std::vector<Term> some_terms(const std::vector<Term>& all, const std::vector<int>& which) {
    std::vector<Term> some;
    some.reserve(which.size());
    for (const int c : which) some.push_back(all[static_cast<std::size_t>(c)]);
    return some;
}

/// Values of a few points, on this thread.
CellTensor values_here(const Points& at, const std::vector<Term>& all) {
    CellTensor values(at.rows(), 3);
    Tile now;
    for (Index from = 0; from < at.rows(); from += tile) {
        const Index count = std::min<Index>(tile, at.rows() - from);
        now.load(at, from, count);
        run_lanes([&]() __attribute__((always_inline)) {
            for (Index p = 0; p < count; p += 4) {
                Four sums[3];
                add_values(now, p, all, sums);
                for (Index i = 0; i < std::min<Index>(4, count - p); ++i)
                    for (int k = 0; k < 3; ++k) values(from + p + i, k) = sums[k][i];
            }
        });
    }
    return values;
}

/// Per centre the sum over a few points, on this thread.
MatrixXd transpose_here(const Points& at, const Points& center, const MatrixXd& values) {
    MatrixXd sums = MatrixXd::Zero((center.rows() + tall - 1) / tall * tall, values.cols());
    run_lanes([&]() __attribute__((always_inline)) { add_transpose(at, 0, at.rows(), center, values, sums); });
    return sums.topRows(center.rows());
}

/// What the points of one of the smallest boxes need.
struct LeafTerms {
    Degree degree;
    Vector3d middle, half;
    UsedProducts used;
    std::vector<double> coefficients;  ///< none: no polynomial
    std::vector<Term> near;
};

/// Values at the points of a tile, those of an axis together.
void tile_values(const Tile& at, Index count, const LeafTerms& leaf, double (&values)[3][tile]) {
    ChebyshevTile chebyshev;
    run_lanes([&]() __attribute__((always_inline)) {
        if (!leaf.coefficients.empty()) chebyshev.set<false>(at, leaf.degree, leaf.middle, leaf.half);
        for (int p = 0; p < count; p += 8) {
            Four sums[3][2] = {}, of_near[2][3];
            if (!leaf.coefficients.empty())
                add_polynomial(chebyshev, p, leaf.degree, leaf.used, leaf.coefficients.data(), sums);
            add_values(at, p, leaf.near, of_near[0]);
            add_values(at, p + 4, leaf.near, of_near[1]);
            for (int k = 0; k < 3; ++k) {
                four(values[k] + p).lanes = sums[k][0] + of_near[0][k];
                four(values[k] + p + 4).lanes = sums[k][1] + of_near[1][k];
            }
        }
    });
}

/// Derivatives there, of value i by axis j at 3 i + j.
void tile_slopes(const Tile& at, Index count, const LeafTerms& leaf, double (&slopes)[9][tile]) {
    ChebyshevTile chebyshev;
    run_lanes([&]() __attribute__((always_inline)) {
        if (!leaf.coefficients.empty()) chebyshev.set<true>(at, leaf.degree, leaf.middle, leaf.half);
        for (int p = 0; p < count; p += 4) {
            Four sums[3][3] = {}, of_near[3][3];
            if (!leaf.coefficients.empty())
                add_polynomial_slopes(chebyshev, p, leaf.degree, leaf.used, leaf.coefficients.data(), sums);
            add_slopes(at, p, leaf.near, of_near);
            for (int k = 0; k < 9; ++k) four(slopes[k] + p).lanes = sums[k / 3][k % 3] + of_near[k / 3][k % 3];
        }
    });
}

}  // namespace

CellSums::CellSums(Points at, const Points& center, bool cells) : at_(std::move(at)), center_(center) {
    if (!cells || at_.rows() == 0) return;
    order_.resize(static_cast<std::size_t>(at_.rows()));
    std::iota(order_.begin(), order_.end(), 0);
    divide();
    if (cost() > worth_it * num_terms()) {
        order_.clear(), cells_.clear(), level_.clear(), leaves_.clear();
        return;
    }
    at_ = Points(at_(order_, Eigen::all));
}

/// Centres for whose polynomial no degree above `most` is needed are far; its degree is what the nearest of all that
/// are in it ask for.
void CellSums::classify(Cell& cell, const std::vector<int>& candidates, const std::vector<Degree>& needed,
                        int most) const {
    const auto take = [&](int c) {
        for (int k = 0; k < 3; ++k)
            cell.degree[k] = std::max(cell.degree[k], std::min(max_degree, needed[static_cast<std::size_t>(c)][k]));
    };
    std::vector<char> is_candidate(needed.size(), 0);
    cell.degree = {1, 1, 1};
    cell.far.clear(), cell.near.clear();
    for (const int c : candidates) {
        is_candidate[static_cast<std::size_t>(c)] = 1;
        const bool is_far = std::ranges::max(needed[static_cast<std::size_t>(c)]) <= most;
        (is_far ? cell.far : cell.near).push_back(c);
        if (is_far) take(c);
    }
    const bool inherits = cell.parent >= 0 && cells_[static_cast<std::size_t>(cell.parent)].has_polynomial();
    for (int c = 0; inherits && c < static_cast<int>(needed.size()); ++c)
        if (!is_candidate[static_cast<std::size_t>(c)]) take(c);
    const bool is_worth_it = !cell.far.empty() && points_a_node * num_products(cell.degree) <= cell.count;
    if (inherits || is_worth_it) return;
    cell.degree.fill(-1);
    cell.near = candidates, cell.far.clear();
}

/// One of the smallest boxes has the polynomial, and the centres near it, that cost least.
void CellSums::choose(Cell& cell, const std::vector<int>& candidates) const {
    std::vector<Degree> needed(static_cast<std::size_t>(center_.rows()));
    for (Index c = 0; c < center_.rows(); ++c)
        for (int k = 0; k < 3; ++k)
            needed[static_cast<std::size_t>(c)][k] = needed_degree(k, cell.middle, cell.half, row(center_, c));
    classify(cell, candidates, needed, max_degree);
    if (!cell.has_polynomial() || is_split(cell.count, cell.near.size())) return;
    double least = cost_of(cell);
    for (int most = max_degree - 1; most >= min_degree; --most) {
        Cell now = cell;
        classify(now, candidates, needed, most);
        if (const double cost = cost_of(now); cost < least) cell = std::move(now), least = cost;
    }
}

/// Terms of centres: a coefficient is half of one.
double CellSums::cost_of(const Cell& cell) const {
    double cost = cell.has_polynomial() ? static_cast<double>(cell.far.size()) * num_products(cell.degree) : 0;
    if (cell.child >= 0) return cost;
    cost += static_cast<double>(cell.count) * static_cast<double>(cell.near.size());
    if (cell.has_polynomial()) cost += 0.5 * cell.count * UsedProducts(cell.degree).number;
    return cost;
}

void CellSums::divide() {
    std::vector<int> all(static_cast<std::size_t>(center_.rows()));
    std::iota(all.begin(), all.end(), 0);
    const auto add = [&](int first, int count, int parent) {
        Cell cell;
        cell.first = first, cell.count = count, cell.parent = parent;
        Vector3d low = row(at_, order_[static_cast<std::size_t>(first)]), high = low;
        for (int i = first; i < first + count; ++i) {
            low = low.cwiseMin(row(at_, order_[static_cast<std::size_t>(i)]));
            high = high.cwiseMax(row(at_, order_[static_cast<std::size_t>(i)]));
        }
        cell.middle = 0.5 * (low + high);
        cell.half = 0.5 * (high - low);
        const double least = std::max(thinnest * cell.half.maxCoeff(), 1e-9);
        cell.half = cell.half.cwiseMax(least);
        choose(cell, parent < 0 ? all : cells_[static_cast<std::size_t>(parent)].near);
        cells_.push_back(std::move(cell));
    };
    add(0, static_cast<int>(at_.rows()), -1);
    level_ = {0, 1};
    while (level_.back() > level_[level_.size() - 2]) {
        for (int c = level_[level_.size() - 2]; c < level_.back(); ++c) {
            const Cell cell = cells_[static_cast<std::size_t>(c)];
            if (!is_split(cell.count, cell.near.size())) {
                leaves_.push_back(c);
                continue;
            }
            Index axis = 0;
            cell.half.maxCoeff(&axis);
            const auto begin = order_.begin() + cell.first;
            std::nth_element(begin, begin + cell.count / 2, begin + cell.count, [&](int a, int b) {
                return at_(a, axis) < at_(b, axis) || (at_(a, axis) == at_(b, axis) && a < b);
            });
            cells_[static_cast<std::size_t>(c)].child = static_cast<int>(cells_.size());
            add(cell.first, cell.count / 2, c);
            add(cell.first + cell.count / 2, cell.count - cell.count / 2, c);
        }
        level_.push_back(static_cast<int>(cells_.size()));
    }
    for (const int leaf : leaves_) {  // the same points, whatever the library's way of halving
        const Cell& cell = cells_[static_cast<std::size_t>(leaf)];
        std::sort(order_.begin() + cell.first, order_.begin() + cell.first + cell.count);
    }
}

Points CellSums::nodes(const Cell& cell) const {
    std::array<Eigen::VectorXd, 3> x;
    for (int k = 0; k < 3; ++k) x[k] = (cell.half[k] * chebyshev_points(cell.degree[k])).array() + cell.middle[k];
    Points all(num_products(cell.degree), 3);
    Index n = 0;
    for (const double a : x[0])
        for (const double b : x[1])
            for (const double c : x[2]) all.row(n++) << a, b, c;
    return all;
}

/// The parent's polynomial as one of the cell; transposed: what it adds to the parent's moments.
CellSums::Tensor CellSums::from_parent(const Cell& cell, const Tensor& t, bool is_transposed) const {
    const Cell& parent = cells_[static_cast<std::size_t>(cell.parent)];
    std::array<MatrixXd, 3> maps;
    for (int k = 0; k < 3; ++k) {
        const Eigen::VectorXd x = chebyshev_points(cell.degree[k]),
                              there =
                                  ((cell.half[k] * x).array() + (cell.middle[k] - parent.middle[k])) / parent.half[k];
        maps[k] = chebyshev_coefficients(cell.degree[k]) * chebyshev_values(parent.degree[k], there);
    }
    return along_axes(is_transposed ? transposed(maps) : maps, t);
}

std::vector<CellSums::Tensor> CellSums::polynomials(const RadialWeights& weights) const {
    const std::vector<Term> all = terms(center_, weights);
    std::vector<Tensor> polynomial(cells_.size());
    for (std::size_t level = 0; level + 1 < level_.size(); ++level)
        for_blocks(level_[level + 1] - level_[level], 1, [&](int begin, int end) {
            for (int i = level_[level] + begin; i < level_[level] + end; ++i) {
                const Cell& cell = cells_[static_cast<std::size_t>(i)];
                if (!cell.has_polynomial()) continue;
                Tensor& mine = polynomial[static_cast<std::size_t>(i)];
                mine = Tensor::Zero(num_products(cell.degree), 3);
                if (!cell.far.empty())
                    mine =
                        along_axes(coefficients_of(cell.degree), values_here(nodes(cell), some_terms(all, cell.far)));
                if (cell.parent >= 0 && cells_[static_cast<std::size_t>(cell.parent)].has_polynomial())
                    mine += from_parent(cell, polynomial[static_cast<std::size_t>(cell.parent)], false);
                keep_used(cell.degree, mine);
            }
        });
    return polynomial;
}

/// Calls work(first, count, tile of points, terms) for all points of the smallest boxes.
template <class Work>
void CellSums::over_tiles(const RadialWeights& weights, const Work& work) const {
    const std::vector<Term> all = terms(center_, weights);
    const std::vector<Tensor> polynomial = polynomials(weights);
    for_blocks(static_cast<int>(leaves_.size()), 1, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            const auto number = static_cast<std::size_t>(leaves_[static_cast<std::size_t>(i)]);
            const Cell& cell = cells_[number];
            LeafTerms leaf{
                cell.degree, cell.middle, cell.half, UsedProducts(cell.degree), {}, some_terms(all, cell.near)};
            if (cell.has_polynomial()) leaf.coefficients = packed(cell.degree, leaf.used, polynomial[number]);
            Tile now;
            for (Index from = cell.first; from < cell.first + cell.count; from += tile) {
                const Index count = std::min<Index>(tile, cell.first + cell.count - from);
                now.load(at_, from, count);
                work(from, count, now, leaf);
            }
        }
    });
}

Points CellSums::values(const RadialWeights& weights) const {
    if (order_.empty()) return cubic_sums(at_, center_, weights);
    Points values(at_.rows(), 3);
    over_tiles(weights, [&](Index from, Index count, const Tile& now, const LeafTerms& leaf) {
        double sums[3][tile];
        tile_values(now, count, leaf, sums);
        for (Index i = 0; i < count; ++i)
            values.row(order_[static_cast<std::size_t>(from + i)]) << sums[0][i], sums[1][i], sums[2][i];
    });
    return values;
}

std::vector<Eigen::Matrix3d> CellSums::slopes(const RadialWeights& weights) const {
    if (order_.empty()) return cubic_slopes(at_, center_, weights);
    std::vector<Eigen::Matrix3d> slopes(static_cast<std::size_t>(at_.rows()));
    each_slope(weights, [&](Index p, const Eigen::Matrix3d& slope) { slopes[static_cast<std::size_t>(p)] = slope; });
    return slopes;
}

void CellSums::each_slope(const RadialWeights& weights,
                          const std::function<void(Index, const Eigen::Matrix3d&)>& consume) const {
    if (order_.empty()) {
        const std::vector<Eigen::Matrix3d> slopes = cubic_slopes(at_, center_, weights);
        for (std::size_t p = 0; p < slopes.size(); ++p) consume(static_cast<Index>(p), slopes[p]);
        return;
    }
    over_tiles(weights, [&](Index from, Index count, const Tile& now, const LeafTerms& leaf) {
        double sums[9][tile];
        tile_slopes(now, count, leaf, sums);
        for (Index i = 0; i < count; ++i) {
            Eigen::Matrix3d one;
            for (int k = 0; k < 9; ++k) one(k / 3, k % 3) = sums[k][i];
            consume(order_[static_cast<std::size_t>(from + i)], one);
        }
    });
}

/// Sums over the points of one of the smallest boxes of the products times the values.
CellSums::Tensor CellSums::moments(const Cell& cell, const MatrixXd& values) const {
    const UsedProducts used(cell.degree);
    MatrixXd sums = MatrixXd::Zero((used.number + tall - 1) / tall * tall, values.cols());
    Tile now;
    ChebyshevTile chebyshev;
    for (Index from = 0; from < cell.count; from += tile) {
        const Index count = std::min<Index>(tile, cell.count - from);
        now.load(at_, cell.first + from, count);
        run_lanes([&]() __attribute__((always_inline)) {
            chebyshev.set<false>(now, cell.degree, cell.middle, cell.half);
            add_polynomial_transpose(chebyshev, static_cast<int>(count), cell.degree, used, values.data() + from,
                                     values.outerStride(), sums);
        });
    }
    Tensor t = Tensor::Zero(num_products(cell.degree), values.cols());
    Index next = 0;
    for (int i = 0; i <= cell.degree[0]; ++i)
        for (int j = 0; j <= cell.degree[1]; ++j)
            for (int k = 0; k < used.counts[i][j]; ++k)
                t.row((static_cast<Index>(i) * (cell.degree[1] + 1) + j) * (cell.degree[2] + 1) + k) = sums.row(next++);
    return t;
}

/// Of one of the smallest boxes: its moments, and what centres near it get.
MatrixXd CellSums::at_leaf(const Cell& cell, const MatrixXd& mine, Tensor& moment) const {
    if (cell.has_polynomial()) moment = moments(cell, mine);
    if (cell.near.empty()) return {};
    return transpose_here(at_.middleRows(cell.first, cell.count), center_(cell.near, Eigen::all), mine);
}

/// A box that has a polynomial: its moments by those of its halves, and what the centres that it adds get.
MatrixXd CellSums::pull_back(const Cell& cell, std::vector<Tensor>& moment, Tensor& mine, Index columns) const {
    if (cell.child >= 0) {
        mine = Tensor::Zero(num_products(cell.degree), columns);
        for (int c = cell.child; c < cell.child + 2; ++c)
            if (const Tensor& of_half = moment[static_cast<std::size_t>(c)]; of_half.size() > 0)
                mine += from_parent(cells_[static_cast<std::size_t>(c)], of_half, true);
        keep_used(cell.degree, mine);
    }
    if (cell.far.empty()) return {};
    return transpose_here(nodes(cell), center_(cell.far, Eigen::all),
                          along_axes(transposed(coefficients_of(cell.degree)), mine));
}

MatrixXd CellSums::transpose(const MatrixXd& values) const {
    if (order_.empty()) return cubic_sums_transpose(at_, center_, values);
    std::vector<MatrixXd> of_near(cells_.size());
    std::vector<Tensor> moment(cells_.size());
    for_blocks(static_cast<int>(leaves_.size()), 1, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            const auto c = static_cast<std::size_t>(leaves_[static_cast<std::size_t>(i)]);
            const Cell& cell = cells_[c];
            MatrixXd mine(cell.count, values.cols());
            for (int p = 0; p < cell.count; ++p)
                mine.row(p) = values.row(order_[static_cast<std::size_t>(cell.first + p)]);
            of_near[c] = at_leaf(cell, mine, moment[c]);
        }
    });
    return pull_back_all(moment, of_near, std::vector<char>(cells_.size(), 1), values.cols());
}

/// From the smallest boxes to the largest. @param is_met boxes that hold anything
MatrixXd CellSums::pull_back_all(std::vector<Tensor>& moment, const std::vector<MatrixXd>& of_near,
                                 const std::vector<char>& is_met, Index columns) const {
    std::vector<MatrixXd> of_far(cells_.size());
    for (std::size_t level = level_.size() - 1; level-- > 0;)
        for_blocks(level_[level + 1] - level_[level], 1, [&](int begin, int end) {
            for (int i = level_[level] + begin; i < level_[level] + end; ++i) {
                const auto c = static_cast<std::size_t>(i);
                if (is_met[c] && cells_[c].has_polynomial())
                    of_far[c] = pull_back(cells_[c], moment, moment[c], columns);
            }
        });
    MatrixXd sums = MatrixXd::Zero(center_.rows(), columns);
    const auto add = [&](const std::vector<int>& centers, const MatrixXd& of_them) {
        for (Index c = 0; c < of_them.rows(); ++c) sums.row(centers[static_cast<std::size_t>(c)]) += of_them.row(c);
    };
    for (std::size_t i = 0; i < cells_.size(); ++i) add(cells_[i].far, of_far[i]), add(cells_[i].near, of_near[i]);
    return sums;
}

MatrixXd CellSums::transpose_at(const std::vector<int>& points, const Points& values) const {
    const Index columns = 3 * values.rows();
    const auto value = [&](std::size_t i) { return values.row(static_cast<Index>(i)); };
    if (order_.empty()) {
        MatrixXd sums(center_.rows(), columns);
        for (std::size_t i = 0; i < points.size(); ++i)
            sums.middleCols<3>(3 * static_cast<Index>(i)) =
                transpose_here(at_.middleRows(points[i], 1), center_, MatrixXd(value(i)));
        return sums;
    }
    std::vector<MatrixXd> of_near(cells_.size());
    std::vector<Tensor> moment(cells_.size());
    std::vector<char> is_met(cells_.size(), 0);
    for (const int leaf : leaves_) {
        const Cell& cell = cells_[static_cast<std::size_t>(leaf)];
        const auto begin = order_.begin() + cell.first, end = begin + cell.count;
        MatrixXd mine;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto at = std::lower_bound(begin, end, points[i]);
            if (at == end || *at != points[i]) continue;
            if (mine.size() == 0) mine = MatrixXd::Zero(cell.count, columns);
            mine.block<1, 3>(at - begin, 3 * static_cast<Index>(i)) = value(i);
        }
        if (mine.size() == 0) continue;
        of_near[static_cast<std::size_t>(leaf)] = at_leaf(cell, mine, moment[static_cast<std::size_t>(leaf)]);
        for (int c = leaf; c >= 0; c = cells_[static_cast<std::size_t>(c)].parent)
            is_met[static_cast<std::size_t>(c)] = 1;
    }
    return pull_back_all(moment, of_near, is_met, columns);
}

double CellSums::cost() const {
    if (order_.empty()) return num_terms();
    return std::accumulate(cells_.begin(), cells_.end(), 0.0,
                           [&](double sum, const Cell& cell) { return sum + cost_of(cell); });
}

}  // namespace strake
