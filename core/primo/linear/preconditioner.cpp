#include "core/primo/linear/preconditioner.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

constexpr int few_solves = 4;            // a factor pays from here on
constexpr int large_for_few = 10000;     // prisms from which multigrid is faster for a solve or two
constexpr int large = 300000;            // prisms from which the factor takes more than 2 GB
constexpr double thin = 1.5;             // prism heights, in edge lengths, below which multigrid needs more iterations
constexpr int large_for_thin = 1000000;  // prisms from which it is used anyway

// Costs in products of 6x6 blocks per prism, in single precision, the unit of multigrid's cycles: 10 ns each.
// Measured on ten surfaces of 11 000 to 131 000 triangles, each within a third.
constexpr double ordering_price = 640, substitution_price = 50;
constexpr double setup_price = 8;    // cycles
constexpr double usual_cycles = 60;  // of a cold solve, with its later set-ups
constexpr double usual_factors = 1.5, usual_substitutions = 20;
constexpr double clearly = 1.2;  // cost ratio: a smaller advantage does not justify a change midway
constexpr int cycles_for_substitution = 3, max_kept = 20;  // of a kept factor, relative to kept cycles

double factor_price(int prisms) { return 1380 + 2.7 * std::sqrt(prisms); }  // nested dissection of a surface

}  // namespace

LinearSolver Preconditioner::choose(LinearSolver wanted, int prisms, double height_in_edges, int expected_solves) {
    if (wanted != LinearSolver::automatic) return wanted;
    if (height_in_edges < thin) return prisms >= large_for_thin ? LinearSolver::multigrid : LinearSolver::direct;
    const int from = expected_solves < few_solves ? large_for_few : large;
    return prisms >= from ? LinearSolver::multigrid : LinearSolver::direct;
}

MultigridOptions Preconditioner::options_for(double height_in_edges) {
    MultigridOptions options;
    if (height_in_edges >= thin) return options;
    options.first_radius = 1;
    options.prolongation_steps = 2;
    options.smoothing_steps = 4;
    options.smoothed_share = 0.07;
    options.inner_tolerance = 0;
    options.direct_size = 2000;
    return options;
}

void Preconditioner::use(LinearSolver solver, double height_in_edges, bool may_change) {
    solver_ = solver;
    may_change_ = may_change;
    cycles_ = 0;
    regret_ = 0;
    multigrid_ = Multigrid(options_for(height_in_edges));
    has_clusters_ = false;
}

void Preconditioner::analyze(const BlockMatrix& H) {
    has_clusters_ = false;
    if (is_exact()) factor_.analyze(H);
}

/// Extra cost of the cycles since the last set-up, compared with a factor.
void Preconditioner::count_regret(int prisms) {
    const double substitutions = std::min(cycles_ / cycles_for_substitution, max_kept);
    const double spent = (setup_price + cycles_) * multigrid_.cycle_work() / prisms;
    regret_ += std::max(0.0, spent - factor_price(prisms) - substitutions * substitution_price);
}

/// From multigrid to a factor of H.
bool Preconditioner::change(const BlockMatrix& H) {
    use(LinearSolver::direct, thin);
    analyze(H);
    return factor_.factorize(H);
}

/// The first time, when the cost of a cycle becomes known: one-directional strong connections give small clusters, and
/// double precision doubles the cost.
bool Preconditioner::set_up(const BlockMatrix& H, const Points& centre, bool can_change) {
    has_clusters_ = multigrid_.setup(H, centre, !can_change);
    cycles_ = 0;
    if (!can_change) return has_clusters_;
    if (!has_clusters_) return change(H);
    const double foreseen = usual_cycles * multigrid_.cycle_work() / H.size();
    const double by_factors =
        ordering_price + usual_factors * factor_price(H.size()) + usual_substitutions * substitution_price;
    return foreseen > clearly * by_factors ? change(H) : true;
}

bool Preconditioner::build(const BlockMatrix& H, const Points& centre) {
    if (is_exact()) return factor_.factorize(H);
    const bool can_change = may_change_ && H.size() < large;
    if (!has_clusters_) return set_up(H, centre, can_change);
    if (can_change && multigrid_.is_ready()) count_regret(H.size());
    if (can_change && regret_ > ordering_price) return change(H);
    cycles_ = 0;
    return multigrid_.update(H, centre);
}

void Preconditioner::drop() {
    factor_.drop_factor();
    multigrid_.drop();
}

Eigen::MatrixXd Preconditioner::apply(const Eigen::Ref<const Eigen::MatrixXd>& B, Cycle kind) {
    if (is_exact()) return factor_.solve(B);
    cycles_ += static_cast<int>(B.cols());
    if (B.cols() == 1) return multigrid_.apply(B.col(0), kind);
    Eigen::MatrixXd X(B.rows(), B.cols());
    for (Eigen::Index c = 0; c < B.cols(); ++c) X.col(c) = multigrid_.apply(B.col(c), kind);
    return X;
}

long Preconditioner::num_entries() const {
    return is_exact() ? factor_.num_factor_entries() : static_cast<long>(multigrid_.bytes() / sizeof(float));
}

}  // namespace strake
