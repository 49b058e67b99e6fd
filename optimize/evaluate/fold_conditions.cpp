#include "optimize/evaluate/fold_conditions.hpp"

#include "core/fields/displacement_fields.hpp"

#include <algorithm>

namespace strake {
namespace {

constexpr std::size_t most_conditions = 24;
constexpr double spread = 0.03;  ///< diagonals: triangles closer than this say the same

std::vector<Eigen::Matrix3d> maps_at(const DesignSpace& space, const Eigen::VectorXd& x) {
    return space.rest->parameters.fields->local_maps(demand(space, x).fields);
}

/// d(det F)/dF, also where F is singular.
Eigen::Matrix3d cofactors(const Eigen::Matrix3d& F) {
    Eigen::Matrix3d result;
    for (int k = 0; k < 3; ++k) result.row(k) = F.row((k + 1) % 3).cross(F.row((k + 2) % 3));
    return result;
}

Eigen::RowVector3d middle_of(const TriMesh& mesh, int t) {
    return mesh.vertices(mesh.triangles.row(t), Eigen::all).colwise().mean();
}

}  // namespace

bool may_fold(const DesignSpace& space) { return !space.rest->has_shell && space.rest->parameters.fields; }

bool is_folded(const DesignSpace& space, const Eigen::VectorXd& x, double determinant) {
    return may_fold(space) && std::ranges::any_of(maps_at(space, x), [&](const Eigen::Matrix3d& F) {
               return !(F.determinant() >= determinant);
           });
}

FoldConditions fold_conditions(const DesignSpace& space, const Eigen::VectorXd& x, double below) {
    FoldConditions at;
    if (!may_fold(space)) return at;
    const RestFacts& rest = *space.rest;
    const std::vector<Eigen::Matrix3d> maps = maps_at(space, x);
    std::vector<std::pair<double, int>> low;
    for (std::size_t t = 0; t < maps.size(); ++t)
        if (const double determinant = maps[t].determinant(); determinant < below)
            low.emplace_back(determinant, static_cast<int>(t));
    // Triangles that are alike but for rounding are taken in their order.
    const auto steps = [](double determinant) { return std::round(determinant * 1e9); };
    std::ranges::stable_sort(low, {}, [&](const auto& entry) { return steps(entry.first); });
    std::vector<std::pair<double, int>> chosen;
    for (const auto& entry : low) {
        if (chosen.size() == most_conditions) break;
        const Eigen::RowVector3d middle = middle_of(rest.surface, entry.second);
        if (std::ranges::none_of(chosen, [&](const auto& other) {
                return (middle_of(rest.surface, other.second) - middle).norm() < spread * rest.diagonal;
            }))
            chosen.push_back(entry);
    }
    at.values.resize(static_cast<Eigen::Index>(chosen.size()));
    at.slopes.resize(at.values.size(), x.size());
    for (Eigen::Index i = 0; i < at.values.size(); ++i) {
        const auto& [determinant, t] = chosen[static_cast<std::size_t>(i)];
        at.values[i] = wanted_determinant - determinant;
        const Eigen::Matrix3d by_map = -cofactors(maps[static_cast<std::size_t>(t)]);
        at.slopes.row(i) = design_gradient_of_fields(space, rest.parameters.fields->map_gradient(t, by_map));
    }
    return at;
}

}  // namespace strake
