#include "core/primo/linear/supernodal_cholesky.hpp"

#include <algorithm>
#include <cstdlib>
#include <new>

#include "core/primo/linear/elimination.hpp"

extern "C" {
void dpotrf_(const char* triangle, const int* n, double* A, const int* lead, int* info);
void dtrsm_(const char* side, const char* triangle, const char* transposed, const char* diagonal, const int* m,
            const int* n, const double* alpha, const double* A, const int* lead_A, double* B, const int* lead_B);
void dsyrk_(const char* triangle, const char* transposed, const int* n, const int* k, const double* alpha,
            const double* A, const int* lead_A, const double* beta, double* C, const int* lead_C);
}

namespace strake {
namespace {

constexpr int each = 6;  ///< unknowns of a block

Neighbours neighbours_of(const BlockMatrix& A) {
    Neighbours out(A.size());
    for (int j = 0; j < A.size(); ++j)
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k) {
            out[j].push_back(A.row[k]);
            out[A.row[k]].push_back(j);
        }
    return out;
}

}  // namespace

/// Room for numbers, unset. @throws std::bad_alloc
SupernodalCholesky::Doubles SupernodalCholesky::doubles(long count) {
    Doubles out(static_cast<double*>(std::malloc(sizeof(double) * static_cast<std::size_t>(std::max(1L, count)))));
    if (!out) throw std::bad_alloc();
    return out;
}

/// The dense matrix of a supernode: its panel, which becomes columns of the factor, and what they leave for later ones.
struct SupernodalCholesky::Front {
    int supernode, columns, rows;  ///< unknowns of the panel; `rows` with its own
    double* panel;                 ///< rows x columns, columns one after the other
    Doubles rest;                  ///< (rows - columns) squared, lower triangle
    std::vector<int> place;        ///< per block row of the matrix: its block row in the front; valid for those in it

    double* column(int c) const {
        const int below = rows - columns;
        return c < columns ? panel + static_cast<long>(c) * rows
                           : rest.get() + static_cast<long>(c - columns) * below - columns;
    }
    /// Adds what a child left; `row`: its block rows.
    void add(const double* left, const int* row, int blocks) {
        const int lead = each * blocks;
        for (int q = 0; q < blocks; ++q)
            for (int c = 0; c < each; ++c) {
                const double* from = left + static_cast<long>(each * q + c) * lead;
                double* to = column(each * place[row[q]] + c);
                for (int p = q; p < blocks; ++p)
                    for (int r = p == q ? c : 0; r < each; ++r) to[each * place[row[p]] + r] += from[each * p + r];
            }
    }
    /// False where the panel's own triangle is not positive definite.
    bool eliminate() {
        const int below = rows - columns;
        const double one = 1, minus_one = -1;
        int info = 0;
        dpotrf_("L", &columns, panel, &rows, &info);
        for (int c = 0; c < columns && info == 0; ++c)
            if (!(panel[static_cast<long>(c) * (rows + 1)] > 0)) info = c + 1;
        if (info != 0) return false;
        if (below == 0) return true;
        dtrsm_("R", "L", "T", "N", &below, &columns, &one, panel, &rows, panel + columns, &rows);
        dsyrk_("L", "N", &below, &columns, &minus_one, panel + columns, &rows, &one, rest.get(), &below);
        return true;
    }
};

void SupernodalCholesky::analyze(const BlockMatrix& A, const std::vector<int>& order) {
    const Neighbours neighbours = neighbours_of(A);
    *this = {};
    size_ = A.size();
    order_ = postordered(neighbours, order);
    std::vector<Supernode> supernodes = supernodes_of(neighbours, order_, each);
    first_column_ = {0};
    first_row_ = {0};
    first_entry_ = {0};
    std::vector<int> of_column(size_);
    for (Supernode& s : supernodes) {
        std::fill(of_column.begin() + s.first, of_column.begin() + s.last, num_supernodes());
        for (int column = s.first; column < s.last; ++column) row_.push_back(column);
        row_.insert(row_.end(), s.below.begin(), s.below.end());
        const long columns = s.last - s.first, rows = columns + static_cast<long>(s.below.size());
        first_column_.push_back(s.last);
        first_row_.push_back(static_cast<int>(row_.size()));
        first_entry_.push_back(first_entry_.back() + each * each * columns * rows);
    }
    children_.resize(supernodes.size());
    for (std::size_t s = 0; s < supernodes.size(); ++s)
        if (!supernodes[s].below.empty())
            children_[of_column[supernodes[s].below.front()]].push_back(static_cast<int>(s));
    list_entries(A);
}

