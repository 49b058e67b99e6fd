#pragma once
#include <Eigen/Core>
#include <cstdlib>
#include <memory>
#include <vector>

namespace strake {

/// A supernodal Cholesky factor in single precision, for substitutions. A substitution is bound by reading the whole
/// factor twice: half the bytes halve time and memory. Rounding is relative to the factor, so the error of a solution
/// grows only with the square root of the condition number: a few parts in a thousand for a thin shell of 131k prisms,
/// which conjugate gradients correct.
struct Supernodes {
    int size = 0;                   ///< unknowns
    std::vector<int> permutation;   ///< unknown of the matrix at each place of the factor
    std::vector<int> first_column;  ///< per supernode, and the end
    std::vector<long> first_row;    ///< into `row`, per supernode, and the end
    std::vector<int> row;           ///< of each supernode: its own columns, then those below, ascending
    std::vector<long> first_entry;  ///< into `entry`, per supernode, and the end: panels (see below)
    struct Free {
        void operator()(float* values) const { std::free(values); }
    };
    std::unique_ptr<float[], Free> entry;
    int max_rows = 0;

    /// Takes over the entries from malloc, column by column with all rows of their supernode: in place, in less than
    /// half of their memory. `first` says where each supernode begins, and the end.
    /// @pre first_column, first_row; every supernode has at least six rows, which keeps writes behind reads.
    void take(double* doubles, const std::vector<long>& first);

    /// Parallel schedule: tasks of supernodes in rounds; the tasks of a round are independent. Contributions to rows of
    /// later rounds are stored separately and added in the order of the tasks: the same bits for any number of threads.
    std::vector<int> round_begin;    ///< into the tasks, per round, and the end
    std::vector<int> task_begin;     ///< into `order`, per task, and the end
    std::vector<int> order;          ///< supernodes of the tasks, ascending in each
    std::vector<int> outside_begin;  ///< into `outside`, per task, and the end
    std::vector<int> outside;  ///< rows of later rounds that a task contributes to; `row` holds `size` + their position
    /// Makes them, once; `row` is as listed before.
    void plan();

    int num_supernodes() const { return static_cast<int>(first_column.size()) - 1; }
    /// X = (L L^T)^-1 B in the matrix's own order; size x k. Sums are ordered: the same bits on every machine.
    void solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::MatrixXd& X) const;

private:
    void list_outside_rows(const std::vector<int>& task);
};

/// Panels of up to four columns, in the order in which a substitution reads them: first the rows that make a triangle
/// with them, column by column, then four rows below at a time, column by column; zeros fill the last four.
constexpr int panel_rows = 4, widest_panel = 4;
constexpr int panel_width(int columns_left) {
    return columns_left >= widest_panel ? widest_panel : columns_left >= 2 ? 2 : 1;
}
constexpr int triangle_size(int panel) { return panel * panel_rows; }
/// @param height rows of the panel, those of its triangle included
constexpr long panel_size(int panel, int height) {
    return triangle_size(panel) +
           static_cast<long>(panel) * panel_rows * ((height - panel + panel_rows - 1) / panel_rows);
}

}  // namespace strake
