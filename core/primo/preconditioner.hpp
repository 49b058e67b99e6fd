#pragma once
#include "core/primo/multigrid.hpp"
#include "core/primo/shell.hpp"
#include "core/primo/spd_solver.hpp"

/// The one place where it is decided how systems with the Hessian are solved: conjugate gradients on the exact matrix
/// (conjugate_gradients.hpp) ask this for an approximate inverse, which is kept from one design to the next.
namespace strake {

class Preconditioner {
public:
    /// What is decided: by the number of prisms, their thickness and the solves to be expected. `automatic` never
    /// stays.
    static LinearSolver choose(LinearSolver wanted, int num_free_prisms, double height_in_edges, int expected_solves);
    /// What multigrid is told for prisms of that height: thin ones bend in ways that large clusters miss.
    static MultigridOptions options_for(double height_in_edges);

    /// Before `analyze`; direct unless said. @param may_change from multigrid to a factor, for good, where that is
    /// found to cost less: by operations counted and foreseen, never by clocks, so that equal histories give equal bits
    void use(LinearSolver solver, double height_in_edges, bool may_change = false);
    void analyze(const BlockMatrix& H);  ///< once per pattern
    /// From H; false where H is found not to be positive definite (nothing is kept then). `centre` (a row per block
    /// row): the point about which its twist is meant. @throws SolverError
    [[nodiscard]] bool build(const BlockMatrix& H, const Points& centre);
    bool is_built() const { return is_exact() ? factor_.has_factor() : multigrid_.is_ready(); }
    void drop();
    /// A symmetric positive definite approximation of the inverse of the H it was built from, applied to the columns
    /// of B; symmetric and linear but for a few percent where it is neither exact nor asked to be. @pre is_built()
    Eigen::MatrixXd apply(const Eigen::Ref<const Eigen::MatrixXd>& B, Cycle kind = Cycle::best);
    /// True: `build` proves that H is positive definite, and `apply` is its inverse but for single precision.
    bool is_exact() const { return solver_ == LinearSolver::direct; }
    /// What `build` costs, in applications to one column: measured, the same for all sizes within a third.
    /// Cycles of multigrid cost less to set up, but more of them are usual: not every solve shall do so.
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
    bool has_clusters_ = false;  ///< of the present pattern
};

}  // namespace strake
