#pragma once
#include "core/mesh/mesh.hpp"
#include "core/wrap/add_products.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/// What sums of |x - x_c|^3 do with a tile of points: inlined where they run, with the machine's registers.
namespace strake {

using RadialWeights = Eigen::Matrix<double, Eigen::Dynamic, 3>;

constexpr int tile = 128;  ///< points whose coordinates, and distances from four centres, are in the cache

/// A square root is what most of a term waits for, and the compiler makes four calls of it.
STRAKE_INLINE void take_roots(Four& v) {
#if defined(__SSE2__)
    const __m128d low = _mm_sqrt_pd(__m128d{v[0], v[1]}), high = _mm_sqrt_pd(__m128d{v[2], v[3]});
    v = Four{low[0], low[1], high[0], high[1]};
#else
    v = Four{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
#endif
}

/// Coordinates of consecutive points, those of one axis together; what is left of a tile repeats its last point.
struct Tile {
    double x[3][tile];

    void load(const Points& at, Eigen::Index first, Eigen::Index count) {
        for (Eigen::Index p = 0; p < tile; ++p)
            for (int k = 0; k < 3; ++k) x[k][p] = at(first + std::min(p, count - 1), k);
    }
    static Eigen::Index padded(Eigen::Index count) { return (count + 3) / 4 * 4; }
};

struct Term {
    double at[3], weight[3];
};

inline std::vector<Term> terms(const Points& center, const RadialWeights& weights) {
    std::vector<Term> all(static_cast<std::size_t>(center.rows()));
    for (Eigen::Index c = 0; c < center.rows(); ++c)
        for (int k = 0; k < 3; ++k) {
            all[static_cast<std::size_t>(c)].at[k] = center(c, k);
            all[static_cast<std::size_t>(c)].weight[k] = weights(c, k);
        }
    return all;
}

STRAKE_INLINE void add_values(const Tile& tile_of, Eigen::Index p, const std::vector<Term>& all, Four (&sums)[3]) {
    const Four x = four(tile_of.x[0] + p).lanes, y = four(tile_of.x[1] + p).lanes, z = four(tile_of.x[2] + p).lanes;
    Four one{}, two{}, three{};
    for (const Term& term : all) {
        const Four dx = x - term.at[0], dy = y - term.at[1], dz = z - term.at[2], r2 = dx * dx + dy * dy + dz * dz;
        Four cube = r2;
        take_roots(cube);
        cube *= r2;
        one += cube * term.weight[0];
        two += cube * term.weight[1];
        three += cube * term.weight[2];
    }
    sums[0] = one, sums[1] = two, sums[2] = three;
}

STRAKE_INLINE void add_slopes(const Tile& tile_of, Eigen::Index p, const std::vector<Term>& all, Four (&sums)[3][3]) {
    const Four x = four(tile_of.x[0] + p).lanes, y = four(tile_of.x[1] + p).lanes, z = four(tile_of.x[2] + p).lanes;
    Four now[3][3] = {};
    for (const Term& term : all) {
        const Four dx = x - term.at[0], dy = y - term.at[1], dz = z - term.at[2];
        Four r = dx * dx + dy * dy + dz * dz;
        take_roots(r);
        const Four away[3] = {r * dx, r * dy, r * dz};
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i)
#pragma GCC unroll 3
            for (int j = 0; j < 3; ++j) now[i][j] += away[j] * term.weight[i];
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) sums[i][j] = 3 * now[i][j];
}

/// |x - x_c|^3 of a tile's points and four centres, a column each.
STRAKE_INLINE void cubes(const Tile& tile_of, Eigen::Index points, const Points& center, Eigen::Index first,
                         double* columns) {
    for (int i = 0; i < tall; ++i) {
        const Eigen::Index c = std::min(first + i, center.rows() - 1);
        const double cx = center(c, 0), cy = center(c, 1), cz = center(c, 2);
        for (Eigen::Index p = 0; p < points; p += 4) {
            const Four dx = four(tile_of.x[0] + p).lanes - cx, dy = four(tile_of.x[1] + p).lanes - cy,
                       dz = four(tile_of.x[2] + p).lanes - cz, r2 = dx * dx + dy * dy + dz * dz;
            Four r = r2;
            take_roots(r);
            four(columns + i * tile + p).lanes = r2 * r;
        }
    }
}

/// Of points begin..end; a multiple of four rows, of which those beyond the centres mean nothing.
STRAKE_INLINE void add_transpose(const Points& at, Eigen::Index begin, Eigen::Index end, const Points& center,
                                 const Eigen::MatrixXd& values, Eigen::MatrixXd& sums) {
    Tile now;
    double columns[tall * tile];
    for (Eigen::Index from = begin; from < end; from += tile) {
        const Eigen::Index count = std::min<Eigen::Index>(tile, end - from);
        now.load(at, from, count);
        for (Eigen::Index c = 0; c < sums.rows(); c += tall) {
            cubes(now, Tile::padded(count), center, c, columns);
            for (Eigen::Index j = 0; j < values.cols(); j += broad)
                add_products(columns, tile, values.data() + j * values.outerStride() + from, values.outerStride(),
                             count, sums.data() + j * sums.outerStride() + c, sums.outerStride());
        }
    }
}

}  // namespace strake
