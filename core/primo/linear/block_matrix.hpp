#pragma once
#include <Eigen/Core>
#include <utility>
#include <vector>

/// Symmetric sparse matrix of 6 x 6 blocks, one row per free prism: the Hessian of the shell.
namespace strake {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

struct BlockMatrix {
    std::vector<int> begin{0};  ///< per column: its blocks strictly below the diagonal
    std::vector<int> row;       ///< ascending within a column
    std::vector<Matrix6> diagonal, below;

    /// Products run over groups of columns in parallel. Each group writes its own rows; the blocks that its rows take
    /// from earlier columns are listed in order.
    static constexpr int group = 1024;
    struct Crossing {
        int at, column;  ///< block below[at]
    };
    std::vector<int> crossing_begin;  ///< per group, and the end
    std::vector<Crossing> crossing;

    int size() const { return static_cast<int>(diagonal.size()); }
    /// Position in `below` of the block (max, min) of two different rows. @pre it exists.
    int find(int a, int b) const;
    bool is_finite() const;
    Eigen::VectorXd multiply(const Eigen::VectorXd& x) const;
    Eigen::MatrixXd multiply_columns(
        const Eigen::MatrixXd& X) const;  ///< reads the matrix once; the same sums as `multiply`
};

/// All-zero matrix with blocks at the listed pairs (any order, duplicates allowed, equal members ignored).
BlockMatrix block_matrix(int size, const std::vector<std::pair<int, int>>& pairs);

}  // namespace strake
