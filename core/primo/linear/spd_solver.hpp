#pragma once
#include "core/primo/linear/block_matrix.hpp"

#include <memory>

namespace strake {

/// Sparse Cholesky (CHOLMOD, supernodal) of a symmetric BlockMatrix, ordered by METIS on the graph of the blocks.
class SpdSolver {
public:
    SpdSolver();
    ~SpdSolver();
    SpdSolver(SpdSolver&&) noexcept;
    SpdSolver& operator=(SpdSolver&&) noexcept;

    void analyze(const BlockMatrix& A);  ///< ordering; once per pattern. @throws SolverError
    /// False when A is not positive definite (no factor is kept then). @throws SolverError: out of memory, not finite.
    [[nodiscard]] bool factorize(const BlockMatrix& A);
    bool has_factor() const;
    void drop_factor();
    /// Solves A X = B, B is 6 size x k. @pre has_factor().
    Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const;
    long num_factor_entries() const;

private:
    struct Impl;  // keeps cholmod.h out of the public headers
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
