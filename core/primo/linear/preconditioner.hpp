#pragma once
#include "core/primo/linear/linear_solver.hpp"
#include "core/primo/linear/multigrid.hpp"
#include "core/primo/linear/spd_solver.hpp"

/// Decides how systems with the Hessian are solved: an approximate inverse for conjugate gradients on the exact matrix
/// (conjugate_gradients.hpp), kept from one design to the next.
namespace strake {

class Preconditioner {
public:
    /// The choice by number of prisms, their thickness and the expected solves; never `automatic`.
    static LinearSolver choose(LinearSolver wanted, int num_free_prisms, double height_in_edges, int expected_solves);
    /// Multigrid options for prisms of that height: large clusters miss the bending of thin ones.
    static MultigridOptions options_for(double height_in_edges);

    /// Call before `analyze`; default: direct. @param may_change from multigrid to a factor, for good, when that costs
    /// less; by counted operations, never by clocks, because equal histories must give equal bits
    void use(LinearSolver solver, double height_in_edges, bool may_change = false);
    void analyze(const BlockMatrix& H);  ///< once per pattern
    /// From H; false when H is found to be not positive definite (nothing is kept then). `centre` (a row per block
    /// row): reference point of its twist. @throws SolverError
    [[nodiscard]] bool build(const BlockMatrix& H, const Points& centre);
    bool is_built() const { return is_exact() ? factor_.has_factor() : multigrid_.is_ready(); }
    void drop();
    /// A symmetric positive definite approximation of the inverse of the H it was built from, applied to the columns
    /// of B; symmetric and linear within a few percent, exactly so with is_exact() or Cycle::linear. @pre is_built()
    Eigen::MatrixXd apply(const Eigen::Ref<const Eigen::MatrixXd>& B, Cycle kind = Cycle::best);
    /// True: `build` proves that H is positive definite, and `apply` is its inverse in single precision.
    bool is_exact() const { return solver_ == LinearSolver::direct; }
    /// Cost of `build` in applications to one column: measured, equal for all sizes within a third. The value for
    /// multigrid is above its measured cost, because a solve needs many cycles and not every solve should rebuild them.
    double build_cost() const { return is_exact() ? 40 : 60; }
    long num_entries() const;  ///< numbers kept

private:
    bool set_up(const BlockMatrix& H, const Points& centre, bool can_change);
    bool change(const BlockMatrix& H);
    void count_regret(int prisms);

    LinearSolver solver_ = LinearSolver::direct;
    bool may_change_ = false;
    int cycles_ = 0;     ///< since multigrid was set up
    double regret_ = 0;  ///< operations per prism that a factor would have saved so far
    SpdSolver factor_;
    Multigrid multigrid_;
    bool has_clusters_ = false;  ///< of the current pattern
};

}  // namespace strake