/// Where each block of A goes: the same at every factorization.
void SupernodalCholesky::list_entries(const BlockMatrix& A) {
    std::vector<int> place(size_);
    for (int k = 0; k < size_; ++k) place[order_[k]] = k;
    entry_begin_.assign(size_ + 1, 0);
    for (int j = 0; j < size_; ++j)
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k) ++entry_begin_[std::min(place[j], place[A.row[k]]) + 1];
    for (int j = 0; j < size_; ++j) entry_begin_[j + 1] += entry_begin_[j];
    std::vector<int> next(entry_begin_.begin(), entry_begin_.end() - 1);
    entry_.resize(entry_begin_[size_]);
    for (int j = 0; j < size_; ++j)
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k) {
            const int column = place[j], row = place[A.row[k]];
            entry_[next[std::min(row, column)]++] = {std::max(row, column), k, row < column};
        }
}

/// The blocks of A in the panel's columns.
void SupernodalCholesky::scatter(const BlockMatrix& A, Front& front) const {
    for (int j = first_column_[front.supernode]; j < first_column_[front.supernode + 1]; ++j) {
        const int own = front.place[j];
        for (int c = 0; c < each; ++c) {
            double* to = front.column(each * own + c);
            for (int r = c; r < each; ++r) to[each * own + r] += A.diagonal[order_[j]](r, c);
            for (int e = entry_begin_[j]; e < entry_begin_[j + 1]; ++e) {
                const Matrix6& block = A.below[entry_[e].k];
                double* at = to + each * front.place[entry_[e].row];
                for (int r = 0; r < each; ++r) at[r] += entry_[e].transposed ? block(c, r) : block(r, c);
            }
        }
    }
}

bool SupernodalCholesky::factorize(const BlockMatrix& A, Supernodes& factor) const {
    factor = {};
    Doubles entries = doubles(num_entries());
    std::fill_n(entries.get(), num_entries(), 0.0);
    std::vector<Doubles> left(num_supernodes());
    Front front{};
    front.place.resize(size_);
    for (int s = 0; s < num_supernodes(); ++s) {
        const int* row = row_.data() + first_row_[s];
        const int blocks = first_row_[s + 1] - first_row_[s];
        front.supernode = s;
        front.columns = each * (first_column_[s + 1] - first_column_[s]);
        front.rows = each * blocks;
        front.panel = entries.get() + first_entry_[s];
        const long below = front.rows - front.columns;
        front.rest = doubles(below * below);
        std::fill_n(front.rest.get(), below * below, 0.0);
        for (int k = 0; k < blocks; ++k) front.place[row[k]] = k;
        scatter(A, front);
        for (const int child : children_[s]) {
            const int own = first_column_[child + 1] - first_column_[child];
            front.add(left[child].get(), row_.data() + first_row_[child] + own,
                      first_row_[child + 1] - first_row_[child] - own);
            left[child].reset();
        }
        if (!front.eliminate()) return false;
        left[s] = std::move(front.rest);
    }
    factor.size = each * size_;
    for (const int j : order_)
        for (int q = 0; q < each; ++q) factor.permutation.push_back(each * j + q);
    for (const int column : first_column_) factor.first_column.push_back(each * column);
    for (const int place : first_row_) factor.first_row.push_back(long{each} * place);
    for (const int row : row_)
        for (int q = 0; q < each; ++q) factor.row.push_back(each * row + q);
    for (int s = 0; s < num_supernodes(); ++s)
        factor.max_rows = std::max(factor.max_rows, each * (first_row_[s + 1] - first_row_[s]));
    factor.take(entries.release(), first_entry_);
    factor.plan();
    return true;
}

}  // namespace strake
