#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <utility>

#include "core/parallel.hpp"
#include "core/primo/linear/multigrid_levels.hpp"

namespace strake {
namespace {

// Rows done at once by one of several threads.
constexpr int products_at_once = 1024, clusters_at_once = 128;
constexpr int galerkin_at_once = 1 << 16;  // rows of A P in memory at a time

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
    /// Writes the row `i`, sorted, and is empty again.
    void finish(BlockRows<Real>& rows, int i) {
        std::sort(columns_.begin(), columns_.end());
        int to = rows.begin[i];
        for (const int column : columns_) {
            const Real* block = value_.data() + block_entries * place_[column];
            rows.column[to] = column;
            std::copy(block, block + block_entries, rows.block(to++));
            place_[column] = -1;
        }
        columns_.clear();
        value_.clear();
    }

    /// Adds the row to row `i`, which has all of its columns, and is empty again. That of column `apart` goes to
    /// `taken`.
    void add_to(BlockRows<Real>& rows, int i, int apart, Real* taken) {
        for (const int column : columns_) {
            const Real* block = value_.data() + block_entries * place_[column];
            Real* to = column == apart ? taken : rows.block(rows.find(i, column));
            for (int q = 0; q < block_entries; ++q) to[q] += block[q];
            place_[column] = -1;
        }
        columns_.clear();
        value_.clear();
    }

private:
    std::vector<int> place_, columns_;
    std::vector<Real> value_;
};

/// Makes room for n rows. `for_columns(i, seen)` calls seen(column) for what is in row i, again and again.
template <class Real, class ForColumns>
BlockRows<Real> empty_rows(int n, int columns, const ForColumns& for_columns) {
    BlockRows<Real> rows;
    rows.begin.assign(n + 1, 0);
    for_blocks(n, products_at_once, [&](int begin, int end) {
        std::vector<int> last(columns, -1);
        for (int i = begin; i < end; ++i)
            for_columns(i, [&](int column) {
                if (std::exchange(last[column], i) != i) ++rows.begin[i + 1];
            });
    });
    for (int i = 0; i < n; ++i) rows.begin[i + 1] += rows.begin[i];
    rows.column.resize(rows.begin[n]);
    rows.value.resize(std::size_t{block_entries} * rows.begin[n]);
    return rows;
}

/// block <- factor block + share other; `other` may be null.
template <class Real>
void combine(Real factor, Real* block, Real share, const Real* other) {
    for (int q = 0; q < block_entries; ++q) block[q] = factor * block[q] + (other ? share * other[q] : 0);
}

/// Rows [first, end) of (share I + factor A) P with the unit diagonal of A.
template <class Real>
BlockRows<Real> product(const BlockRows<Real>& A, const BlockRows<Real>& P, int columns, Real share, Real factor,
                        int first, int end) {
    BlockRows<Real> result = empty_rows<Real>(end - first, columns, [&](int i, const auto& seen) {
        const auto see = [&](int j) {
            for (int p = P.begin[j]; p < P.begin[j + 1]; ++p) seen(P.column[p]);
        };
        see(first + i);
        for (int k = A.begin[first + i]; k < A.begin[first + i + 1]; ++k) see(A.column[k]);
    });
    for_blocks(end - first, products_at_once, [&](int from, int to) {
        RowBuilder<Real> row(columns);
        for (int i = first + from; i < first + to; ++i) {
            for (int k = A.begin[i]; k < A.begin[i + 1]; ++k) {
                const int j = A.column[k];
                for (int p = P.begin[j]; p < P.begin[j + 1]; ++p)
                    add_product(A.block(k), P.block(p), row.at(P.column[p]));
            }
            for (int p = P.begin[i]; p < P.begin[i + 1]; ++p) row.at(P.column[p]);
            row.finish(result, i - first);
            for (int c = result.begin[i - first]; c < result.begin[i - first + 1]; ++c) {
                const int own = P.find(i, result.column[c]);
                combine(factor, result.block(c), share + factor, own < 0 ? nullptr : P.block(own));
            }
        }
    });
    return result;
}

/// P^T A P without its diagonal, all zeros.
template <class Real>
BlockRows<Real> galerkin_pattern(const BlockRows<Real>& A, const BlockRows<Real>& P, const ColumnLists& in_columns) {
    const auto for_row = [&](int a, const auto& seen) {
        const auto see = [&](int j) {
            for (int p = P.begin[j]; p < P.begin[j + 1]; ++p)
                if (P.column[p] != a) seen(P.column[p]);
        };
        for (int t = in_columns.begin[a]; t < in_columns.begin[a + 1]; ++t) {
            const int i = in_columns.row[t];
            see(i);
            for (int k = A.begin[i]; k < A.begin[i + 1]; ++k) see(A.column[k]);
        }
    };
    const int columns = in_columns.size();
    BlockRows<Real> rows = empty_rows<Real>(columns, columns, for_row);
    for_blocks(columns, products_at_once, [&](int begin, int end) {
        std::vector<int> last(columns, -1);
        for (int a = begin; a < end; ++a) {
            int* to = rows.column.data() + rows.begin[a];
            for_row(a, [&](int column) {
                if (std::exchange(last[column], a) != a) *to++ = column;
            });
            std::sort(rows.column.data() + rows.begin[a], to);
        }
    });
    return rows;
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
    BlockRows<Real> P;
    P.value.resize(std::size_t{block_entries} * level.A.size());
    P.column = level.clusters.of;
    for (int i = 0; i < level.A.size(); ++i) P.begin.push_back(i + 1);
    const ColumnLists members = column_lists(P, level.clusters.count);
    coarse.T.resize(level.clusters.count);
    std::atomic<bool> is_independent = true;
    for_blocks(level.clusters.count, clusters_at_once, [&](int begin, int end) {
        for (int a = begin; a < end; ++a) {
            Matrix6 gram = Matrix6::Zero();
            for (int t = members.begin[a]; t < members.begin[a + 1]; ++t) {
                const Matrix6 rigid = rigid_motion(level, members.row[t], coarse.centre);
                gram.noalias() += rigid.transpose() * rigid;
            }
            const Eigen::LLT<Matrix6> cholesky(gram);
            if (cholesky.info() != Eigen::Success) is_independent = false;
            coarse.T[a] = cholesky.matrixU();
            const Matrix6 inverse = cholesky.matrixU().solve(Matrix6::Identity());
            for (int t = members.begin[a]; t < members.begin[a + 1]; ++t)
                Eigen::Map<Eigen::Matrix<Real, 6, 6>>(P.block(members.row[t])) =
                    Matrix6(rigid_motion(level, members.row[t], coarse.centre) * inverse).template cast<Real>();
        }
    });
    if (!is_independent) return std::nullopt;
    level.T = std::vector<Matrix6>();  // before P grows; clear() would keep the memory
    for (int step = 0; step < steps; ++step)
        P = product<Real>(level.A, P, level.clusters.count, 1, static_cast<Real>(-damping), 0, level.A.size());
    return P;
}

/// A P is several times larger than the result: only some of its rows are in memory at a time.
template <class Real>
BlockRows<Real> galerkin(const BlockRows<Real>& A, const BlockRows<Real>& P, const ColumnLists& in_columns,
                         std::vector<Matrix6>& diagonal) {
    using Block = Eigen::Matrix<Real, 6, 6>;
    const int columns = in_columns.size();
    BlockRows<Real> result = galerkin_pattern(A, P, in_columns);
    std::vector<Block> own(columns, Block::Zero());
    std::vector<int> next(in_columns.begin.begin(), in_columns.begin.end() - 1);
    for (int first = 0; first < A.size(); first += galerkin_at_once) {
        const int last = std::min(A.size(), first + galerkin_at_once);
        const BlockRows<Real> AP = product<Real>(A, P, columns, 0, 1, first, last);
        for_blocks(columns, clusters_at_once, [&](int begin, int end) {
            RowBuilder<Real> row(columns);
            for (int a = begin; a < end; ++a) {
                for (int& t = next[a]; t < in_columns.begin[a + 1] && in_columns.row[t] < last; ++t) {
                    const Block transposed = Eigen::Map<const Block>(P.block(in_columns.entry[t])).transpose();
                    const int i = in_columns.row[t] - first;
                    for (int k = AP.begin[i]; k < AP.begin[i + 1]; ++k)
                        add_product(transposed.data(), AP.block(k), row.at(AP.column[k]));
                }
                row.add_to(result, a, a, own[a].data());
            }
        });
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
    template BlockRows<Real> galerkin(const BlockRows<Real>&, const BlockRows<Real>&, const ColumnLists&,            \
                                      std::vector<Matrix6>&);
STRAKE_INSTANTIATE(float)
STRAKE_INSTANTIATE(double)
#undef STRAKE_INSTANTIATE

}  // namespace strake
