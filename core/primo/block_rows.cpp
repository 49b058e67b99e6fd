#include "core/primo/block_rows.hpp"

#include <algorithm>

namespace strake {

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
    for (int i = 0; i < A.size(); ++i) row_product(A, i, x.data(), y.data() + 6 * i);
}

template <class Real>
void add_product(const BlockRows<Real>& P, const std::vector<Real>& x, std::vector<Real>& y) {
    for (int i = 0; i < P.size(); ++i) {
        BlockSum<Real> sum;
        for (int k = P.begin[i]; k < P.begin[i + 1]; ++k) sum.add(P.block(k), x.data() + 6 * P.column[k]);
        Real add[6];
        sum.store(add);
        for (int q = 0; q < 6; ++q) y[6 * i + q] += add[q];
    }
}

template <class Real>
void transposed_product(const BlockRows<Real>& P, const std::vector<Real>& x, int columns, std::vector<Real>& y) {
    y.assign(6 * columns, 0);
    for (int i = 0; i < P.size(); ++i) {
        const Real* part = x.data() + 6 * i;
        for (int k = P.begin[i]; k < P.begin[i + 1]; ++k) {
            const Real* A = P.block(k);
            Real* to = y.data() + 6 * P.column[k];
            for (int q = 0; q < 6; ++q, A += 6)
                to[q] += ((A[0] * part[0] + A[1] * part[1]) + (A[2] * part[2] + A[3] * part[3])) +
                         (A[4] * part[4] + A[5] * part[5]);
        }
    }
}

template <class Real>
double dot(const std::vector<Real>& a, const std::vector<Real>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<double>(a[i]) * b[i];
    return sum;
}

#define STRAKE_INSTANTIATE(Real)                                                                                 \
    template struct BlockRows<Real>;                                                                             \
    template void add_product(const Real*, const Real*, Real*);                                                  \
    template void multiply(const BlockRows<Real>&, const std::vector<Real>&, std::vector<Real>&);                \
    template void add_product(const BlockRows<Real>&, const std::vector<Real>&, std::vector<Real>&);             \
    template void transposed_product(const BlockRows<Real>&, const std::vector<Real>&, int, std::vector<Real>&); \
    template double dot(const std::vector<Real>&, const std::vector<Real>&);
STRAKE_INSTANTIATE(float)
STRAKE_INSTANTIATE(double)
#undef STRAKE_INSTANTIATE

}  // namespace strake
