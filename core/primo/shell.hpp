#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"
#include "core/primo/attachments.hpp"

#include <Eigen/Geometry>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// The deformation operator D(M, x): a shell of rigid prisms coupled by elastic fibres
/// (Berkenstock & Aftosmis 2008, section II; PriMo: Botsch et al. 2006). DESIGN section 4.
///
///     PrimoShell shell(mesh, options);
///     Equilibrium end = shell.solve(loads);             // E minimal, from wherever the prisms are now
///     Points v = shell.vertices();
///     auto gradients = shell.adjoint({dJ_dv});          // one back-substitution per functional
///
/// Units: energy length^2, force length, traction 1/length, spring per area 1/length^2.
namespace strake {

/// x -> about + exp(rotation) (x - about) + translation.
struct RigidMotion {
    Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rotation vector, radians
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< length
    Eigen::Vector3d about = Eigen::Vector3d::Zero();
};

constexpr int free_prism = -1;  ///< value of ShellOptions::pin
constexpr int fixed_prism = 0;  ///< pinned with zero motion; k > 0: pinned under motions[k - 1] of `solve`

/// How systems with the Hessian are solved. `multigrid` needs a quarter of the memory and is faster for a few solves on
/// many prisms; `direct` keeps a factor, with which every further solve is cheap.
enum class LinearSolver { automatic, direct, multigrid };

struct ShellOptions {
    Eigen::VectorXd prism_height;           ///< h per vertex, full thickness, absolute length, > 0
    std::vector<int> pin;                   ///< per triangle; empty: all free
    std::optional<SymmetryPlane> symmetry;  ///< couples boundary edges on the plane to their mirror images
    bool couple_nonmanifold = false;        ///< edges of more than two triangles: couple every pair, else refuse
    /// Parts that go with others: no unknowns, held by nothing, loaded by nothing; empty: none. Their prisms count as
    /// fixed, whatever `pin` says; their vertices are placed after the others', in all that is asked of the shell.
    std::shared_ptr<const Attachments> attached;
    LinearSolver solver = LinearSolver::automatic;
    int expected_solves = 100;  ///< equilibria and adjoints to come, roughly: what `automatic` goes by, beside the size
};

struct Loads {
    Points force;            ///< F_k per vertex, n x 3; empty: none
    Eigen::VectorXd spring;  ///< lambda_k per vertex, >= 0; empty: none
};

enum class SolveStatus { converged, not_converged, unstable, cancelled };
std::string to_string(SolveStatus status);
std::string to_string(LinearSolver solver);

struct SolveRecord {
    int iteration;                           ///< told of a coarser shell that goes ahead: 0
    double energy, relative_gradient, step;  ///< step in diagonals
    double seconds;
};
using SolveProgress = std::function<bool(const SolveRecord&)>;  ///< return false to cancel

struct SolveOptions {
    double min_step = 1e-9;    ///< converged below this largest prism motion, in diagonals, > 0
    int max_iterations = 60;   ///< Newton iterations over all fallbacks, >= 1; four more where the last step is small
    bool fallbacks = true;     ///< after a failed attempt try line search and load steps; else fail early
    bool keep_factor = false;  ///< try the factor of an earlier design as preconditioner before factorizing anew
};

struct SolveTimes {
    double assembly = 0, ordering = 0, factorization = 0, substitution = 0;  ///< wall seconds
};

struct Equilibrium {
    SolveStatus status = SolveStatus::not_converged;
    std::string reason;  ///< one line in words
    double energy = std::numeric_limits<double>::quiet_NaN();
    double gradient_norm = 0;      ///< forces, torques divided by h; length
    double relative_gradient = 0;  ///< over the norm of the applied forces (of the reactions, without loads)
    int iterations = 0, factorizations = 0, substitutions = 0, load_steps = 1;
    double last_step = 0;  ///< diagonals
    bool stable = false;   ///< the exact Hessian is positive definite at the end
    /// With what it began and ended: `automatic` may go over from multigrid to a factor, and stays there.
    LinearSolver first_solver = LinearSolver::direct, solver = LinearSolver::direct;
    SolveTimes seconds;
    std::vector<SolveRecord> records;
};

/// Where every prism is: rotation, and displacement of its rest centroid.
struct Poses {
    std::vector<Eigen::Quaterniond> rotation;
    Points displacement;
};

struct AdjointOptions {
    double tolerance = 1e-10;  ///< of the adjoint's size in energy, down to where round-off decides
    bool prism_height = true;  ///< else dJ/dh is left out
};

/// dJ/d(everything) of one functional at an equilibrium.
struct ShellSensitivities {
    Points force;                                     ///< dJ/dF_k, n x 3
    Eigen::VectorXd spring;                           ///< dJ/dlambda_k, n
    Eigen::VectorXd prism_height;                     ///< dJ/dh_k, n
    std::vector<Eigen::Matrix<double, 6, 1>> motion;  ///< per motion of `solve`: dJ/d(rotation, translation)
    Eigen::MatrixXd wrench;  ///< m x 6: dJ/d(twist) of each prism that is pinned under a motion, about its centroid;
                             ///< zero rows elsewhere; empty without motions
};

/// Twist (rotation, translation of the centroid) of a prism with that rest centroid per unit of its motion's six
/// parameters (rotation vector, translation): dJ/d(motion) is the sum of motion_twist^T wrench over its prisms.
Eigen::Matrix<double, 6, 6> motion_twist(const RigidMotion& motion, const Eigen::Vector3d& rest_centroid);

/// A connected part of the surface that nothing holds: the message names it and says what to do.
struct UnheldPart : std::runtime_error {
    using runtime_error::runtime_error;
};

class PrimoShell {
public:
    /// @throws InvalidInput: degenerate triangles (area below 1e-14 diagonal^2) with their numbers, non-manifold edges
    /// unless coupled, heights not > 0, wrong sizes, nothing free.
    PrimoShell(const TriMesh& mesh, const ShellOptions& options);
    ~PrimoShell();
    PrimoShell(PrimoShell&&) noexcept;
    PrimoShell& operator=(PrimoShell&&) noexcept;

