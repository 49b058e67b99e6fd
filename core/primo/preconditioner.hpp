#pragma once
#include "core/primo/spd_solver.hpp"

/// The one place where it is decided how systems with the Hessian are solved: conjugate gradients on the exact matrix
/// (conjugate_gradients.hpp) ask this for an approximate inverse, which is kept from one design to the next.
namespace strake {

class Preconditioner {
public:
    void analyze(const BlockMatrix& H) { factor_.analyze(H); }  ///< once per pattern
    /// From H; false where H is found not to be positive definite (nothing is kept then). @throws SolverError
    [[nodiscard]] bool build(const BlockMatrix& H) { return factor_.factorize(H); }
    bool is_built() const { return factor_.has_factor(); }
    void drop() { factor_.drop_factor(); }
    /// A symmetric positive definite approximation of the inverse of the H it was built from, applied to the columns
    /// of B. @pre is_built()
    Eigen::MatrixXd apply(const Eigen::MatrixXd& B) const { return factor_.solve(B); }
    /// True: `build` proves that H is positive definite, and `apply` is its inverse but for single precision.
    bool is_exact() const { return true; }
    /// What `build` costs, in applications to one column: measured, the same for all sizes within a third.
    double build_cost() const { return 40; }
    long num_entries() const { return factor_.num_factor_entries(); }

private:
    SpdSolver factor_;
};

}  // namespace strake
