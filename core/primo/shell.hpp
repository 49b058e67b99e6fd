#pragma once
#include "core/primo/shell_types.hpp"

#include <array>
#include <memory>
#include <vector>

/// The deformation operator D(M, x): a shell of rigid prisms coupled by elastic fibres
/// (Berkenstock & Aftosmis 2008, section II; PriMo: Botsch et al. 2006). docs/theory-shell.md.
///
///     PrimoShell shell(mesh, options);
///     Equilibrium end = shell.solve(loads);             // minimum of E, starting from the current poses
///     Points v = shell.vertices();
///     auto gradients = shell.adjoint({dJ_dv});          // one back-substitution per functional
///
/// Units: energy length^2, force length, traction 1/length, spring per area 1/length^2.
namespace strake {

/// Twist (rotation, translation of the centroid) of a prism with that rest centroid, per unit of the six parameters of
/// its motion (rotation vector, translation): dJ/d(motion) is the sum of motion_twist^T wrench over its prisms.
Eigen::Matrix<double, 6, 6> motion_twist(const RigidMotion& motion, const Eigen::Vector3d& rest_centroid);

class PrimoShell {
public:
    /// @throws InvalidInput: degenerate triangles (area below 1e-14 diagonal^2) with their numbers, non-manifold edges
    /// unless coupled, heights not > 0, wrong sizes, no free prism.
    PrimoShell(const TriMesh& mesh, const ShellOptions& options);
    ~PrimoShell();
    PrimoShell(PrimoShell&&) noexcept;
    PrimoShell& operator=(PrimoShell&&) noexcept;

    /// Moves the prisms to the minimum of the energy under `loads` and `motions`, starting from the current poses. If
    /// the end is not a stable minimum, the status says why and the prisms return to their earlier poses.
    /// @throws UnheldPart; InvalidInput on wrong sizes, negative springs, or a pinned motion that moves a vertex off
    /// the symmetry plane; SolverError when a factorization fails for a reason other than indefiniteness.
    Equilibrium solve(const Loads& loads, const std::vector<RigidMotion>& motions = {},
                      const SolveOptions& options = {}, const SolveProgress& progress = {});

    /// Vertices at the current poses: the mean over the prisms around each, over the pinned ones where there are any.
    /// Fixed ones are copies.
    Points vertices() const;
    /// Attached parts: the part's rotation, no displacement.
    Poses poses() const;
    void set_poses(const Poses& poses);  ///< any poses; the next `solve` moves pinned prisms, attached ones stay
    void reset();                        ///< back to rest

    double energy(const Loads& loads = {}) const;  ///< at the current poses
    /// Energy gradient per prism, m x 6: (torque about the prism's centroid, force); zero on pinned prisms.
    Eigen::MatrixXd gradient(const Loads& loads = {}) const;

    /// The paper's single solve: vertices displaced by the linear response at rest (rotations not composed).
    /// @throws InvalidInput like `solve`; SolverError when a part is barely supported
    Points linear_response(const Loads& loads, const std::vector<RigidMotion>& motions = {});

    /// Vertex velocities dv for changes of the forces dF (n x 3 each), at the equilibrium of the last `solve`
    /// (or at rest before any). One back-substitution each, and another if the residual exceeds `tolerance` (relative)
    /// and the round-off of the product.
    std::vector<Points> response(const std::vector<Points>& dF, double tolerance = 1e-11);
    /// The same for changes of the motions (6 per motion: rotation, translation); [k][c] is component c of motion k.
    std::vector<std::array<Points, 6>> motion_response();

    /// One adjoint solve per functional at the equilibrium of the last converged `solve`: H y = B dJ/dv with H the
    /// exact Hessian.
    std::vector<ShellSensitivities> adjoint(const std::vector<Points>& dJ_dv, const AdjointOptions& options = {});

    /// Factorizes the exact Hessian at the equilibrium of the last solve, for the next solves. @throws SolverError if
    /// it is not positive definite.
    void refresh_tangent();

    /// The prisms at the current poses, for display: 8 triangles each (bottom, top, sides), in the order of the prisms.
    TriMesh prism_surface() const;

    int num_free_prisms() const;
    /// Per vertex: copied from the start, bit for bit, by this shell; attached ones go elsewhere after that.
    const std::vector<char>& fixed_vertices() const;
    LinearSolver solver() const;  ///< in use now: never `automatic`

    struct Impl;  ///< shell_impl.hpp
    Impl& impl() { return *impl_; }

private:
    std::unique_ptr<Impl> impl_;
};

/// Forces of a traction (force per rest area): F_k = sum over listed triangles at k of traction * A_T / 3. Summed in
/// triangle order whatever the patches, so that equal tractions give equal bits. `traction` is m x 3, zero rows where
/// there is none.
Points traction_forces(const TriMesh& rest, const Points& traction);

/// h per vertex from h per triangle (m): the area-weighted mean of log h over the triangles at the vertex.
Eigen::VectorXd vertex_heights(const TriMesh& mesh, const Eigen::VectorXd& triangle_height);

}  // namespace strake
