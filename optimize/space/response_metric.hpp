#pragma once
#include "optimize/space/design_space.hpp"

/// How large is a change of the design variables? Measured by what the surface does, in the linear response of the
/// shell: neither soft collective motions nor stiff in-plane loads, which run into buckling, look harmless in it.
namespace strake {

/// What a unit of every variable does, by the linear response.
struct Responses {
    Eigen::VectorXd largest;  ///< displacement
    Eigen::MatrixXd samples;  ///< column j: displacements of sampled vertices times the root of their share of the area
    /// Column j: integrals of the displacement (x, y, z) and of its normal part over each leaf of the tree, rest area,
    /// then the work of every given load at its value 1; zero for strains. The work of any load in response j is a sum
    /// of these.
    Eigen::MatrixXd work_integrals;
};

/// At rest, in units of the variables; from the cache where it knows them. Stiffness, which has none, is left at zero.
/// @throws UnheldPart, SolverError, Interrupted. Cost: one factorization and one back-substitution per unknown
/// variable.
Responses responses_at_rest(const DesignSpace& space);

/// The vertices that `Responses::samples` has, in order.
std::vector<int> sampled_vertices(const RestFacts& rest);

/// A displacement of the surface (n x 3) as `Responses::samples` has it.
Eigen::VectorXd sampled_motion(const RestFacts& rest, const Points& motion);

/// Where wings keep their sections, most of what some fields do is taken out: a change of them counts at least this
/// share of the motion before, so that small changes are not made of motions that no section is brought back from.
constexpr double held_share = 0.3;

/// The metric: the squared root mean square displacement (twice, over `variable_scale`) plus the elastic energy (over
/// `soft_work`), plus `held_share` squared of that of fields before wings keep their sections.
Eigen::MatrixXd response_metric(const DesignSpace& space, const Responses& responses);

/// size() x size(), positive semidefinite: x.this.x is the mean square of the motion along the surface's normals, in
/// units of the model squared, by the linear response at rest; zero for stiffness, which has none. Motion along a
/// smooth surface does not change its shape.
/// @pre all variables are of the shape
Eigen::MatrixXd normal_motion(const DesignSpace& space);

/// size() x size(), positive semidefinite: x.this.x is the mean square of the motion's Laplacian along the surface, in
/// 1 over units of the model squared, by the linear response at rest, but for vertices at open edges; zero for
/// stiffness. Values of a smooth shape curve more with changes of it that are rougher. @pre all variables are of the
/// shape
Eigen::MatrixXd roughness(const DesignSpace& space);

/// Work of a load variable, at x = 1, that is soft for this space: the lower quartile, over
/// `RestFacts::energy_share`; 0 without loads.
double soft_work(const DesignSpace& space, const Responses& responses);

/// The same metric at the equilibrium of `shell`, times d: near buckling it finds soft directions long. Two
/// back-substitutions, however many variables. @pre all variables of the shape are loads or fields.
/// @param shell null: there is none. @param surface there (n x 3), where attached parts follow fields
Eigen::VectorXd present_product(const DesignSpace& space, PrimoShell* shell, const Eigen::VectorXd& d,
                                const Points* surface = nullptr);

}  // namespace strake
