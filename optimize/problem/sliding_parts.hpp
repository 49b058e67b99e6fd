#pragma once
#include "core/planform/planform_motion.hpp"
#include "optimize/problem/shell_setup.hpp"

#include <numeric>

namespace strake {

/// Triangles that move otherwise than what they pierce: of attached parts, and those that changes of wings move. With
/// displacement fields all of them: parts that pierce each other move by one map of space, but their triangles are
/// flat, and the shell bends each part by itself. Of two connected parts that pierce each other at the start, one of
/// them with such a triangle, the cut may wander (`ValidityOptions::attached`).
inline std::vector<int> sliding_triangles(const Problem& problem) {
    std::vector<int> all = attached_triangles(problem);
    if (problem.parameters.fields && problem.has_shell) {
        all.resize(static_cast<std::size_t>(problem.surface.num_triangles()));
        std::iota(all.begin(), all.end(), 0);
        return all;
    }
    if (!problem.parameters.planform) return all;
    const PlanformMotion& planform = *problem.parameters.planform;
    const Eigen::VectorXd start = Eigen::VectorXd::Zero(planform.size());
    std::vector<char> moves(static_cast<std::size_t>(problem.surface.num_vertices()), 0);
    for (int j = 0; j < planform.size(); ++j) {
        const Points rate = planform.derivative(start, j);
        for (std::size_t v = 0; v < moves.size(); ++v)
            if (!rate.row(static_cast<Eigen::Index>(v)).isZero(0)) moves[v] = 1;
    }
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        for (const int v : problem.surface.triangles.row(t))
            if (moves[static_cast<std::size_t>(v)]) {
                all.push_back(t);
                break;
            }
    return all;
}

}  // namespace strake
