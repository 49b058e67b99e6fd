#include "core/primo/block_matrix.hpp"

#include <algorithm>

namespace strake {

int BlockMatrix::find(int a, int b) const {
    const int column = std::min(a, b), wanted = std::max(a, b);
    const auto first = row.begin() + begin[column], last = row.begin() + begin[column + 1];
    return static_cast<int>(std::lower_bound(first, last, wanted) - row.begin());
}

Eigen::VectorXd BlockMatrix::multiply(const Eigen::VectorXd& x) const {
    Eigen::VectorXd y(x.size());
    for (int j = 0; j < size(); ++j) y.segment<6>(6 * j).noalias() = diagonal[j] * x.segment<6>(6 * j);
    for (int j = 0; j < size(); ++j)
        for (int k = begin[j]; k < begin[j + 1]; ++k) {
            y.segment<6>(6 * row[k]).noalias() += below[k] * x.segment<6>(6 * j);
            y.segment<6>(6 * j).noalias() += below[k].transpose() * x.segment<6>(6 * row[k]);
        }
    return y;
}

BlockMatrix block_matrix(int size, const std::vector<std::pair<int, int>>& pairs) {
    std::vector<std::pair<int, int>> places;
    places.reserve(pairs.size());
    for (const auto& [a, b] : pairs)
        if (a != b) places.emplace_back(std::min(a, b), std::max(a, b));
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    BlockMatrix matrix;
    matrix.begin.assign(size + 1, 0);
    for (const auto& [column, row] : places) {
        ++matrix.begin[column + 1];
        matrix.row.push_back(row);
    }
    for (int j = 0; j < size; ++j) matrix.begin[j + 1] += matrix.begin[j];
    matrix.diagonal.assign(size, Matrix6::Zero());
    matrix.below.assign(places.size(), Matrix6::Zero());
    return matrix;
}

}  // namespace strake
