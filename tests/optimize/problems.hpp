#pragma once
#include "core/mesh/geometry.hpp"
#include "derivatives.hpp"
#include "objectives/fit/target_shape.hpp"
#include "objectives/geometry/measures.hpp"
#include "optimize/problem/problem.hpp"
#include "surfaces.hpp"

#include <map>

/// Small problems for the tests of optimize/, with patches that need no segmentation.
namespace strake {

/// A level whose patches are the triangles of equal `key` (numbered by their smallest triangle) within `parent`.
inline PatchLevel level_by(const TriMesh& mesh, const PatchLevel* parent, const std::function<int(int t)>& key) {
    const Eigen::VectorXd area = triangle_areas(mesh);
    PatchLevel level;
    std::map<std::pair<int, int>, int> number;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const int above = parent ? parent->label[t] : 0;
        const auto [at, fresh] = number.try_emplace({above, key(t)}, static_cast<int>(level.patches.size()));
        if (fresh) {
            Patch patch;
            patch.id = at->second;
            patch.parent = parent ? above : -1;
            patch.name = parent ? parent->patches[above].name + ".p" : "p";
            patch.name += std::to_string(key(t));
            level.patches.push_back(patch);
        }
        level.patches[at->second].triangles.push_back(t);
        level.patches[at->second].area += area[t];
        level.label.push_back(at->second);
    }
    return level;
}

/// Halves along x, then quadrants with y, then octants with z.
inline PatchHierarchy octants(const TriMesh& mesh, int levels) {
    const Points c = triangle_centroids(mesh);
    PatchHierarchy tree;
    tree.levels.push_back(level_by(mesh, nullptr, [](int) { return 0; }));
    for (int k = 1; k <= levels; ++k)
        tree.levels.push_back(
            level_by(mesh, &tree.levels.back(), [&, k](int t) { return c(t, k - 1) > 1e-9 ? 1 : 0; }));
    return tree;
}

/// An ellipsoid that is fixed at its -x end, with `levels` levels of halves.
inline Problem ellipsoid_problem(int subdivisions, int levels, double size = 1) {
    Problem problem;
    problem.name = "ellipsoid";
    problem.surface = ellipsoid(size * Eigen::Vector3d(1, 0.6, 0.4), subdivisions);
    problem.tree = octants(problem.surface, levels);
    problem.prism_height =
        Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.05 * box_diagonal(problem.surface));
    const Points c = triangle_centroids(problem.surface);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (c(t, 0) < -0.75 * size) problem.fixed.push_back(t);
    problem.quantities = {volume(problem.surface), area()};
    return problem;
}

/// Asks for as much volume as `area` times the present area can hold.
inline void maximize_volume(Problem& problem, double area = 1.02) {
    problem.objective = "volume";
    problem.maximize = true;
    Constraint limit;
    limit.quantity = "area";
    limit.max = area;
    limit.relative = true;
    problem.constraints = {limit};
}

}  // namespace strake
