#include "optimize/space/null_directions.hpp"

#include "core/error.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Dependence dependence(const MatrixXd& responses) {
    const Eigen::Index n = responses.cols();
    Dependence result;
    const VectorXd size = responses.colwise().norm().transpose();
    MatrixXd unit = responses;
    for (Eigen::Index j = 0; j < n; ++j)
        if (size[j] > 0) unit.col(j) /= size[j];
    const MatrixXd gram = unit.transpose() * unit;
    // Cholesky's algorithm row by row; a row whose pivot vanishes is dropped.
    MatrixXd factor = MatrixXd::Zero(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
        if (!(size[j] > 0)) {
            result.kept.push_back(static_cast<int>(j));
            result.own.push_back(1);
            continue;
        }
        double pivot = gram(j, j);
        Eigen::Index column = 0;
        for (const int k : result.kept) {
            if (size[k] > 0) {
                const double entry =
                    (gram(j, k) - factor.row(j).head(column).dot(factor.row(k).head(column))) / factor(k, column);
                factor(j, column) = entry;
                pivot -= entry * entry;
                ++column;
            }
        }
        if (pivot > null_share * null_share) {
            factor(j, column) = std::sqrt(pivot);
            result.own.push_back(std::min(1.0, factor(j, column)));
            result.kept.push_back(static_cast<int>(j));
        } else {
            factor.row(j).setZero();
            result.dependent.push_back(static_cast<int>(j));
        }
    }
    if (result.dependent.empty()) return result;
    const MatrixXd basis = unit(Eigen::all, result.kept);
    MatrixXd kept_gram = basis.transpose() * basis;
    for (std::size_t i = 0; i < result.kept.size(); ++i)
        if (!(size[result.kept[i]] > 0))
            kept_gram(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) = 1;  // without a response
    result.share = kept_gram.llt().solve(basis.transpose() * unit(Eigen::all, result.dependent));
    for (std::size_t i = 0; i < result.kept.size(); ++i)
        for (std::size_t d = 0; d < result.dependent.size(); ++d) {
            double& share = result.share(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(d));
            const double of = size[result.kept[i]];
            share = of > 0 && std::abs(share) > 1e-9 ? share * size[result.dependent[d]] / of : 0;
        }
    return result;
}

namespace {

/// "a", or "a and b", or "a, b and 3 more", those with the largest shares.
std::string main_names(const DesignSpace& space, const VectorXd& share) {
    std::vector<int> order;
    for (int j = 0; j < share.size(); ++j)
        if (std::abs(share[j]) > 1e-3 * share.cwiseAbs().maxCoeff()) order.push_back(j);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return std::abs(share[a]) > std::abs(share[b]); });
    const std::size_t shown = order.size() > 3 ? 2 : order.size();
    std::string words;
    for (std::size_t i = 0; i < shown; ++i)
        words += text(i == 0 ? "" : i + 1 == order.size() ? " and " : ", ", space.variables[order[i]].name);
    return order.size() > shown ? text(words, " and ", order.size() - shown, " more") : words;
}

}  // namespace

std::string null_words(const DesignSpace& space) {
    constexpr std::size_t max_shown = 3;
    const std::size_t count = space.dependent.size();
    std::string words;
    for (std::size_t i = 0; i < std::min(count, max_shown); ++i)
        words += text(i == 0 ? "" : ", ", space.dependent[i].variable.name, " does what ",
                      main_names(space, space.dependent[i].share), " can do");
    return text(count, " of ", space.variables.size() + count, count == 1 ? " directions moves" : " directions move",
                " the surface by less than ", null_share, " of max_displacement and ", count == 1 ? "is" : "are",
                " dropped: ", words, count > max_shown ? ", ..." : "");
}

std::string weak_words(const DesignSpace& space, double least) {
    constexpr std::size_t max_shown = 3;
    const std::size_t count = space.weak.size();
    std::string words;
    for (std::size_t i = 0; i < std::min(count, max_shown); ++i) words += (i == 0 ? "" : ", ") + space.weak[i];
    return text(count, " of ", space.size(), count == 1 ? " variables does" : " variables do",
                " nearly what others can do, but for ", least, " of the motion or more: ", words,
                count > max_shown ? ", ..." : "");
}

}  // namespace strake
