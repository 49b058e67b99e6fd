#include "core/primo/preconditioner.hpp"

namespace strake {
namespace {

constexpr int few_solves = 4;            // a factor pays from here on
constexpr int large_for_few = 10000;     // prisms from which multigrid is faster for a solve or two
constexpr int large = 300000;            // prisms from which the factor takes more than 2 GB
constexpr double thin = 1.5;             // prism heights, in edge lengths, below which multigrid needs more iterations
constexpr int large_for_thin = 1000000;  // prisms from which it is taken all the same

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

void Preconditioner::use(LinearSolver solver, double height_in_edges) {
    solver_ = solver;
    multigrid_ = Multigrid(options_for(height_in_edges));
    has_clusters_ = false;
}

void Preconditioner::analyze(const BlockMatrix& H) {
    has_clusters_ = false;
    if (is_exact()) factor_.analyze(H);
}

bool Preconditioner::build(const BlockMatrix& H, const Points& centre) {
    if (is_exact()) return factor_.factorize(H);
    const bool built = has_clusters_ ? multigrid_.update(H, centre) : multigrid_.setup(H, centre);
    has_clusters_ = has_clusters_ || built;
    return built;
}

void Preconditioner::drop() {
    factor_.drop_factor();
    multigrid_.drop();
}

Eigen::MatrixXd Preconditioner::apply(const Eigen::Ref<const Eigen::MatrixXd>& B, Cycle kind) {
    if (is_exact()) return factor_.solve(B);
    if (B.cols() == 1) return multigrid_.apply(B.col(0), kind);
    Eigen::MatrixXd X(B.rows(), B.cols());
    for (Eigen::Index c = 0; c < B.cols(); ++c) X.col(c) = multigrid_.apply(B.col(c), kind);
    return X;
}

long Preconditioner::num_entries() const {
    return is_exact() ? factor_.num_factor_entries() : static_cast<long>(multigrid_.bytes() / sizeof(float));
}

}  // namespace strake