    /// Moves the prisms to the minimum of the energy under `loads` and `motions`, starting where they are. Where the
    /// end is not a stable minimum the status says what it is instead, and the prisms go back to where they were.
    /// @throws UnheldPart; InvalidInput on wrong sizes, negative springs, or a pinned motion that takes a vertex off
    /// the symmetry plane; SolverError when a factorization fails for another reason than indefiniteness.
    Equilibrium solve(const Loads& loads, const std::vector<RigidMotion>& motions = {},
                      const SolveOptions& options = {}, const SolveProgress& progress = {});

    /// Vertices of the present poses, by the rule of DESIGN section 4 (*Vertices*). Fixed ones are copies.
    Points vertices() const;
    /// Those of attached parts: the rotation of the part, no displacement.
    Poses poses() const;
    void set_poses(const Poses& poses);  ///< any poses; pinned prisms are moved by the next `solve`, attached ones stay
    void reset();                        ///< back to rest

    double energy(const Loads& loads = {}) const;  ///< at the present poses
    /// Energy gradient per prism, m x 6: (torque about the prism's centroid, force); zero on pinned prisms.
    Eigen::MatrixXd gradient(const Loads& loads = {}) const;

    /// The paper's single solve: vertices displaced by the linear response at rest (rotations not composed).
    /// @throws InvalidInput, as `solve`; SolverError where a part is barely held
    Points linear_response(const Loads& loads, const std::vector<RigidMotion>& motions = {});

    /// Vertex velocities dv for changes of the forces dF (n x 3 each), at the equilibrium of the last `solve`
    /// (or at rest before any). One back-substitution each, and another where it leaves more than `tolerance`
    /// (relative) and more than the round-off of the product.
    std::vector<Points> response(const std::vector<Points>& dF, double tolerance = 1e-11);
    /// The same for changes of the motions (6 per motion: rotation, translation); [k][c] is component c of motion k.
    std::vector<std::array<Points, 6>> motion_response();

    /// One adjoint solve per functional at the equilibrium of the last converged `solve`: H y = B dJ/dv with H the
    /// exact Hessian.
    std::vector<ShellSensitivities> adjoint(const std::vector<Points>& dJ_dv, const AdjointOptions& options = {});

    /// Factorizes the exact Hessian at the equilibrium of the last solve, for what comes next. @throws SolverError
    /// where it is not positive definite.
    void refresh_tangent();

    /// The prisms at the present poses, to look at: 8 triangles each (bottom, top, sides), in the order of the prisms.
    TriMesh prism_surface() const;

    int num_free_prisms() const;
    /// Per vertex: copied from the start, bit for bit, by this shell; attached ones go elsewhere after that.
    const std::vector<char>& fixed_vertices() const;
    LinearSolver solver() const;  ///< what is used now: never `automatic`

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
