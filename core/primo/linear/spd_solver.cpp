#include "core/primo/linear/spd_solver.hpp"

#include <cholmod.h>

#include <cmath>

#include "core/error.hpp"
#include "core/primo/linear/block_order.hpp"
#include "core/primo/linear/supernodes.hpp"

// OpenBLAS: installed by the set-up scripts; another BLAS works too.
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);
// CHOLMOD asks for four OpenMP threads for loops over single supernodes, which mostly wait for each other: a fifth of
// the CPU on two cores, for no gain.
extern "C" __attribute__((weak)) void omp_set_max_active_levels(int);
extern "C" __attribute__((weak)) int omp_get_max_active_levels();

namespace strake {
namespace {

/// CHOLMOD matrix with the pattern of A, lower triangle, values unset.
cholmod_sparse* pattern(const BlockMatrix& A, cholmod_common* c) {
    const SuiteSparse_long n = 6L * A.size(), entries = 21L * A.size() + 36L * static_cast<long>(A.below.size());
    cholmod_sparse* S = cholmod_l_allocate_sparse(n, n, entries, true, true, -1, CHOLMOD_REAL, c);
    if (!S) throw SolverError(text("CHOLMOD: no memory for a matrix of ", entries, " entries"));
    auto* p = static_cast<SuiteSparse_long*>(S->p);
    auto* i = static_cast<SuiteSparse_long*>(S->i);
    SuiteSparse_long at = 0;
    for (int j = 0; j < A.size(); ++j)
        for (int q = 0; q < 6; ++q) {
            p[6 * j + q] = at;
            for (int r = q; r < 6; ++r) i[at++] = 6 * j + r;
            for (int k = A.begin[j]; k < A.begin[j + 1]; ++k)
                for (int r = 0; r < 6; ++r) i[at++] = 6L * A.row[k] + r;
        }
    p[n] = at;
    return S;
}

void fill(cholmod_sparse* S, const BlockMatrix& A) {
    auto* x = static_cast<double*>(S->x);
    for (int j = 0; j < A.size(); ++j)
        for (int q = 0; q < 6; ++q) {
            for (int r = q; r < 6; ++r) *x++ = A.diagonal[j](r, q);
            for (int k = A.begin[j]; k < A.begin[j + 1]; ++k)
                for (int r = 0; r < 6; ++r) *x++ = A.below[k](r, q);
        }
}

/// While it lives OpenMP opens no parallel regions.
struct OneThread {
    int levels = omp_get_max_active_levels ? omp_get_max_active_levels() : 0;
    OneThread() {
        if (omp_set_max_active_levels) omp_set_max_active_levels(0);
    }
    ~OneThread() {
        if (omp_set_max_active_levels) omp_set_max_active_levels(levels);
    }
};

}  // namespace

struct SpdSolver::Impl {
    cholmod_common common;
    cholmod_sparse* matrix = nullptr;
    cholmod_factor* factor = nullptr;
    bool numeric = false;
    Supernodes single;  ///< of the numeric factor

    Impl() {
        cholmod_l_start(&common);
        common.print = 0;
        common.try_catch = true;  // errors are reported by status, never printed
        common.supernodal = CHOLMOD_SUPERNODAL;
        common.nmethods = 1;
        common.method[0].ordering = CHOLMOD_GIVEN;
        common.postorder = true;
        // One thread: otherwise the order of additions, and the bits, would depend on their number.
        if (openblas_set_num_threads) openblas_set_num_threads(1);
    }
    /// Takes the numeric factor over in single precision and gives its memory back.
    void keep_single() {
        const auto* pi = static_cast<SuiteSparse_long*>(factor->pi);
        const auto* px = static_cast<SuiteSparse_long*>(factor->px);
        const auto* super = static_cast<SuiteSparse_long*>(factor->super);
        const auto* s = static_cast<SuiteSparse_long*>(factor->s);
        const auto* perm = static_cast<SuiteSparse_long*>(factor->Perm);
        const auto count = static_cast<std::ptrdiff_t>(factor->nsuper);
        single.size = static_cast<int>(factor->n);
        single.permutation.assign(perm, perm + factor->n);
        single.first_column.assign(super, super + count + 1);
        single.first_row.assign(pi, pi + count + 1);
        single.row.assign(s, s + pi[count]);
        single.take(static_cast<double*>(std::exchange(factor->x, nullptr)), std::vector<long>(px, px + count + 1));
        factor->xtype = CHOLMOD_PATTERN;  // symbolic again, as after the analysis
        single.max_rows = 0;
        for (std::ptrdiff_t k = 0; k < count; ++k)
            single.max_rows = std::max(single.max_rows, static_cast<int>(pi[k + 1] - pi[k]));
        single.plan();
    }
    void release() {
        cholmod_l_free_sparse(&matrix, &common);
        cholmod_l_free_factor(&factor, &common);
        numeric = false;
    }
    ~Impl() {
        release();
        cholmod_l_finish(&common);
    }
};

SpdSolver::SpdSolver() : impl_(std::make_unique<Impl>()) {}
SpdSolver::~SpdSolver() = default;
SpdSolver::SpdSolver(SpdSolver&&) noexcept = default;
SpdSolver& SpdSolver::operator=(SpdSolver&&) noexcept = default;

void SpdSolver::analyze(const BlockMatrix& A) {
    impl_->release();
    impl_->matrix = pattern(A, &impl_->common);
    std::vector<SuiteSparse_long> order;
    order.reserve(6 * A.size());
    for (const int j : block_order(A))
        for (int q = 0; q < 6; ++q) order.push_back(6L * j + q);
    fill(impl_->matrix, A);
    const OneThread one_thread;
    impl_->factor = cholmod_l_analyze_p(impl_->matrix, order.data(), nullptr, 0, &impl_->common);
    if (!impl_->factor)
        throw SolverError(
            text("CHOLMOD: analysis of ", 6 * A.size(), " unknowns failed, status ", impl_->common.status));
}

bool SpdSolver::factorize(const BlockMatrix& A) {
    if (!A.is_finite()) throw SolverError(text("Cholesky: the matrix of ", 6 * A.size(), " unknowns is not finite"));
    fill(impl_->matrix, A);
    impl_->numeric = false;
    impl_->single = {};
    const OneThread one_thread;
    const bool done = cholmod_l_factorize(impl_->matrix, impl_->factor, &impl_->common);
    if (impl_->common.status == CHOLMOD_NOT_POSDEF) return false;
    if (!done || impl_->common.status < CHOLMOD_OK)
        throw SolverError(text("CHOLMOD: factorization of ", 6 * A.size(), " unknowns failed",
                               impl_->common.status == CHOLMOD_OUT_OF_MEMORY ? ": out of memory" : "", ", status ",
                               impl_->common.status));
    impl_->numeric = true;
    impl_->keep_single();
    return true;
}

bool SpdSolver::has_factor() const { return impl_->numeric; }
void SpdSolver::drop_factor() { impl_->numeric = false; }

Eigen::MatrixXd SpdSolver::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
    if (!impl_->numeric) throw SolverError("Cholesky: solve without a factor");
    Eigen::MatrixXd result;
    impl_->single.solve(B, result);
    return result;
}

long SpdSolver::num_factor_entries() const {
    return impl_->factor ? static_cast<long>(impl_->factor->is_super ? impl_->factor->xsize : impl_->factor->nzmax) : 0;
}

}  // namespace strake
