#include "core/fields/function_sum.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace strake {

using Eigen::Matrix3d;
using Eigen::Vector3d;

int FunctionSpace::linear_axis(const Powers& p) const {
    if (wing) return p[0] < 0 ? -1 - p[0] : -1;
    const auto& [i, j, k] = p;
    if (i + j + k != 1) return -1;
    return i == 1 ? 0 : j == 1 ? 1 : 2;
}

Powers FunctionSpace::linear(int axis) const {
    Powers p{0, 0, 0};
    if (wing)
        p[0] = -1 - axis;
    else
        p[static_cast<std::size_t>(axis)] = 1;
    return p;
}

bool FunctionSpace::is_odd(const Powers& p) const {
    if (wing) return p[0] > 0 || linear_axis(p) == frame.plane_axis;
    return p[static_cast<std::size_t>(frame.plane_axis)] % 2 == 1;
}

LocalFunctions::LocalFunctions(const FunctionSpace& space) : space_(space) {
    if (space.wing) {
        of_wing_.emplace(*space.wing, space.frame, space.powers);
        return;
    }
    std::array<int, 3> last{0, 0, 0};
    for (const Powers& p : space.powers)
        for (int k = 0; k < 3; ++k) last[k] = std::max(last[k], p[k]);
    for (int k = 0; k < 3; ++k) along_.emplace_back(k == 0 ? space.along : AlongAxis::polynomials, 0, last[k]);
}

void LocalFunctions::set(const Vector3d& x) {
    if (of_wing_) return of_wing_->set(x);
    const Vector3d at = space_.frame.local(x);
    for (int k = 0; k < 3; ++k) along_[k].set(at[k]);
}

double LocalFunctions::value(const Powers& p) const {
    if (of_wing_) return of_wing_->value(p);
    return along_[0].value[p[0]] * along_[1].value[p[1]] * along_[2].value[p[2]];
}

double LocalFunctions::slope(const Powers& p, int k) const {
    if (of_wing_) return of_wing_->gradient(p).dot(space_.frame.axes.col(k));
    double product = space_.frame.half[k] > 0 ? 1 / space_.frame.half[k] : 0;
    for (int i = 0; i < 3; ++i) product *= i == k ? along_[i].slope[p[i]] : along_[i].value[p[i]];
    return product;
}

FunctionSum::FunctionSum(const FunctionSpace& space, const Coefficients& c) : space_(space) {
    if (space.wing) {
        std::vector<Powers> used;
        for (const std::size_t f : used_functions(c)) {
            terms_.emplace_back(space.powers[f], c.row(static_cast<Eigen::Index>(f)));
            used.push_back(space.powers[f]);
        }
        of_wing_.emplace(*space.wing, space.frame, used);
        return;
    }
    std::array<int, 3> last{0, 0, 0};
    std::map<std::pair<int, int>, std::vector<std::size_t>> across;
    for (const std::size_t f : used_functions(c)) {
        for (int k = 0; k < 3; ++k) last[k] = std::max(last[k], space.powers[f][k]);
        across[{space.powers[f][1], space.powers[f][2]}].push_back(f);
    }
    for (int k = 0; k < 3; ++k)
        along_.emplace_back(k == 0 ? space.along : AlongAxis::polynomials, 0, last[static_cast<std::size_t>(k)]);
    for (const auto& [number, functions] : across) {
        Group group{number.first, number.second, {}, Eigen::Matrix3Xd(3, functions.size())};
        for (std::size_t i = 0; i < functions.size(); ++i) {
            group.along.push_back(space.powers[functions[i]][0]);
            group.factor.col(static_cast<Eigen::Index>(i)) = c.row(static_cast<Eigen::Index>(functions[i]));
        }
        groups_.push_back(std::move(group));
    }
}

void FunctionSum::at(const Vector3d& x, Vector3d& value, Matrix3d& by_local) {
    if (of_wing_) return at_wing(x, value, by_local);
    const Vector3d local = space_.frame.local(x);
    for (int k = 0; k < 3; ++k) along_[static_cast<std::size_t>(k)].set(local[k]);
    value.setZero();
    by_local.setZero();
    const auto &first = along_[0], &second = along_[1], &third = along_[2];
    for (const Group& group : groups_) {
        Vector3d sum = Vector3d::Zero(), slope = Vector3d::Zero();
        for (std::size_t i = 0; i < group.along.size(); ++i) {
            const auto number = static_cast<std::size_t>(group.along[i]);
            const auto factor = group.factor.col(static_cast<Eigen::Index>(i));
            sum += first.value[number] * factor;
            slope += first.slope[number] * factor;
        }
        const auto j = static_cast<std::size_t>(group.second), k = static_cast<std::size_t>(group.third);
        value += second.value[j] * third.value[k] * sum;
        by_local.col(0) += second.value[j] * third.value[k] * slope;
        by_local.col(1) += second.slope[j] * third.value[k] * sum;
        by_local.col(2) += second.value[j] * third.slope[k] * sum;
    }
    for (int k = 0; k < 3; ++k) by_local.col(k) *= space_.frame.half[k] > 0 ? 1 / space_.frame.half[k] : 0;
}

void FunctionSum::at_wing(const Vector3d& x, Vector3d& value, Matrix3d& by_local) {
    of_wing_->set(x);
    value.setZero();
    Matrix3d gradient = Matrix3d::Zero();
    for (const auto& [number, factor] : terms_) {
        value += of_wing_->value(number) * factor;
        gradient += factor * of_wing_->gradient(number).transpose();
    }
    by_local = gradient * space_.frame.axes;
}

}  // namespace strake
