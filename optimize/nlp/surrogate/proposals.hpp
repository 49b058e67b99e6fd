#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>

/// Batches of a search by models: minima of the models' means, and what looks at what is not known yet. Internal.
namespace strake {

/// A point of a batch, and what the models expect there.
struct Proposal {
    Eigen::VectorXd x, z;
    double radius = 0;
    Eigen::VectorXd expected = {};  ///< values; empty before the first models
    bool restores = false;          ///< leads back to limits, and says nothing of the trust region
};

/// At least one; more of them as points come to outnumber the terms of a linear model.
inline int minima_of_batch(int batch, int points, Eigen::Index dimensions) {
    constexpr double shares[] = {0.125, 0.25, 0.375};  // fewer points than terms, than twice as many, and after that
    const auto terms = static_cast<int>(dimensions) + 1;
    return std::max(1, static_cast<int>(std::lround(shares[std::min(points / terms, 2)] * batch)));
}

/// Of the region of the k-th, in radii of the trust region.
inline double radius_of_minimum(int k) {
    constexpr double radii[] = {1, 2, 0.5, 1.4, 0.7, 2.8, 0.35, 4};
    return radii[static_cast<std::size_t>(k) % std::size(radii)];
}

}  // namespace strake
