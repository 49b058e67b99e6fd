#pragma once
#include <Eigen/Core>
#include <cstdlib>
#include <memory>
#include <vector>

namespace strake {

/// A supernodal Cholesky factor in single precision, to be substituted with. One substitution reads the whole factor
/// twice and does little else: half of the bytes are half of the time and of the memory. What rounding its entries
/// costs is relative to the factor, so that the error of a solution grows by the root of the matrix's condition alone:
/// a few parts in a thousand for a thin shell of 131k prisms, which conjugate gradients correct.
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
    int most_rows = 0;

    /// Takes over the entries from malloc, column by column with all rows of their supernode: in place, in less than
    /// half of their memory. `first` says where each supernode begins, and the end.
    /// @pre first_column, first_row; every supernode has six rows or more, so that what is written stays behind what
    /// is still to be read.
    void take(double* doubles, const std::vector<long>& first);

    /// What several threads share: tasks of supernodes, round by round; those of one round do not depend on each other.
    /// What a task adds to rows of later rounds it keeps apart, and it is added in the order of the tasks: the same
    /// bits for any number of threads.
    std::vector<int> round_begin;    ///< into the tasks, per round, and the end
    std::vector<int> task_begin;     ///< into `order`, per task, and the end
    std::vector<int> order;          ///< supernodes of the tasks, ascending in each
    std::vector<int> outside_begin;  ///< into `outside`, per task, and the end
    std::vector<int> outside;  ///< rows of later rounds that a task takes part in; `row` says `size` + their place
    /// Makes them, once; `row` is as listed before.
    void plan();

    int num_supernodes() const { return static_cast<int>(first_column.size()) - 1; }
    /// X = (L L^T)^-1 B in the matrix's own order; size x k. Sums are ordered: the same bits on every machine.
    void solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::MatrixXd& X) const;

private:
    void list_outside_rows(const std::vector<int>& task);
};

/// Panels of up to four columns, so that a substitution reads the factor in one go: first the rows that make a triangle
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
