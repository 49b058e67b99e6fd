#pragma once
#include "core/primo/linear/block_matrix.hpp"
#include "core/primo/linear/supernodes.hpp"

namespace strake {

/// Supernodal Cholesky factorization P A P^T = L L^T of a symmetric BlockMatrix, multifrontal (Duff and Reid 1983; Liu,
/// "The Multifrontal Method for Sparse Matrix Solution", SIAM Review 34, 1992), its dense kernels by BLAS and LAPACK.
/// It does what CHOLMOD's supernodal module does, without that module's licence. One thread: the same bits always.
class SupernodalCholesky {
public:
    /// Elimination tree, supernodes and their rows; once per pattern. `order`: entry k is eliminated k-th, at best by
    /// block_order().
    void analyze(const BlockMatrix& A, const std::vector<int>& order);

    /// The factor in single precision, ready for substitutions. False where A is not positive definite; `factor` is
    /// empty then. Takes 8 bytes an entry of the factor, and for the fronts up to as much again.
    /// @pre A has the pattern of analyze(). @throws std::bad_alloc
    [[nodiscard]] bool factorize(const BlockMatrix& A, Supernodes& factor) const;

    long num_entries() const { return first_entry_.empty() ? 0 : first_entry_.back(); }  ///< of the supernodes

private:
    /// A block of A at its place in the factor: its rows are those of `row`; `k` in BlockMatrix::below.
    struct Entry {
        int row, k;
        bool transposed;
    };
    struct Free {
        void operator()(double* values) const { std::free(values); }
    };
    using Doubles = std::unique_ptr<double[], Free>;  ///< from malloc, which Supernodes takes over
    struct Front;

    int size_ = 0;                   ///< block rows
    std::vector<int> order_;         ///< block row of A at each place
    std::vector<int> first_column_;  ///< per supernode, and the end: block columns
    std::vector<int> first_row_;     ///< into row_, per supernode, and the end
    std::vector<int> row_;           ///< block rows of each supernode: its own columns, then those below, ascending
    std::vector<std::vector<int>> children_;  ///< per supernode
    std::vector<int> entry_begin_;            ///< into entry_, per block column, and the end
    std::vector<Entry> entry_;                ///< below the diagonal
    std::vector<long> first_entry_;           ///< per supernode, and the end: of its panel, column by column

    int num_supernodes() const { return static_cast<int>(first_column_.size()) - 1; }
    static Doubles doubles(long count);
    void list_entries(const BlockMatrix& A);
    void scatter(const BlockMatrix& A, Front& front) const;
};

}  // namespace strake
