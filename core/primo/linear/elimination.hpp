#pragma once
#include <vector>

/// Symbolic factorization of a symmetric sparse matrix, in whatever its rows are (here blocks of six).
namespace strake {

/// Per column: the columns that it meets. Each pair stands at both.
using Neighbours = std::vector<std::vector<int>>;

/// Order in which the elimination tree of the matrix, its columns taken in `order`, is passed children first; the same
/// fill. (Liu, "The Role of Elimination Trees in Sparse Factorization", SIAM J. Matrix Anal. Appl. 11, 1990.)
std::vector<int> postordered(const Neighbours& neighbours, const std::vector<int>& order);

/// Columns that are factorized as one dense panel, with the rows below them.
struct Supernode {
    int first = 0, last = 0;  ///< columns [first, last)
    std::vector<int> below;   ///< rows, ascending
    double zeros = 0;         ///< entries of the panel that are zero in the factor: the price of larger panels
};
/// Supernodes of a postordered matrix, ascending. Small ones are joined with their parents as long as few zeros come
/// in, by CHOLMOD's measures for matrices whose columns come in groups of `columns_each`.
std::vector<Supernode> supernodes_of(const Neighbours& neighbours, const std::vector<int>& order, int columns_each);

}  // namespace strake
