#include "core/wrap/cell_polynomials.hpp"

#include <numbers>

namespace strake {

using Eigen::Index;
using Eigen::MatrixXd;

UsedProducts::UsedProducts(const Degree& n) {
    const auto square = [](int i, int of) { return of > 0 ? static_cast<double>(i * i) / (of * of) : 0.0; };
    constexpr double rounding = 1e-12;
    for (int i = 0; i <= n[0]; ++i)
        for (int j = 0; j <= n[1]; ++j)
            for (int k = 0; k <= n[2]; ++k)
                if (square(i, n[0]) + square(j, n[1]) + square(k, n[2]) <= 1 + rounding) counts[i][j] = k + 1, ++number;
}

CellTensor along_axes(const std::array<MatrixXd, 3>& matrices, const CellTensor& t) {
    using Map = Eigen::Map<CellTensor>;
    using ConstMap = Eigen::Map<const CellTensor>;
    const Index columns = t.cols(), x = matrices[0].cols(), y = matrices[1].cols(), z = matrices[2].cols(),
                y_out = matrices[1].rows(), z_out = matrices[2].rows(), x_out = matrices[0].rows();
    CellTensor along_z(x * y * z_out, columns), along_y(x * y_out * z_out, columns),
        along_x(x_out * y_out * z_out, columns);
    for (Index i = 0; i < x * y; ++i)
        Map(along_z.data() + i * z_out * columns, z_out, columns).noalias() =
            matrices[2] * ConstMap(t.data() + i * z * columns, z, columns);
    for (Index i = 0; i < x; ++i)
        Map(along_y.data() + i * y_out * z_out * columns, y_out, z_out * columns).noalias() =
            matrices[1] * ConstMap(along_z.data() + i * y * z_out * columns, y, z_out * columns);
    Map(along_x.data(), x_out, y_out * z_out * columns).noalias() =
        matrices[0] * ConstMap(along_y.data(), x, y_out * z_out * columns);
    return along_x;
}

Eigen::VectorXd chebyshev_points(int degree) {
    Eigen::VectorXd x(degree + 1);
    for (int m = 0; m <= degree; ++m) x[m] = std::cos(std::numbers::pi * (m + 0.5) / (degree + 1));
    return x;
}

MatrixXd chebyshev_values(int degree, const Eigen::VectorXd& x) {
    MatrixXd values(x.size(), degree + 1);
    values.col(0).setOnes();
    if (degree > 0) values.col(1) = x;
    for (int i = 2; i <= degree; ++i) values.col(i) = 2 * x.cwiseProduct(values.col(i - 1)) - values.col(i - 2);
    return values;
}

const MatrixXd& chebyshev_coefficients(int degree) {
    static const std::vector<MatrixXd> all = [] {
        std::vector<MatrixXd> matrices;
        for (int n = 0; n <= max_degree; ++n) {
            MatrixXd m = 2.0 / (n + 1) * chebyshev_values(n, chebyshev_points(n)).transpose();
            m.row(0) *= 0.5;
            matrices.push_back(std::move(m));
        }
        return matrices;
    }();
    return all[static_cast<std::size_t>(degree)];
}

void keep_used(const Degree& n, CellTensor& t) {
    const UsedProducts used(n);
    for (int i = 0; i <= n[0]; ++i)
        for (int j = 0; j <= n[1]; ++j)
            t.middleRows((static_cast<Index>(i) * (n[1] + 1) + j) * (n[2] + 1) + used.counts[i][j],
                         n[2] + 1 - used.counts[i][j])
                .setZero();
}

std::vector<double> packed(const Degree& n, const UsedProducts& used, const CellTensor& t) {
    std::vector<double> all;
    all.reserve(static_cast<std::size_t>(3 * used.number));
    for (int i = 0; i <= n[0]; ++i)
        for (int j = 0; j <= n[1]; ++j)
            for (int k = 0; k < used.counts[i][j]; ++k)
                for (int c = 0; c < 3; ++c)
                    all.push_back(t((static_cast<Index>(i) * (n[1] + 1) + j) * (n[2] + 1) + k, c));
    return all;
}

}  // namespace strake
