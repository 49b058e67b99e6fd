#include "core/error.hpp"
#include "core/primo/linear/block_order.hpp"
#include "core/primo/linear/spd_solver.hpp"
#include "core/primo/linear/supernodal_cholesky.hpp"

// OpenBLAS: installed by the set-up scripts; another BLAS works too.
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);

/// SpdSolver where STRAKE_GPL is off: our own factorization in CHOLMOD's place.
namespace strake {

struct SpdSolver::Impl {
    SupernodalCholesky cholesky;
    Supernodes single;  ///< of the numeric factor
    bool numeric = false;
};

SpdSolver::SpdSolver() : impl_(std::make_unique<Impl>()) {
    // One thread: otherwise the order of additions, and the bits, would depend on their number.
    if (openblas_set_num_threads) openblas_set_num_threads(1);
}
SpdSolver::~SpdSolver() = default;
SpdSolver::SpdSolver(SpdSolver&&) noexcept = default;
SpdSolver& SpdSolver::operator=(SpdSolver&&) noexcept = default;

void SpdSolver::analyze(const BlockMatrix& A) {
    impl_->numeric = false;
    impl_->single = {};
    impl_->cholesky.analyze(A, block_order(A));
}

bool SpdSolver::factorize(const BlockMatrix& A) {
    if (!A.is_finite()) throw SolverError(text("Cholesky: the matrix of ", 6 * A.size(), " unknowns is not finite"));
    try {
        impl_->numeric = impl_->cholesky.factorize(A, impl_->single);
    } catch (const std::bad_alloc&) {
        throw SolverError(text("Cholesky: factorization of ", 6 * A.size(), " unknowns failed: out of memory"));
    }
    return impl_->numeric;
}

bool SpdSolver::has_factor() const { return impl_->numeric; }
void SpdSolver::drop_factor() { impl_->numeric = false; }

Eigen::MatrixXd SpdSolver::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
    if (!impl_->numeric) throw SolverError("Cholesky: solve without a factor");
    Eigen::MatrixXd result;
    impl_->single.solve(B, result);
    return result;
}

long SpdSolver::num_factor_entries() const { return impl_->cholesky.num_entries(); }

}  // namespace strake
