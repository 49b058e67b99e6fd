#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <functional>

namespace strake {

/// Order of the Taylor remainder of J at x along p between the steps h and h/10: 2 if g is the gradient, 1 if it is
/// not.
inline double taylor_order(const std::function<double(const Eigen::VectorXd&)>& J, const Eigen::VectorXd& x,
                           const Eigen::VectorXd& g, const Eigen::VectorXd& p, double h = 1e-2) {
    const double J0 = J(x);
    const auto remainder = [&](double s) { return std::abs(J(x + s * p) - J0 - s * g.dot(p)); };
    return std::log10(remainder(h) / remainder(h / 10));
}

/// Entries in [-1, 1] from a stated seed, the same on every platform.
inline Eigen::VectorXd random_vector(Eigen::Index size, unsigned seed) {
    std::uint64_t state = seed * 0x9E3779B97F4A7C15ull + 0x632BE59BD9B4E019ull;
    Eigen::VectorXd v(size);
    for (Eigen::Index i = 0; i < size; ++i) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        v[i] = static_cast<double>(state >> 11) * 0x1p-52 - 1.0;
    }
    return v;
}

}  // namespace strake
