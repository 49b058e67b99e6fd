#include <Eigen/Cholesky>
#include <atomic>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/primo/linear/multigrid_levels.hpp"

namespace strake {
namespace {

constexpr double min_coarsening = 0.8;  // clusters per row above which another level does not pay

template <class Real>
using Block = Eigen::Matrix<Real, 6, 6>;

/// Both triangles of A without the diagonal, scaled from both sides by the inverse factors of the diagonal.
template <class Real>
BlockRows<Real> scaled_rows(const BlockMatrix& A, const std::vector<Matrix6>& inverse) {
    const int n = A.size();
    BlockRows<Real> rows;
    rows.begin.assign(n + 1, 0);
    for (int j = 0; j < n; ++j)
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k) ++rows.begin[j + 1], ++rows.begin[A.row[k] + 1];
    for (int j = 0; j < n; ++j) rows.begin[j + 1] += rows.begin[j];
    rows.column.resize(rows.begin[n]);
    rows.value.resize(std::size_t{block_entries} * rows.begin[n]);
    // Ascending columns: of row i first the blocks left of the diagonal, in the order of their columns, then the rest.
    std::vector<int> next(rows.begin.begin(), rows.begin.end() - 1), left(A.row.size());
    for (std::size_t k = 0; k < left.size(); ++k) left[k] = next[A.row[k]]++;
    for_blocks(n, rows_at_once, [&](int begin, int end) {
        for (int j = begin; j < end; ++j)
            for (int k = A.begin[j], right = rows.begin[j + 1] - A.begin[j + 1] + k; k < A.begin[j + 1]; ++k, ++right) {
                const int i = A.row[k];
                const Block<Real> block = (inverse[i] * A.below[k] * inverse[j].transpose()).template cast<Real>();
                rows.column[left[k]] = j;
                Eigen::Map<Block<Real>>(rows.block(left[k])) = block;
                rows.column[right] = i;
                Eigen::Map<Block<Real>>(rows.block(right)) = block.transpose();
            }
    });
    return rows;
}

/// Pseudo-random numbers, the same in every run.
float noise(unsigned& state) {
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / static_cast<float>(1u << 23) - 1;
}

/// Bound of the largest eigenvalue, by power iteration and a safety factor.
template <class Real>
double largest_eigenvalue(const BlockRows<Real>& A) {
    std::vector<Real> x(std::size_t{6} * A.size()), y;
    unsigned state = 1;
    for (Real& value : x) value = noise(state);
    double eigenvalue = 1;
    for (int step = 0; step < 12; ++step) {
        multiply(A, x, y);
        const double length = std::sqrt(dot(y, y));
        eigenvalue = length / std::sqrt(dot(x, x));
        if (!(length > 0)) return 1;
        for_blocks(static_cast<int>(x.size()), entries_at_once, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) x[i] = static_cast<Real>(y[i] / length);
        });
    }
    return 1.1 * eigenvalue;
}

Points centres(const Clusters& clusters, const Points& centre) {
    Points sum = Points::Zero(clusters.count, 3);
    Eigen::VectorXd members = Eigen::VectorXd::Zero(clusters.count);
    for (int i = 0; i < centre.rows(); ++i) {
        sum.row(clusters.of[i]) += centre.row(i);
        ++members[clusters.of[i]];
    }
    return members.cwiseInverse().asDiagonal() * sum;
}

template <class Real>
BlockMatrix with_unit_diagonal(const BlockRows<Real>& A) {
    std::vector<std::pair<int, int>> pairs;
    for (int i = 0; i < A.size(); ++i)
        for (int k = A.begin[i]; k < A.begin[i + 1]; ++k) pairs.emplace_back(i, A.column[k]);
    BlockMatrix matrix = block_matrix(A.size(), pairs);
    for (Matrix6& block : matrix.diagonal) block.setIdentity();
    for (int i = 0; i < A.size(); ++i)
        for (int k = A.begin[i]; k < A.begin[i + 1] && A.column[k] < i; ++k)
            matrix.below[matrix.find(A.column[k], i)] =
                Eigen::Map<const Block<Real>>(A.block(k)).template cast<double>();
    return matrix;
}

/// Softest mode of the last level, by inverse iteration: in single precision it is unreliable below some hundred units
/// in the last place.
template <class Real>
constexpr double softest_resolved = 16 * std::numeric_limits<Real>::epsilon();

double softest_mode(const SpdSolver& factor, int size) {
    Eigen::VectorXd x(6L * size);
    unsigned state = 1;
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = noise(state);
    double length = 1;
    for (int step = 0; step < 6; ++step) {
        x = factor.solve(Eigen::VectorXd(x.normalized()));
        length = x.norm();
    }
    return 1 / length;
}

