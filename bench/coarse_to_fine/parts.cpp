#include "bench/coarse_to_fine/parts.hpp"

#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "objectives/fit/target_shape.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake::evidence {

double smooth_step(double s) {
    s = std::clamp(s, 0.0, 1.0);
    return s * s * s * (10 + s * (-15 + 6 * s));
}

double soft_ramp(double s, double w) { return s > 30 * w ? s : w * std::log1p(std::exp(s / w)); }

double gauss(double distance, double w) { return std::exp(-distance * distance / (w * w)); }

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

EvidenceProblem start_of(const ProblemChoice& choice) {
    EvidenceProblem result;
    result.name = choice.name;
    result.what = choice.what;
    result.ends = choice.ends;
    Problem& p = result.problem;
    p.name = choice.name;
    p.surface = choice.surface;
    AutomaticLevels levels;
    levels.patches_per_level = choice.patches;
    p.tree = segment_automatically(p.surface, adjacency(p.surface), levels);
    p.prism_height = Eigen::VectorXd::Constant(p.surface.num_vertices(), choice.prism_height * box_diagonal(p.surface));
    const Points c = triangle_centroids(p.surface);
    for (int t = 0; t < p.surface.num_triangles(); ++t) {
        const double at = c(t, choice.ends.axis);
        if ((choice.ends.low && at < *choice.ends.low) || (choice.ends.high && at > *choice.ends.high))
            p.fixed.push_back(t);
    }
    p.parameters.kinds = choice.kinds;
    p.parameters.max_displacement = choice.max_displacement;
    return result;
}

TriMesh warped(const TriMesh& surface, const HeldEnds& ends, const Displacement& displacement) {
    const Box box = bounding_box(surface);
    const double fade = 0.1 * (box.max - box.min)[ends.axis];
    TriMesh result = surface;
    for (int k = 0; k < surface.num_vertices(); ++k) {
        const Eigen::Vector3d p = surface.vertices.row(k);
        double share = 1;
        if (ends.low) share *= smooth_step((p[ends.axis] - *ends.low) / fade);
        if (ends.high) share *= smooth_step((*ends.high - p[ends.axis]) / fade);
        result.vertices.row(k) += share * displacement(p).transpose();
    }
    return result;
}

void recover_vertices(EvidenceProblem& problem, const TriMesh& target) {
    problem.outside = true;
    problem.problem.quantities = {target_shape_same("match", problem.problem.surface, target)};
    problem.problem.objective = "match";
}

void recover_shape(EvidenceProblem& problem, const TriMesh& target) {
    problem.outside = true;
    problem.problem.quantities = {target_shape_closest("match", problem.problem.surface, target)};
    problem.problem.objective = "match";
}

PatchHierarchy finest_only(const PatchHierarchy& tree) {
    PatchHierarchy result;
    result.levels = {tree.levels.front(), tree.levels.back()};
    for (Patch& patch : result.levels.back().patches) patch.parent = 0;
    return result;
}

}  // namespace strake::evidence
