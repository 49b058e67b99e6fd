#pragma once
#include <type_traits>

#include "core/primo/linear/block_matrix.hpp"
#include "core/primo/linear/lanes.hpp"

/// Sparse rows of 6 x 6 blocks in either precision: the data of a preconditioner. Single precision halves memory and
/// time.
namespace strake {

constexpr int block_entries = 36;  ///< column by column

template <class Real>
struct BlockRows {
    std::vector<int> begin{0};  ///< per row: its first block
    std::vector<int> column;    ///< ascending within a row
    std::vector<Real> value;    ///< block_entries per block

    int size() const { return static_cast<int>(begin.size()) - 1; }
    const Real* block(int k) const { return value.data() + std::size_t{block_entries} * k; }
    Real* block(int k) { return value.data() + std::size_t{block_entries} * k; }
    /// Position of the block (row, column); -1 where there is none.
    int find(int row, int column) const;
    std::size_t bytes() const;
};

/// C += A B of single blocks. C must not be A or B.
template <class Real>
void add_product(const Real* A, const Real* B, Real* C);

/// A vector of six, accumulated over A x of several blocks before its halves are joined. Two columns at a time: twelve
/// numbers are three whole registers of four.
template <class Real>
class BlockSum {
public:
    void add(const Real* A, const Real* x) {  ///< A x
        for (int pair = 0; pair < 3; ++pair, A += 12, x += 2) {
            const Real a = x[0], b = x[1];
            low_ += loose<Lane>(A).lanes * Lane{a, a, a, a};
            middle_ += loose<Lane>(A + 4).lanes * Lane{a, a, b, b};
            high_ += loose<Lane>(A + 8).lanes * Lane{b, b, b, b};
        }
    }
    void store(Real* y) const {
        y[0] = low_[0] + middle_[2];
        y[1] = low_[1] + middle_[3];
        y[2] = low_[2] + high_[0];
        y[3] = low_[3] + high_[1];
        y[4] = middle_[0] + high_[2];
        y[5] = middle_[1] + high_[3];
    }

private:
    using Lane = std::conditional_t<std::is_same_v<Real, float>, FourSingles, Four>;
    Lane low_{}, middle_{}, high_{};
};

/// y (6) = (A x)_i, where the diagonal blocks of A are the identity and not stored.
template <class Real>
void row_product(const BlockRows<Real>& A, int i, const Real* x, Real* y) {
    BlockSum<Real> sum;
    for (int k = A.begin[i]; k < A.begin[i + 1]; ++k) sum.add(A.block(k), x + 6 * A.column[k]);
    sum.store(y);
    for (int q = 0; q < 6; ++q) y[q] += x[6 * i + q];
}
/// Rows per block of a parallel loop, and entries of a vector.
constexpr int rows_at_once = 256, entries_at_once = 16384;

/// The blocks of each column, in the order of their rows.
struct ColumnLists {
    std::vector<int> begin{0}, row, entry;
    int size() const { return static_cast<int>(begin.size()) - 1; }
};
template <class Real>
ColumnLists column_lists(const BlockRows<Real>& P, int columns);

/// y = A x, diagonal blocks as above.
template <class Real>
void multiply(const BlockRows<Real>& A, const std::vector<Real>& x, std::vector<Real>& y);
/// y += P x
template <class Real>
void add_product(const BlockRows<Real>& P, const std::vector<Real>& x, std::vector<Real>& y);
/// Groups of rows for products with the transpose: each collects its sums for the columns that it touches.
template <class Real>
struct RowGroups {
    std::vector<int> first, last;  ///< per group: columns that it reaches
    std::vector<long> begin;       ///< per group: its part of `sums`
    std::vector<Real> sums;
    int rows = 1;  ///< of a group
};
template <class Real>
RowGroups<Real> row_groups(const BlockRows<Real>& P);
/// y = P^T x, y has `columns` blocks.
template <class Real>
void transposed_product(const BlockRows<Real>& P, RowGroups<Real>& groups, const std::vector<Real>& x, int columns,
                        std::vector<Real>& y);
/// Summed in double, in an order that does not depend on the number of threads.
template <class Real>
double dot(const std::vector<Real>& a, const std::vector<Real>& b);

}  // namespace strake
