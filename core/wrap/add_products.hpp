#pragma once
#include "core/primo/linear/lanes.hpp"

#include <Eigen/Core>

namespace strake {

constexpr int tall = 4, broad = 3;  ///< columns of A and of B whose products are summed at once, in twelve registers

/// Adds to sums(0..3, 0..2) what rows of four columns at `a` and of three at `b` make. Not unrolled the sums would be
/// in memory: five times the time.
STRAKE_INLINE void add_products(const double* a, Eigen::Index a_stride, const double* b, Eigen::Index b_stride,
                                Eigen::Index rows, double* sums, Eigen::Index sums_stride) {
    constexpr int ahead = 256;  // rows that are fetched before they are needed
    Four all[tall][broad] = {};
    Eigen::Index r = 0;
    for (; r + 4 <= rows; r += 4) {
        Four of_b[broad];
#pragma GCC unroll 4
        for (int j = 0; j < broad; ++j) of_b[j] = four(b + j * b_stride + r).lanes;
#pragma GCC unroll 4
        for (int i = 0; i < tall; ++i) {
            __builtin_prefetch(a + i * a_stride + r + ahead);
            const Four of_a = four(a + i * a_stride + r).lanes;
#pragma GCC unroll 4
            for (int j = 0; j < broad; ++j) all[i][j] += of_a * of_b[j];
        }
    }
    for (int i = 0; i < tall; ++i)
        for (int j = 0; j < broad; ++j) {
            double rest = 0;
            for (Eigen::Index k = r; k < rows; ++k) rest += a[i * a_stride + k] * b[j * b_stride + k];
            sums[j * sums_stride + i] += sum(all[i][j]) + rest;
        }
}

}  // namespace strake
