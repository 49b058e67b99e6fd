#include "core/primo/linear/multigrid.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/primo/linear/multigrid_levels.hpp"
#include "core/primo/linear/vectors.hpp"

namespace strake {

struct Multigrid::Impl {
    MultigridOptions options;
    std::vector<Clusters> clusters;  ///< of the last `setup`
    std::unique_ptr<Hierarchy<float>> single;
    std::unique_ptr<Hierarchy<double>> double_precision;  ///< if single precision fails

    template <class Real>
    bool build(std::unique_ptr<Hierarchy<Real>>& levels, const BlockMatrix& A, const Points& centre, bool keep) {
        const std::vector<Clusters> before = keep ? std::move(clusters) : std::vector<Clusters>();
        auto built = std::make_unique<Hierarchy<Real>>(options);  // assigned only when complete
        const bool done = built->build(A, centre, keep ? &before : nullptr);
        clusters = keep ? before : done ? built->take_clusters() : std::vector<Clusters>();
        if (done) levels = std::move(built);
        return done;
    }

    bool build(const BlockMatrix& A, const Points& centre, bool keep, bool in_double) {
        if (centre.rows() != A.size())
            throw InvalidInput(text("multigrid: ", centre.rows(), " centres for ", A.size(), " block rows"));
        if (A.size() == 0) throw InvalidInput("multigrid: the matrix has no rows");
        if (!A.is_finite())
            throw SolverError(text("multigrid: the matrix of ", 6 * A.size(), " unknowns is not finite"));
        const bool was_double = double_precision != nullptr;
        single.reset();
        double_precision.reset();
        // Long thin parts bend so softly that in single precision they look indefinite.
        if (!(keep && was_double) && build(single, A, centre, keep)) return true;
        return in_double && build(double_precision, A, centre, keep && was_double);
    }
};

Multigrid::Multigrid(const MultigridOptions& options) : impl_(std::make_unique<Impl>()) { impl_->options = options; }
Multigrid::~Multigrid() = default;
Multigrid::Multigrid(Multigrid&&) noexcept = default;
Multigrid& Multigrid::operator=(Multigrid&&) noexcept = default;

bool Multigrid::setup(const BlockMatrix& A, const Points& centre, bool in_double) {
    return impl_->build(A, centre, false, in_double);
}

bool Multigrid::update(const BlockMatrix& A, const Points& centre) {
    return impl_->build(
        A, centre, !impl_->clusters.empty() && static_cast<int>(impl_->clusters.front().of.size()) == A.size(), true);
}

bool Multigrid::is_ready() const { return impl_->single || impl_->double_precision; }
bool Multigrid::is_single_precision() const { return impl_->single != nullptr; }
void Multigrid::drop() {
    impl_->single.reset();
    impl_->double_precision.reset();
}

std::vector<int> Multigrid::level_sizes() const {
    std::vector<int> sizes;
    if (impl_->single)
        for (const auto& level : impl_->single->levels()) sizes.push_back(level.A.size());
    if (impl_->double_precision)
        for (const auto& level : impl_->double_precision->levels()) sizes.push_back(level.A.size());
    return sizes;
}

std::size_t Multigrid::bytes() const {
    return (impl_->single ? impl_->single->bytes() : 0) +
           (impl_->double_precision ? impl_->double_precision->bytes() : 0);
}

double Multigrid::cycle_work() const {
    return impl_->single             ? impl_->single->cycle_work()
           : impl_->double_precision ? impl_->double_precision->cycle_work()
                                     : 0;
}

Eigen::VectorXd Multigrid::apply(const Eigen::Ref<const Eigen::VectorXd>& r, Cycle kind) {
    if (impl_->single) return impl_->single->apply(r, kind);
    if (impl_->double_precision) return impl_->double_precision->apply(r, kind);
    throw SolverError("multigrid: applied without levels");
}

KrylovResult Multigrid::solve(const BlockMatrix& A, const Eigen::VectorXd& b, double tolerance, int max_iterations) {
    return flexible_conjugate_gradients([&](const Eigen::VectorXd& x) { return A.multiply(x); },
                                        [&](const Eigen::VectorXd& r) { return apply(r); }, b, tolerance,
                                        max_iterations);
}

KrylovResult flexible_conjugate_gradients(const LinearMap& A, const LinearMap& preconditioner, const Eigen::VectorXd& b,
                                          double tolerance, int max_iterations) {
    KrylovResult result;
    result.x = Eigen::VectorXd::Zero(b.size());
    const double target = tolerance * b.norm();
    Eigen::VectorXd r = b, p, before;
    double rz = 0;
    while (result.iterations < max_iterations && r.norm() > target) {
        const Eigen::VectorXd z = preconditioner(r);
        const double next = dot(z, r);
        if (result.iterations == 0)
            p = z;
        else
            scale_and_add(p, (next - dot(z, before)) / rz, z);
        rz = next;
        const Eigen::VectorXd Ap = A(p);
        const double curvature = dot(p, Ap);
        if (!(curvature > 0)) {
            result.positive = false;
            break;
        }
        before = r;
        const double length = dot(p, r) / curvature;
        add_multiple(result.x, length, p);
        add_multiple(r, -length, Ap);
        ++result.iterations;
    }
    result.relative_residual = b.norm() > 0 ? r.norm() / b.norm() : 0;
    return result;
}

}  // namespace strake
