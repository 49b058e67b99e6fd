#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "core/primo/multigrid_levels.hpp"

namespace strake {
namespace {

/// One row under construction: blocks by column, found through `place`.
template <class Real>
class RowBuilder {
public:
    explicit RowBuilder(int columns) : place_(columns, -1) {}
    Real* at(int column) {
        if (place_[column] < 0) {
            place_[column] = static_cast<int>(columns_.size());
            columns_.push_back(column);
            value_.resize(value_.size() + block_entries, 0);
        }
        return value_.data() + block_entries * place_[column];
    }
    /// Appends the row, sorted, and is empty again.
    void finish(BlockRows<Real>& rows) {
        order_ = columns_;
        std::sort(order_.begin(), order_.end());
        for (const int column : order_) {
            const Real* block = value_.data() + block_entries * place_[column];
            rows.column.push_back(column);
            rows.value.insert(rows.value.end(), block, block + block_entries);
            place_[column] = -1;
        }
        rows.begin.push_back(static_cast<int>(rows.column.size()));
        columns_.clear();
        value_.clear();
    }

private:
    std::vector<int> place_, columns_, order_;
    std::vector<Real> value_;
};

/// Blocks of A P with the unit diagonal of A.
template <class Real>
std::size_t product_size(const BlockRows<Real>& A, const BlockRows<Real>& P, int columns) {
    std::size_t count = 0;
    std::vector<int> seen(columns, -1);
    for (int i = 0; i < A.size(); ++i) {
        const auto add = [&](int j) {
            for (int p = P.begin[j]; p < P.begin[j + 1]; ++p)
                if (std::exchange(seen[P.column[p]], i) != i) ++count;
        };
        add(i);
        for (int k = A.begin[i]; k < A.begin[i + 1]; ++k) add(A.column[k]);
    }
    return count;
}

/// Row i of (share I + factor A) P with the unit diagonal of A.
template <class Real>
void product_row(const BlockRows<Real>& A, const BlockRows<Real>& P, int i, Real share, Real factor,
                 RowBuilder<Real>& row, BlockRows<Real>& one) {
    one.begin.assign(1, 0), one.column.clear(), one.value.clear();
    for (int k = A.begin[i]; k < A.begin[i + 1]; ++k) {
        const int j = A.column[k];
        for (int p = P.begin[j]; p < P.begin[j + 1]; ++p) add_product(A.block(k), P.block(p), row.at(P.column[p]));
    }
    for (int p = P.begin[i]; p < P.begin[i + 1]; ++p) row.at(P.column[p]);
    row.finish(one);
    for (std::size_t c = 0; c < one.column.size(); ++c) {
        Real* block = one.block(static_cast<int>(c));
        const int own = P.find(i, one.column[c]);
        for (int q = 0; q < block_entries; ++q)
            block[q] = factor * block[q] + (own < 0 ? 0 : (share + factor) * P.block(own)[q]);
    }
}

/// (share I + factor A) P with the unit diagonal of A.
template <class Real>
BlockRows<Real> product(const BlockRows<Real>& A, const BlockRows<Real>& P, int columns, Real share, Real factor) {
    BlockRows<Real> result, one;
    const std::size_t blocks = product_size(A, P, columns);  // growing would take twice the memory for a while
    result.column.reserve(blocks);
    result.value.reserve(std::size_t{block_entries} * blocks);
    RowBuilder<Real> row(columns);
    for (int i = 0; i < A.size(); ++i) {
        product_row(A, P, i, share, factor, row, one);
        result.column.insert(result.column.end(), one.column.begin(), one.column.end());
        result.value.insert(result.value.end(), one.value.begin(), one.value.end());
        result.begin.push_back(static_cast<int>(result.column.size()));
    }
    return result;
}

/// P^T A P without its diagonal, all zeros.
template <class Real>
BlockRows<Real> galerkin_pattern(const BlockRows<Real>& A, const BlockRows<Real>& P, int columns) {
    std::vector<int> begin(columns + 1, 0), owner(P.column.size()), seen(columns, -1);
    for (const int c : P.column) ++begin[c + 1];
    for (int c = 0; c < columns; ++c) begin[c + 1] += begin[c];
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (int i = 0; i < P.size(); ++i)
        for (int k = P.begin[i]; k < P.begin[i + 1]; ++k) owner[next[P.column[k]]++] = i;
    BlockRows<Real> pattern;
    for (int a = 0; a < columns; ++a) {
        seen[a] = a;
        const std::size_t first = pattern.column.size();
        const auto add = [&](int j) {
            for (int p = P.begin[j]; p < P.begin[j + 1]; ++p)
                if (std::exchange(seen[P.column[p]], a) != a) pattern.column.push_back(P.column[p]);
        };
        for (int t = begin[a]; t < begin[a + 1]; ++t) {
            add(owner[t]);
            for (int k = A.begin[owner[t]]; k < A.begin[owner[t] + 1]; ++k) add(A.column[k]);
        }
        std::sort(pattern.column.begin() + static_cast<std::ptrdiff_t>(first), pattern.column.end());
        pattern.begin.push_back(static_cast<int>(pattern.column.size()));
    }
    pattern.value.assign(std::size_t{block_entries} * pattern.column.size(), 0);
    return pattern;
}

/// Rigid motions of the clusters about `centre` in the scaled unknowns of one row.
template <class Real>
Matrix6 rigid_motion(const MultigridLevel<Real>& level, int i, const Points& centre) {
    const Eigen::Vector3d arm = (level.centre.row(i) - centre.row(level.clusters.of[i])).transpose();
    Matrix6 rigid = Matrix6::Identity();  // v_i = v + omega x arm
    rigid.block<3, 3>(3, 0) << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
    return level.T[i] * rigid;
}

}  // namespace

template <class Real>
std::optional<BlockRows<Real>> prolongation(MultigridLevel<Real>& level, int steps, double damping,
                                            MultigridLevel<Real>& coarse) {
    std::vector<Matrix6> gram(level.clusters.count, Matrix6::Zero());
    for (int i = 0; i < level.A.size(); ++i) {
        const Matrix6 rigid = rigid_motion(level, i, coarse.centre);
        gram[level.clusters.of[i]].noalias() += rigid.transpose() * rigid;
    }
    std::vector<Matrix6> inverse(level.clusters.count);
    coarse.T.resize(level.clusters.count);
    for (int a = 0; a < level.clusters.count; ++a) {
        const Eigen::LLT<Matrix6> cholesky(gram[a]);
        if (cholesky.info() != Eigen::Success) return std::nullopt;
        coarse.T[a] = cholesky.matrixU();
        inverse[a] = cholesky.matrixU().solve(Matrix6::Identity());
    }
    BlockRows<Real> P;
    P.value.resize(std::size_t{block_entries} * level.A.size());
    for (int i = 0; i < level.A.size(); ++i) {
        const int to = level.clusters.of[i];
        Eigen::Map<Eigen::Matrix<Real, 6, 6>>(P.block(i)) =
            Matrix6(rigid_motion(level, i, coarse.centre) * inverse[to]).template cast<Real>();
        P.column.push_back(to);
        P.begin.push_back(i + 1);
    }
    level.T = {};  // before P grows
    for (int step = 0; step < steps; ++step)
        P = product<Real>(level.A, P, level.clusters.count, 1, static_cast<Real>(-damping));
    return P;
}

/// Row by row of A P, which is several times the size of the result and never there as a whole.
template <class Real>
BlockRows<Real> galerkin(const BlockRows<Real>& A, const BlockRows<Real>& P, int columns,
                         std::vector<Matrix6>& diagonal) {
    using Block = Eigen::Matrix<Real, 6, 6>;
    BlockRows<Real> result = galerkin_pattern(A, P, columns), one;
    std::vector<Block> own(columns, Block::Zero());
    RowBuilder<Real> row(columns);
    for (int i = 0; i < A.size(); ++i) {
        product_row<Real>(A, P, i, 0, 1, row, one);
        for (int p = P.begin[i]; p < P.begin[i + 1]; ++p) {
            const int a = P.column[p];
            const Block transposed = Eigen::Map<const Block>(P.block(p)).transpose();
            for (std::size_t c = 0; c < one.column.size(); ++c) {
                const int b = one.column[c];
                add_product(transposed.data(), one.block(static_cast<int>(c)),
                            a == b ? own[a].data() : result.block(result.find(a, b)));
            }
        }
    }
    diagonal.resize(columns);
    for (int a = 0; a < columns; ++a) {
        diagonal[a] = own[a].template cast<double>();
        diagonal[a] = (0.5 * (diagonal[a] + diagonal[a].transpose())).eval();
    }
    return result;
}

#define STRAKE_INSTANTIATE(Real)                                                                                     \
    template std::optional<BlockRows<Real>> prolongation(MultigridLevel<Real>&, int, double, MultigridLevel<Real>&); \
    template BlockRows<Real> galerkin(const BlockRows<Real>&, const BlockRows<Real>&, int, std::vector<Matrix6>&);
STRAKE_INSTANTIATE(float)
STRAKE_INSTANTIATE(double)
#undef STRAKE_INSTANTIATE

}  // namespace strake
