#pragma once
#include "bench/coarse_to_fine/problems.hpp"
#include "bench/coarse_to_fine/quantities.hpp"

#include <functional>

/// What the problems are put together from.
namespace strake::evidence {

using Displacement = std::function<Eigen::Vector3d(const Eigen::Vector3d& p)>;

struct ProblemChoice {
    std::string name, what;
    TriMesh surface;
    HeldEnds ends;
    std::vector<VariableKind> kinds{VariableKind::load};
    double max_displacement = 0.1;
    std::vector<int> patches{4, 16, 64};
    /// Over the diagonal. Round bodies want more: a thin shell bends over the root of height times radius, and buckles.
    double prism_height = 0.02;
};

/// Held triangles, automatic patches, prism heights; no quantity yet.
EvidenceProblem start_of(const ProblemChoice& choice);

/// The surface moved by `displacement`, which is faded in smoothly from the held ends on over a tenth of the
/// surface's extent, so that what is held stays where it is.
TriMesh warped(const TriMesh& surface, const HeldEnds& ends, const Displacement& displacement);

/// Minimize the mean square distance of the vertices to those of `target`; adds the quantity `match`. In vertices that
/// move linearly with the variables this is a quadratic whose Hessian is the metric: the easiest case for the
/// comparators. For motions so large that the closest point would lie on the wrong side.
void recover_vertices(EvidenceProblem& problem, const TriMesh& target);

/// Minimize the mean square distance to the closest point of `target`, of any triangulation: the shape alone counts.
void recover_shape(EvidenceProblem& problem, const TriMesh& target);

double smooth_step(double s);             ///< 0 below 0, 1 above 1, twice differentiable between
double soft_ramp(double s, double w);     ///< max(0, s), rounded off: w log(1 + exp(s / w))
double gauss(double distance, double w);  ///< exp(-(distance / w)^2)
double radians(double degrees);

}  // namespace strake::evidence
