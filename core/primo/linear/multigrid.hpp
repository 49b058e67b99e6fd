#pragma once
#include "core/mesh/mesh.hpp"
#include "core/primo/linear/block_matrix.hpp"
#include "core/primo/linear/multigrid_options.hpp"

#include <functional>
#include <memory>

/// Smoothed-aggregation multigrid for the Hessian of the shell: clusters of prisms move as rigid bodies, level by
/// level, down to a system small enough for a direct factor.
///
///     Multigrid multigrid;
///     if (!multigrid.setup(H, centres)) ...                 // indefinite
///     KrylovResult end = multigrid.solve(H, b, 1e-8);
///
/// Internally in single precision, in coordinates that make the diagonal blocks the identity; the outer iteration is in
/// double precision and as accurate as a direct factor.
namespace strake {

struct KrylovResult {
    Eigen::VectorXd x;
    int iterations = 0;
    double relative_residual = 1;
    bool positive = true;  ///< no direction of negative curvature met
};

class Multigrid {
public:
    explicit Multigrid(const MultigridOptions& options = {});
    ~Multigrid();
    Multigrid(Multigrid&&) noexcept;
    Multigrid& operator=(Multigrid&&) noexcept;

    /// Clusters and coarse matrices of A. `centre` (one row per block row) is the reference point of the twist of each
    /// block row. False when A is found to be indefinite (nothing is kept then; true is no proof).
    /// @param in_double fall back to double precision if single fails; else return false
    /// @throws InvalidInput: sizes differ; SolverError: not finite, out of memory.
    [[nodiscard]] bool setup(const BlockMatrix& A, const Points& centre, bool in_double = true);
    /// The same for new entries in the same pattern, with the clusters of `setup`.
    [[nodiscard]] bool update(const BlockMatrix& A, const Points& centre);
    bool is_ready() const;
    void drop();

    /// Approximates A^-1 r; with Cycle::best not exactly linear in r, which requires flexible outer iterations.
    Eigen::VectorXd apply(const Eigen::Ref<const Eigen::VectorXd>& r, Cycle kind = Cycle::best);
    /// Solves A x = b to `tolerance` (relative) by flexible conjugate gradients.
    KrylovResult solve(const BlockMatrix& A, const Eigen::VectorXd& b, double tolerance, int max_iterations = 500);

    bool is_single_precision() const;      ///< false: double, for long thin parts or a nearly singular matrix
    std::vector<int> level_sizes() const;  ///< block rows, finest first
    std::size_t bytes() const;             ///< of all levels, without the factor of the last
    double cycle_work() const;  ///< products of 6x6 blocks in one `apply`; those in double precision count double

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

using LinearMap = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
/// Conjugate gradients for a preconditioner that is not exactly linear (Notay 2000).
KrylovResult flexible_conjugate_gradients(const LinearMap& A, const LinearMap& preconditioner, const Eigen::VectorXd& b,
                                          double tolerance, int max_iterations);

}  // namespace strake
