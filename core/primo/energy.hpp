#pragma once
#include "core/primo/linear/block_matrix.hpp"
#include "core/primo/rest_state.hpp"

/// Energy of the shell, its gradient and its exact Hessian on SE(3). A prism's update is a twist (omega, v) of its
/// centroid: R <- exp([omega]x) R, u <- u + v. A point with current arm a = R X moves at omega x a + v.
namespace strake {

/// Loads with both members filled: n rows each.
Loads complete(const Loads& loads, int num_vertices);

/// Terms of the energy at given poses: jumps at faces and displacements of vertices. The mixed-integration-point Newton
/// method (Magisano, Leonetti, Garcea 2017) carries them between iterations by linear prediction.
struct Jumps {
    std::vector<Quad> face;        ///< per shared face: y_i(g) - y_j(g)
    std::vector<double> mirrored;  ///< 4 per mirrored face: n . (y(g) - X(g))
    Points vertex;                 ///< displacement of each vertex that follows prisms, else 0
};

/// R - I of every prism, from its quaternion, with full relative precision for small rotations.
std::vector<Eigen::Matrix3d> rotation_differences(const Poses& poses);

Jumps jumps(const RestState& rest, const Poses& poses, const std::vector<Eigen::Matrix3d>& turn);
/// Rate of the jumps under twists (6 per free prism); pinned prisms stand still.
Jumps jump_rates(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Eigen::VectorXd& twist);
/// a + b, member by member.
Jumps sum(const Jumps& a, Jumps b);

double energy(const RestState& rest, const Jumps& jump, const Loads& loads);

using Wrenches = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;  ///< per prism: torque, force

/// Torque about the centroid and force on every prism: the derivative of the energy by the twists.
Wrenches energy_gradient(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Jumps& jump,
                         const Loads& loads);
/// The part from the forces F alone: the scale of the relative gradient.
Wrenches applied_forces(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Loads& loads);

/// How the rotational stress term enters: `exact` (with the true jumps: the exact Hessian; with predicted ones: the
/// mixed method), `clipped` to its positive semidefinite part per prism (always definite), `none` (Gauss-Newton).
enum class StressTerm { exact, clipped, none };

/// Zero matrix with the sparsity of the Hessian without springs: prisms that share a face.
BlockMatrix hessian_pattern(const RestState& rest);
/// The Hessian without the springs' stiffness (with their forces). That stiffness couples all prisms around a vertex,
/// which means more than twice the entries and five times the factorization work; `add_spring_product` applies it
/// instead.
void assemble_hessian(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Jumps& stress,
                      const Loads& loads, StressTerm term, BlockMatrix& H);
/// y += the springs' part of the Hessian times x: 2 lambda v_k at vertex k, handed to its prisms.
void add_spring_product(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Eigen::VectorXd& spring,
                        const Eigen::VectorXd& x, Eigen::VectorXd& y);
/// Adds that stiffness with |mean of the prisms' motions|^2 replaced by the mean of their squares, which couples no
/// prisms: an upper bound, exact where neighbours move alike.
void add_lumped_springs(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Eigen::VectorXd& spring,
                        BlockMatrix& H);

/// Vertex velocities under twists of the free prisms, and the transpose: vertex forces to prism wrenches (6 per free
/// prism).
Points vertex_rates(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Eigen::VectorXd& twist);
Eigen::VectorXd vertex_wrenches(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Points& force);

/// Current arm of a rest arm.
inline Eigen::Vector3d turned(const Eigen::Matrix3d& turn, const Eigen::Vector3d& arm) { return arm + turn * arm; }

}  // namespace strake
