#include "core/primo/block_rows.hpp"

#include <algorithm>

#include "core/parallel.hpp"

namespace strake {
namespace {

constexpr int columns_at_once = 64;  // each has the blocks of a cluster, twenty and more

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
void transposed_product(const BlockRows<Real>& P, const ColumnLists& lists, const std::vector<Real>& x,
                        std::vector<Real>& y) {
    y.resize(6 * lists.size());
    for_blocks(lists.size(), columns_at_once, [&](int begin, int end) {
        for (int c = begin; c < end; ++c) {
            Real to[6] = {};
            for (int t = lists.begin[c]; t < lists.begin[c + 1]; ++t) {
                const Real *A = P.block(lists.entry[t]), *part = x.data() + 6 * lists.row[t];
                for (int q = 0; q < 6; ++q, A += 6)
                    to[q] += ((A[0] * part[0] + A[1] * part[1]) + (A[2] * part[2] + A[3] * part[3])) +
                             (A[4] * part[4] + A[5] * part[5]);
            }
            std::copy(to, to + 6, y.data() + 6 * c);
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

#define STRAKE_INSTANTIATE(Real)                                                                           \
    template struct BlockRows<Real>;                                                                       \
    template void add_product(const Real*, const Real*, Real*);                                            \
    template void multiply(const BlockRows<Real>&, const std::vector<Real>&, std::vector<Real>&);          \
    template void add_product(const BlockRows<Real>&, const std::vector<Real>&, std::vector<Real>&);       \
    template ColumnLists column_lists(const BlockRows<Real>&, int);                                        \
    template void transposed_product(const BlockRows<Real>&, const ColumnLists&, const std::vector<Real>&, \
                                     std::vector<Real>&);                                                  \
    template double dot(const std::vector<Real>&, const std::vector<Real>&);
STRAKE_INSTANTIATE(float)
STRAKE_INSTANTIATE(double)
#undef STRAKE_INSTANTIATE

}  // namespace strake
