#pragma once
#include "core/wrap/radial_tiles.hpp"

#include <array>

/// Chebyshev polynomials in a box: products T_i T_j T_k of the coordinates, those with
/// (i/n_1)^2 + (j/n_2)^2 + (k/n_3)^2 <= 1. (A function with a singularity outside of the box has no larger ones in its
/// corner: Trefethen 2017.)
namespace strake {

using Degree = std::array<int, 3>;
using CellTensor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int max_degree = 8;

inline int num_products(const Degree& n) { return (n[0] + 1) * (n[1] + 1) * (n[2] + 1); }

/// Per i and j the number of k that are used.
struct UsedProducts {
    int counts[max_degree + 1][max_degree + 1] = {};
    int number = 0;  ///< of all
    explicit UsedProducts(const Degree& n);
};

/// (A x B x C) t: matrices along the three axes of a tensor whose last index is that of its columns. @param from sizes
CellTensor along_axes(const std::array<Eigen::MatrixXd, 3>& matrices, const CellTensor& t);
/// From values at the degree + 1 Chebyshev points to coefficients.
const Eigen::MatrixXd& chebyshev_coefficients(int degree);
/// The Chebyshev points of [-1, 1].
Eigen::VectorXd chebyshev_points(int degree);
/// T_0 .. T_degree at x, a row per point.
Eigen::MatrixXd chebyshev_values(int degree, const Eigen::VectorXd& x);
/// Sets what is not used to zero.
void keep_used(const Degree& n, CellTensor& t);

/// T_i and their derivatives at a tile of points.
struct ChebyshevTile {
    double value[3][max_degree + 1][tile], slope[3][max_degree + 1][tile];

    template <bool slopes>
    STRAKE_INLINE void set(const Tile& at, const Degree& n, const Eigen::Vector3d& middle,
                           const Eigen::Vector3d& half) {
        for (int axis = 0; axis < 3; ++axis)
            for (int p = 0; p < tile; p += 4) {
                const double scale = 1 / half[axis];
                const Four x = (four(at.x[axis] + p).lanes - middle[axis]) * scale;
                Four before = x * 0 + 1, now = x, d_before = x * 0, d_now = d_before + scale;
                four(value[axis][0] + p).lanes = before;
                if (slopes) four(slope[axis][0] + p).lanes = d_before;
                for (int i = 1; i <= n[axis]; ++i) {
                    four(value[axis][i] + p).lanes = now;
                    const Four next = 2 * x * now - before;
                    if (slopes) {
                        four(slope[axis][i] + p).lanes = d_now;
                        const Four d_next = 2 * scale * now + 2 * x * d_now - d_before;
                        d_before = d_now, d_now = d_next;
                    }
                    before = now, now = next;
                }
            }
    }
};

/// Coefficients that are used, those of a product together, and then two of zero.
std::vector<double> packed(const Degree& n, const UsedProducts& used, const CellTensor& t);

/// Adds the polynomial's values at points p .. p + 3 of the tile; of p + 4 .. p + 7, too.
STRAKE_INLINE void add_polynomial(const ChebyshevTile& at, int p, const Degree& n, const UsedProducts& used,
                                  const double* coefficient, Four (&sums)[3][2]) {
    for (int i = 0; i <= n[0]; ++i) {
        Four outer[3][2] = {};
        for (int j = 0; j <= n[1] && used.counts[i][j] > 0; ++j) {
            Four inner[3][2] = {};
            for (int k = 0; k < used.counts[i][j]; ++k, coefficient += 3) {
                const Four first = four(at.value[2][k] + p).lanes, second = four(at.value[2][k] + p + 4).lanes;
#pragma GCC unroll 3
                for (int c = 0; c < 3; ++c) {
                    inner[c][0] += first * coefficient[c];
                    inner[c][1] += second * coefficient[c];
                }
            }
            const Four first = four(at.value[1][j] + p).lanes, second = four(at.value[1][j] + p + 4).lanes;
#pragma GCC unroll 3
            for (int c = 0; c < 3; ++c) outer[c][0] += first * inner[c][0], outer[c][1] += second * inner[c][1];
        }
        const Four first = four(at.value[0][i] + p).lanes, second = four(at.value[0][i] + p + 4).lanes;
#pragma GCC unroll 3
        for (int c = 0; c < 3; ++c) sums[c][0] += first * outer[c][0], sums[c][1] += second * outer[c][1];
    }
}

/// Adds the derivatives of value c by axis k to sums[c][k], at points p .. p + 3.
STRAKE_INLINE void add_polynomial_slopes(const ChebyshevTile& at, int p, const Degree& n, const UsedProducts& used,
                                         const double* coefficient, Four (&sums)[3][3]) {
    for (int i = 0; i <= n[0]; ++i) {
        Four outer[3][3] = {};  // the value, by the second and by the third axis
        for (int j = 0; j <= n[1] && used.counts[i][j] > 0; ++j) {
            Four inner[3][2] = {};
            for (int k = 0; k < used.counts[i][j]; ++k, coefficient += 3) {
                const Four value = four(at.value[2][k] + p).lanes, slope = four(at.slope[2][k] + p).lanes;
#pragma GCC unroll 3
                for (int c = 0; c < 3; ++c) {
                    inner[c][0] += value * coefficient[c];
                    inner[c][1] += slope * coefficient[c];
                }
            }
            const Four value = four(at.value[1][j] + p).lanes, slope = four(at.slope[1][j] + p).lanes;
#pragma GCC unroll 3
            for (int c = 0; c < 3; ++c) {
                outer[c][0] += value * inner[c][0];
                outer[c][1] += slope * inner[c][0];
                outer[c][2] += value * inner[c][1];
            }
        }
        const Four value = four(at.value[0][i] + p).lanes, slope = four(at.slope[0][i] + p).lanes;
#pragma GCC unroll 3
        for (int c = 0; c < 3; ++c) {
            sums[c][0] += slope * outer[c][0];
            sums[c][1] += value * outer[c][1];
            sums[c][2] += value * outer[c][2];
        }
    }
}

/// Adds to `sums` (used products, padded to a multiple of four, x columns) those of the products with `values`, rows
/// of the points of the tile.
STRAKE_INLINE void add_polynomial_transpose(const ChebyshevTile& at, int points, const Degree& n,
                                            const UsedProducts& used, const double* values, Eigen::Index stride,
                                            Eigen::MatrixXd& sums) {
    double columns[tall * tile];
    Eigen::Index filled = 0, done = 0;
    const auto flush = [&]() __attribute__((always_inline)) {
        for (Eigen::Index c = 0; c < sums.cols(); c += broad)
            add_products(columns, tile, values + c * stride, stride, points,
                         sums.data() + c * sums.outerStride() + done, sums.outerStride());
        done += tall;
        filled = 0;
    };
    for (int i = 0; i <= n[0]; ++i)
        for (int j = 0; j <= n[1] && used.counts[i][j] > 0; ++j)
            for (int k = 0; k < used.counts[i][j]; ++k) {
                double* column = columns + filled * tile;
                for (int p = 0; p < points; p += 4)
                    four(column + p).lanes = four(at.value[0][i] + p).lanes * four(at.value[1][j] + p).lanes *
                                             four(at.value[2][k] + p).lanes;
                if (++filled == tall) flush();
            }
    if (filled == 0) return;
    for (; filled < tall; ++filled) std::fill_n(columns + filled * tile, tile, 0.0);
    flush();
}

}  // namespace strake
