#pragma once
#include "core/mesh/mesh.hpp"
#include "core/primo/aggregation.hpp"
#include "core/primo/spd_solver.hpp"

#include <functional>
#include <memory>

/// Smoothed-aggregation multigrid for the Hessian of the shell: clusters of prisms move as rigid bodies, level by
/// level, down to a system small enough for a direct factor.
///
///     Multigrid multigrid;
///     if (!multigrid.setup(H, centres)) ...                 // indefinite
///     KrylovResult end = multigrid.solve(H, b, 1e-8);
///
/// Everything inside is in single precision and in coordinates in which the diagonal blocks are the identity; the
/// iteration around it is in double precision, so that the answer is as good as that of a direct factor.
namespace strake {

struct MultigridOptions {
    double strength = 0.25;          ///< threshold of strong connections on the finest level
    int first_radius = 2;            ///< of the clusters of the finest level, in connections; below it is 1
    int prolongation_steps = 1;      ///< damped Jacobi steps that smooth the finest prolongation
    int smoothing_steps = 3;         ///< degree of the finest Chebyshev polynomial, before and after each correction
    double smoothed_share = 0.1;     ///< of the spectrum, from here to 1, that the polynomial damps
    double coarse_strength = 0.125;  ///< the same on the levels below
    int coarse_prolongation_steps = 1;
    int coarse_smoothing_steps = 3;
    double coarse_share = 0.1;
    int direct_size = 400;          ///< block rows from which on a level is factorized
    double inner_tolerance = 0.25;  ///< a coarse system solved so well by its first cycle gets no second
};

/// How the two cycles on each coarser level are combined: best, as conjugate gradients would, which depends on the
/// right-hand side; or added up, which makes the whole a symmetric linear map, but for round-off, and a little weaker.
enum class Cycle { best, linear };

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

    /// Clusters and coarse matrices of A. `centre` (one row per block row) is the point about which the twist of each
    /// block row is meant. False when A is seen to be indefinite (nothing is kept then; a true answer is no proof).
    /// @param in_double where single precision does not do; without, that is false too
    /// @throws InvalidInput: sizes differ; SolverError: not finite, out of memory.
    [[nodiscard]] bool setup(const BlockMatrix& A, const Points& centre, bool in_double = true);
    /// The same for new numbers in the same pattern, with the clusters of `setup`.
    [[nodiscard]] bool update(const BlockMatrix& A, const Points& centre);
    bool is_ready() const;
    void drop();

    /// About A^-1 r; unless asked for not exactly linear in r, so that iterations around it have to be flexible.
    Eigen::VectorXd apply(const Eigen::Ref<const Eigen::VectorXd>& r, Cycle kind = Cycle::best);
    /// A x = b to `tolerance` (relative), by flexible conjugate gradients.
    KrylovResult solve(const BlockMatrix& A, const Eigen::VectorXd& b, double tolerance, int max_iterations = 500);

    bool is_single_precision() const;      ///< else double: long thin parts, or a matrix near singular
    std::vector<int> level_sizes() const;  ///< block rows, finest first
    std::size_t bytes() const;             ///< of all levels, without the factor of the last
    double cycle_work() const;             ///< products of 6x6 blocks in one `apply`, those in double precision twice

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

using LinearMap = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
/// Conjugate gradients that forgive a preconditioner which is not exactly linear (Notay 2000).
KrylovResult flexible_conjugate_gradients(const LinearMap& A, const LinearMap& preconditioner, const Eigen::VectorXd& b,
                                          double tolerance, int max_iterations);

}  // namespace strake
