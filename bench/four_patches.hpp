#pragma once
#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "core/wrap/wrap_map.hpp"
#include "objectives/geometry/measures.hpp"
#include "optimize/evaluate/evaluation.hpp"

#include <memory>
#include <utility>

namespace strake {

/// For the benchmarks of wraps: volume and area of a closed body by loads on four patches of its own surface, or of the
/// wrap where there is one; one triangle is held.
inline Problem four_patches(TriMesh surface, std::shared_ptr<const WrapMap> wrap) {
    Problem problem;
    problem.surface = std::move(surface);
    problem.wrap = std::move(wrap);
    const TriMesh& elastic = elastic_surface(problem);
    AutomaticLevels levels;
    levels.patches_per_level = {4};
    problem.tree = segment_automatically(elastic, adjacency(elastic), levels);
    problem.prism_height = Eigen::VectorXd::Constant(elastic.num_vertices(), 0.02 * box_diagonal(elastic));
    (problem.wrap ? problem.supports : problem.fixed).push_back(elastic.num_triangles() / 2);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.quantities = {closed_volume(problem.surface), area(true)};
    return problem;
}

}  // namespace strake
