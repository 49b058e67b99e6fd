#include "optimize/least_squares/robust.hpp"

#include <cmath>

namespace strake {
namespace {

constexpr double as_good_as_zero = 1e-8;  ///< of s/a^2: there phi is its Taylor series at zero

/// phi and dphi/ds.
std::array<double, 2> factor(Loss loss, double scale, double s) {
    if (s <= as_good_as_zero * scale * scale) {
        const double curvature = robust_loss(loss, scale, 0)[2];
        return {1 + curvature * s / 4, curvature / 4};
    }
    const auto [rho, first, second] = robust_loss(loss, scale, s);
    const double phi = std::sqrt(rho / s);
    return {phi, (first * s - rho) / (2 * s * s * phi)};
}

}  // namespace

std::array<double, 3> robust_loss(Loss loss, double scale, double squared_distance) {
    const double s = squared_distance, square = scale * scale;
    // In this form nothing cancels at small distances; Ceres' own losses do.
    switch (loss) {
        case Loss::none:
            break;
        case Loss::huber:
            if (s <= square) break;
            return {2 * scale * std::sqrt(s) - square, scale / std::sqrt(s), -scale / (2 * s * std::sqrt(s))};
        case Loss::cauchy: {
            const double inlier = 1 / (1 + s / square);
            return {square * std::log1p(s / square), inlier, -inlier * inlier / square};
        }
        case Loss::soft_l1: {
            const double root = std::sqrt(1 + s / square);
            return {2 * s / (root + 1), 1 / root, -1 / (2 * square * root * root * root)};
        }
    }
    return {s, 1, 0};
}

Residuals robust(Loss loss, double scale, Residuals residuals) {
    if (loss == Loss::none) return residuals;
    const Eigen::Index points = residuals.weight.size();
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd f = residuals.r;
    for (Eigen::Index i = 0; i < points; ++i) {
        const auto r = residuals.r.segment(i * residuals.width, residuals.width);
        const double weight = residuals.weight[i];
        const auto [phi, slope] =
            weight > 0 ? factor(loss, scale, r.squaredNorm() / weight) : std::array<double, 2>{1, 0};
        for (int k = 0; k < residuals.width; ++k)
            for (int l = 0; l < residuals.width; ++l) {
                const double curved = weight > 0 ? 2 * slope / weight * r[k] * r[l] : 0;
                entries.emplace_back(i * residuals.width + k, i * residuals.width + l, (k == l ? phi : 0) + curved);
            }
        f.segment(i * residuals.width, residuals.width) *= phi;
    }
    Eigen::SparseMatrix<double, Eigen::RowMajor> df_dr(f.size(), f.size());
    df_dr.setFromTriplets(entries.begin(), entries.end());
    residuals.dr_dv = (df_dr * residuals.dr_dv).eval();
    residuals.r = std::move(f);
    return residuals;
}

}  // namespace strake
