#include "optimize/evaluate/fold_conditions.hpp"

#include "core/fields/displacement_fields.hpp"
#include "core/planform/kept_sections.hpp"

#include <algorithm>

namespace strake {
namespace {

constexpr std::size_t max_conditions = 24;
constexpr double spread = 0.03;         ///< diagonals: triangles closer than this say the same
constexpr double planform_step = 1e-3;  ///< of a range: maps of wings are known to 1e-9, and curved over their range

using Maps = std::vector<Eigen::Matrix3d>;

/// What the guard judges: by fields and planform together.
Maps maps_at(const DesignSpace& space, const Eigen::VectorXd& x) { return local_maps(*space.rest, demand(space, x)); }

/// d(det F)/dF, also where F is singular.
Eigen::Matrix3d cofactors(const Eigen::Matrix3d& F) {
    Eigen::Matrix3d result;
    for (int k = 0; k < 3; ++k) result.row(k) = F.row((k + 1) % 3).cross(F.row((k + 2) % 3));
    return result;
}

Eigen::RowVector3d middle_of(const TriMesh& mesh, int t) {
    return mesh.vertices(mesh.triangles.row(t), Eigen::all).colwise().mean();
}

/// Triangles, and the maps there.
struct Chosen {
    std::vector<std::size_t> triangles;
    Maps maps;
};

/// Triangles of least determinant below `below`, spread over the surface.
Chosen chosen_triangles(const RestFacts& rest, const Maps& maps, double below) {
    std::vector<std::pair<double, std::size_t>> low;
    for (std::size_t t = 0; t < maps.size(); ++t)
        if (const double determinant = maps[t].determinant(); determinant < below) low.emplace_back(determinant, t);
    // Triangles that are alike but for rounding are taken in their order.
    const auto steps = [](double determinant) { return std::round(determinant * 1e9); };
    std::ranges::stable_sort(low, {}, [&](const auto& entry) { return steps(entry.first); });
    Chosen chosen;
    for (const auto& [determinant, t] : low) {
        if (chosen.triangles.size() == max_conditions) break;
        const Eigen::RowVector3d middle = middle_of(rest.surface, static_cast<int>(t));
        if (std::ranges::any_of(chosen.triangles, [&](std::size_t other) {
                return (middle_of(rest.surface, static_cast<int>(other)) - middle).norm() < spread * rest.diagonal;
            }))
            continue;
        chosen.triangles.push_back(t);
        chosen.maps.push_back(maps[t]);
    }
    return chosen;
}

/// Derivatives by changes of wings, whose maps have none in closed form.
void add_planform_slopes(const DesignSpace& space, const Eigen::VectorXd& x, const std::vector<std::size_t>& triangles,
                         Eigen::MatrixXd& slopes) {
    for (int j = 0; j < space.num_shape(); ++j) {
        if (space.variables[static_cast<std::size_t>(j)].kind != VariableKind::planform) continue;
        Eigen::VectorXd low = x, high = x;
        const double step = planform_step * (space.upper[j] - space.lower[j]);
        low[j] -= step, high[j] += step;
        const Maps below = maps_at(space, low), above = maps_at(space, high);
        for (std::size_t i = 0; i < triangles.size(); ++i)
            slopes(static_cast<Eigen::Index>(i), j) =
                -(above[triangles[i]].determinant() - below[triangles[i]].determinant()) / (2 * step);
    }
}

/// dJ/d(values of the fields) by that of the map of a triangle.
Eigen::VectorXd by_fields(const DesignSpace& space, int triangle, const Eigen::Matrix3d& dJ_dF) {
    const auto& fields = space.rest->parameters.fields;
    const auto& kept = space.rest->parameters.kept_sections;
    if (!kept) return fields->map_gradient(triangle, dJ_dF);
    Points by_motion;
    const Eigen::Matrix3d by_map = kept->pull_map(triangle, dJ_dF, by_motion);
    return fields->map_gradient(triangle, by_map) + fields->gradient(by_motion);
}

/// To first order at x, where these are the maps.
FoldConditions linearised(const DesignSpace& space, const Eigen::VectorXd& x, const Chosen& chosen) {
    FoldConditions at;
    at.values.resize(static_cast<Eigen::Index>(chosen.triangles.size()));
    at.slopes.resize(at.values.size(), space.size());
    for (Eigen::Index i = 0; i < at.values.size(); ++i) {
        const auto t = static_cast<int>(chosen.triangles[static_cast<std::size_t>(i)]);
        const Eigen::Matrix3d& map = chosen.maps[static_cast<std::size_t>(i)];
        at.values[i] = wanted_determinant - map.determinant();
        at.slopes.row(i) = design_gradient_of_fields(space, by_fields(space, t, -cofactors(map)));
    }
    if (!chosen.triangles.empty()) add_planform_slopes(space, x, chosen.triangles, at.slopes);
    return at;
}

}  // namespace

/// Of a surface in a wrap the part of the map that fields and planform are: the whole of it where patches do nothing.
bool may_fold(const DesignSpace& space) {
    return (!space.rest->has_shell || space.rest->wrap) && space.rest->parameters.fields;
}

bool is_folded(const DesignSpace& space, const Eigen::VectorXd& x, double determinant) {
    return may_fold(space) && std::ranges::any_of(maps_at(space, x), [&](const Eigen::Matrix3d& F) {
               return !(F.determinant() >= determinant);
           });
}

FoldConditions fold_conditions(const DesignSpace& space, const Eigen::VectorXd& x, double below) {
    if (!may_fold(space)) return {};
    FoldConditions at = linearised(space, x, chosen_triangles(*space.rest, maps_at(space, x), below));
    // Between what designs keep and what steps aim at is not beyond the limit.
    for (double& value : at.values)
        if (value <= wanted_determinant - kept_determinant) value = std::min(value, 0.0);
    return at;
}

FoldConditions fold_conditions_between(const DesignSpace& space, const Eigen::VectorXd& from,
                                       const Eigen::VectorXd& to) {
    const Eigen::VectorXd step = to - from;
    if (!may_fold(space) || step.isZero(0)) return {};
    // One after the other: maps of millions of triangles are more than the surface.
    const Chosen chosen = chosen_triangles(*space.rest, maps_at(space, to), wanted_determinant);
    FoldConditions at = linearised(space, to, chosen);
    if (chosen.triangles.empty()) return at;
    const Maps before = maps_at(space, from);
    for (Eigen::Index i = 0; i < at.values.size(); ++i) {
        const double end = at.values[i];
        at.values[i] =
            std::min(0.0, wanted_determinant - before[chosen.triangles[static_cast<std::size_t>(i)]].determinant());
        at.slopes.row(i) += (end - at.values[i] - at.slopes.row(i).dot(step)) / step.squaredNorm() * step.transpose();
    }
    return at;
}

}  // namespace strake
