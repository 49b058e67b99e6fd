#pragma once
#include "core/mesh/mesh.hpp"
#include "core/primo/linear/aggregation.hpp"
#include "core/primo/linear/multigrid_options.hpp"
#include "core/primo/linear/spd_solver.hpp"

#include <optional>

/// Implementation of Multigrid: the levels in either precision. hierarchy.cpp builds them, galerkin.cpp makes the
/// coarse matrices, cycle.cpp applies them.
namespace strake {

template <class Real>
struct MultigridLevel {
    BlockRows<Real> A;       ///< off-diagonal blocks, scaled to unit diagonal
    std::vector<Matrix6> T;  ///< per row: from its twist to its scaled unknowns; only while the next level is made
    Points centre;
    Clusters clusters;
    BlockRows<Real> P;       ///< prolongation from the next level, between scaled unknowns; empty on the last
    RowGroups<Real> groups;  ///< of P
    double largest = 2;      ///< bound of the eigenvalues of A
    std::vector<Real> x, r, residual, direction, next;  ///< of the cycle
    std::vector<Real> c1, v1, c2, v2, left;             ///< of the K-cycle
};

template <class Real>
class Hierarchy {
public:
    explicit Hierarchy(const MultigridOptions& options) : options_(options) {}
    /// False when a matrix is not positive definite in this precision.
    bool build(const BlockMatrix& A, const Points& centre, const std::vector<Clusters>* clusters);
    Eigen::VectorXd apply(const Eigen::Ref<const Eigen::VectorXd>& r, Cycle kind);
    std::vector<Clusters> take_clusters();
    const std::vector<MultigridLevel<Real>>& levels() const { return levels_; }
    std::size_t bytes() const;
    double cycle_work() const;

private:
    using Level = MultigridLevel<Real>;
    bool is_last(Level& level, int at) const;
    bool coarsen(Level& level, int at, Level& coarse) const;
    bool factorize_last();
    void smooth(Level& level, int at, std::vector<Real>& x, std::vector<Real>& r, bool before) const;
    void cycle(int at, const std::vector<Real>& b, std::vector<Real>& x);         ///< x approximates A^-1 b
    void coarse_solve(int at, const std::vector<Real>& b, std::vector<Real>& x);  ///< two cycles

    MultigridOptions options_;
    std::vector<Level> levels_;
    std::vector<Real> scale_;  ///< inverse factors of the finest diagonal blocks, block_entries each
    SpdSolver coarsest_;
    Cycle kind_ = Cycle::best;  ///< of what is being applied
};

/// Rigid motions of the clusters about `coarse.centre`, orthonormal in the scaled unknowns, smoothed by `steps` damped
/// Jacobi steps. Fills coarse.T and frees level.T. Empty when the motions of a cluster are linearly dependent.
template <class Real>
std::optional<BlockRows<Real>> prolongation(MultigridLevel<Real>& level, int steps, double damping,
                                            MultigridLevel<Real>& coarse);

/// P^T A P: off-diagonal blocks, and the diagonal ones separately.
template <class Real>
BlockRows<Real> galerkin(const BlockRows<Real>& A, const BlockRows<Real>& P, const ColumnLists& in_columns,
                         std::vector<Matrix6>& diagonal);

}  // namespace strake
