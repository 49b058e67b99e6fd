#include "core/primo/linear/block_rows.hpp"

#include <algorithm>

#include "core/parallel.hpp"

namespace strake {
namespace {

constexpr int columns_at_once = 4096;
constexpr int max_groups = 16, min_rows = 512;  // of rows, whose transposed products are added up

}  // namespace

template <class Real>
int BlockRows<Real>::find(int row, int wanted) const {
    const auto first = column.begin() + begin[row], last = column.begin() + begin[row + 1];
    const auto at = std::lower_bound(first, last, wanted);
    return at != last && *at == wanted ? static_cast<int>(at - column.begin()) : -1;
}

template <class Real>
std::size_t BlockRows<Real>::bytes() const {
    return sizeof(int) * (begin.size() + column.size()) + sizeof(Real) * value.size();
}

template <class Real>
void add_product(const Real* A, const Real* B, Real* C) {
    for (int q = 0; q < 6; ++q) {
        BlockSum<Real> sum;
        sum.add(A, B + 6 * q);
        Real y[6];
        sum.store(y);
        for (int r = 0; r < 6; ++r) C[6 * q + r] += y[r];
    }
}

template <class Real>
void multiply(const BlockRows<Real>& A, const std::vector<Real>& x, std::vector<Real>& y) {
    y.resize(x.size());
    for_blocks(A.size(), rows_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) row_product(A, i, x.data(), y.data() + 6 * i);
    });
}

template <class Real>
void add_product(const BlockRows<Real>& P, const std::vector<Real>& x, std::vector<Real>& y) {
    for_blocks(P.size(), rows_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            BlockSum<Real> sum;
            for (int k = P.begin[i]; k < P.begin[i + 1]; ++k) sum.add(P.block(k), x.data() + 6 * P.column[k]);
            Real add[6];
            sum.store(add);
            for (int q = 0; q < 6; ++q) y[6 * i + q] += add[q];
        }
    });
}

template <class Real>
ColumnLists column_lists(const BlockRows<Real>& P, int columns) {
    ColumnLists lists{std::vector<int>(columns + 1, 0), std::vector<int>(P.column.size()),
                      std::vector<int>(P.column.size())};
    for (const int c : P.column) ++lists.begin[c + 1];
    for (int c = 0; c < columns; ++c) lists.begin[c + 1] += lists.begin[c];
    std::vector<int> next(lists.begin.begin(), lists.begin.end() - 1);
    for (int i = 0; i < P.size(); ++i)
        for (int k = P.begin[i]; k < P.begin[i + 1]; ++k) {
            lists.row[next[P.column[k]]] = i;
            lists.entry[next[P.column[k]]++] = k;
        }
    return lists;
}

template <class Real>
RowGroups<Real> row_groups(const BlockRows<Real>& P) {
    RowGroups<Real> groups;
    groups.rows = std::max(min_rows, (P.size() + max_groups - 1) / max_groups);
    long size = 0;
    for (int i = 0; i < P.size(); i += groups.rows) {
        const auto begin = P.column.begin() + P.begin[i],
                   end = P.column.begin() + P.begin[std::min(P.size(), i + groups.rows)];
        const auto [least, most] = std::minmax_element(begin, end);
        groups.first.push_back(begin == end ? 0 : *least);
        groups.last.push_back(begin == end ? 0 : *most + 1);
        groups.begin.push_back(size);
        size += 6L * (groups.last.back() - groups.first.back());
    }
    groups.sums.resize(size);
    return groups;
}

template <class Real>
void transposed_product(const BlockRows<Real>& P, RowGroups<Real>& groups, const std::vector<Real>& x, int columns,
                        std::vector<Real>& y) {
    y.resize(6 * columns);
    for_blocks(P.size(), groups.rows, [&](int begin, int end) {
        const int group = begin / groups.rows, first = groups.first[group];
        Real* sums = groups.sums.data() + groups.begin[group];
        std::fill(sums, sums + 6L * (groups.last[group] - first), Real(0));
        for (int i = begin; i < end; ++i) {
            const Real* part = x.data() + 6 * i;
            for (int k = P.begin[i]; k < P.begin[i + 1]; ++k) {
                const Real* A = P.block(k);
                Real* to = sums + 6 * (P.column[k] - first);
                for (int q = 0; q < 6; ++q, A += 6)
                    to[q] += ((A[0] * part[0] + A[1] * part[1]) + (A[2] * part[2] + A[3] * part[3])) +
                             (A[4] * part[4] + A[5] * part[5]);
            }
        }
    });
    for_blocks(columns, columns_at_once, [&](int begin, int end) {
        std::fill(y.data() + 6L * begin, y.data() + 6L * end, Real(0));
        for (std::size_t g = 0; g < groups.first.size(); ++g) {
            const Real* sums = groups.sums.data() + groups.begin[g] - 6L * groups.first[g];
            for (int q = 6 * std::max(begin, groups.first[g]); q < 6 * std::min(end, groups.last[g]); ++q)
                y[q] += sums[q];
        }
    });
}

template <class Real>
double dot(const std::vector<Real>& a, const std::vector<Real>& b) {
    return ordered_sum(static_cast<int>(a.size()), entries_at_once, [&](int begin, int end) {
        double sum = 0;
        for (int i = begin; i < end; ++i) sum += static_cast<double>(a[i]) * b[i];
        return sum;
    });
}

#define STRAKE_INSTANTIATE(Real)                                                                              \
    template struct BlockRows<Real>;                                                                          \
    template void add_product(const Real*, const Real*, Real*);                                               \
    template void multiply(const BlockRows<Real>&, const std::vector<Real>&, std::vector<Real>&);             \
    template void add_product(const BlockRows<Real>&, const std::vector<Real>&, std::vector<Real>&);          \
    template ColumnLists column_lists(const BlockRows<Real>&, int);                                           \
    template RowGroups<Real> row_groups(const BlockRows<Real>&);                                              \
    template void transposed_product(const BlockRows<Real>&, RowGroups<Real>&, const std::vector<Real>&, int, \
                                     std::vector<Real>&);                                                     \
    template double dot(const std::vector<Real>&, const std::vector<Real>&);
STRAKE_INSTANTIATE(float)
STRAKE_INSTANTIATE(double)
#undef STRAKE_INSTANTIATE

}  // namespace strake
