#include "core/wrap/radial_sums.hpp"

#include "core/parallel.hpp"
#include "core/wrap/radial_tiles.hpp"

namespace strake {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Weights = RadialWeights;

constexpr int block = tile;  ///< of a loop on several threads
constexpr int points_a_sum =
    16384;  ///< of the transpose: each so many have sums of their own, which are added in order

}  // namespace

Points cubic_sums(const Points& at, const Points& center, const Weights& weights) {
    const std::vector<Term> all = terms(center, weights);
    Points values(at.rows(), 3);
    for_blocks(static_cast<int>(at.rows()), block, [&](int begin, int end) {
        Tile now;
        now.load(at, begin, end - begin);
        run_lanes([&]() __attribute__((always_inline)) {
            for (Index p = 0; p < end - begin; p += 4) {
                Four sums[3];
                add_values(now, p, all, sums);
                for (Index i = 0; i < std::min<Index>(4, end - begin - p); ++i)
                    for (int k = 0; k < 3; ++k) values(begin + p + i, k) = sums[k][i];
            }
        });
    });
    return values;
}

std::vector<Eigen::Matrix3d> cubic_slopes(const Points& at, const Points& center, const Weights& weights) {
    const std::vector<Term> all = terms(center, weights);
    std::vector<Eigen::Matrix3d> slopes(static_cast<std::size_t>(at.rows()));
    for_blocks(static_cast<int>(at.rows()), block, [&](int begin, int end) {
        Tile now;
        now.load(at, begin, end - begin);
        run_lanes([&]() __attribute__((always_inline)) {
            for (Index p = 0; p < end - begin; p += 4) {
                Four sums[3][3];
                add_slopes(now, p, all, sums);
                for (Index n = 0; n < std::min<Index>(4, end - begin - p); ++n)
                    for (int i = 0; i < 3; ++i)
                        for (int j = 0; j < 3; ++j)
                            slopes[static_cast<std::size_t>(begin + p + n)](i, j) = sums[i][j][n];
            }
        });
    });
    return slopes;
}

MatrixXd cubic_sums_transpose(const Points& at, const Points& center, const MatrixXd& values) {
    const Index rows = (center.rows() + tall - 1) / tall * tall;
    const auto groups = static_cast<int>((at.rows() + points_a_sum - 1) / points_a_sum);
    std::vector<MatrixXd> parts(static_cast<std::size_t>(groups));
    for_blocks(groups, 1, [&](int begin, int end) {
        for (int g = begin; g < end; ++g) {
            MatrixXd& sums = parts[static_cast<std::size_t>(g)] = MatrixXd::Zero(rows, values.cols());
            const Index first = static_cast<Index>(g) * points_a_sum;
            run_lanes([&]() __attribute__((always_inline)) {
                add_transpose(at, first, std::min<Index>(first + points_a_sum, at.rows()), center, values, sums);
            });
        }
    });
    MatrixXd sums = MatrixXd::Zero(rows, values.cols());
    for (const MatrixXd& part : parts) sums += part;
    return sums.topRows(center.rows());
}

}  // namespace strake