/// Lower Cholesky factors of diagonal blocks, and their inverses. False where one is not positive definite.
bool factors(const std::vector<Matrix6>& diagonal, std::vector<Matrix6>& L, std::vector<Matrix6>& inverse) {
    L.resize(diagonal.size());
    inverse.resize(diagonal.size());
    std::atomic<bool> is_definite = true;
    for_blocks(static_cast<int>(diagonal.size()), rows_at_once, [&](int begin, int end) {
        for (int i = begin; i < end && is_definite; ++i) {
            const Eigen::LLT<Matrix6> cholesky(diagonal[i]);
            if (cholesky.info() != Eigen::Success) is_definite = false;
            L[i] = cholesky.matrixL();
            inverse[i] = cholesky.matrixL().solve(Matrix6::Identity());
        }
    });
    return is_definite;
}

}  // namespace

template <class Real>
bool Hierarchy<Real>::build(const BlockMatrix& A, const Points& centre, const std::vector<Clusters>* clusters) {
    levels_.assign(1, {});
    std::vector<Matrix6> L, inverse;
    if (!factors(A.diagonal, L, inverse)) return false;
    for (Matrix6& lower : L) lower.transposeInPlace();
    levels_[0].T = std::move(L);
    levels_[0].A = scaled_rows<Real>(A, inverse);
    levels_[0].centre = centre;
    scale_.resize(block_entries * inverse.size());
    for_blocks(A.size(), rows_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i)
            Eigen::Map<Block<Real>>(scale_.data() + std::size_t{block_entries} * i) = inverse[i].template cast<Real>();
    });
    inverse = std::vector<Matrix6>();
    for (int at = 0;; ++at) {
        if (clusters && at == static_cast<int>(clusters->size())) break;
        if (clusters)
            levels_[at].clusters = (*clusters)[at];
        else if (is_last(levels_[at], at))
            break;
        Level coarse;
        if (!coarsen(levels_[at], at, coarse)) return false;
        levels_.push_back(std::move(coarse));
    }
    levels_.back().T = std::vector<Matrix6>();
    levels_.back().clusters = {};
    return factorize_last();
}

template <class Real>
std::vector<Clusters> Hierarchy<Real>::take_clusters() {
    std::vector<Clusters> clusters;
    for (std::size_t at = 0; at + 1 < levels_.size(); ++at) clusters.push_back(std::move(levels_[at].clusters));
    return clusters;
}

/// Whether to stop here; makes the clusters of the level if not.
template <class Real>
bool Hierarchy<Real>::is_last(Level& level, int at) const {
    if (level.A.size() <= options_.direct_size) return true;
    level.clusters = at == 0 ? aggregate(level.A, options_.strength, options_.first_radius)
                             : aggregate(level.A, options_.coarse_strength, 1);
    return level.clusters.count > min_coarsening * level.A.size();
}

/// The next coarser level from the clusters of a level. False where it is not positive definite.
template <class Real>
bool Hierarchy<Real>::coarsen(Level& level, int at, Level& coarse) const {
    level.largest = largest_eigenvalue(level.A);
    coarse.centre = centres(level.clusters, level.centre);
    auto P = prolongation(level, at == 0 ? options_.prolongation_steps : options_.coarse_prolongation_steps,
                          4 / (3 * level.largest), coarse);
    if (!P) return false;
    level.P = std::move(*P);
    std::vector<Matrix6> diagonal, L, inverse;
    level.groups = row_groups(level.P);
    coarse.A = galerkin(level.A, level.P, column_lists(level.P, level.clusters.count), diagonal);
    if (!factors(diagonal, L, inverse)) return false;
    for_blocks(coarse.A.size(), rows_at_once, [&](int begin, int end) {
        for (int a = begin; a < end; ++a) {
            coarse.T[a] = (L[a].transpose() * coarse.T[a]).eval();
            for (int k = coarse.A.begin[a]; k < coarse.A.begin[a + 1]; ++k) {
                Eigen::Map<Block<Real>> block(coarse.A.block(k));
                block = (inverse[a] * block.template cast<double>() * inverse[coarse.A.column[k]].transpose())
                            .template cast<Real>();
            }
        }
    });
    for_blocks(static_cast<int>(level.P.column.size()), rows_at_once, [&](int begin, int end) {
        for (int k = begin; k < end; ++k) {
            Eigen::Map<Block<Real>> block(level.P.block(k));
            block = (block.template cast<double>() * inverse[level.P.column[k]].transpose()).template cast<Real>();
        }
    });
    return true;
}

template <class Real>
bool Hierarchy<Real>::factorize_last() {
    const BlockMatrix last = with_unit_diagonal(levels_.back().A);
    coarsest_.analyze(last);
    return coarsest_.factorize(last) && softest_mode(coarsest_, last.size()) > softest_resolved<Real>;
}

template class Hierarchy<float>;
template class Hierarchy<double>;

}  // namespace strake
