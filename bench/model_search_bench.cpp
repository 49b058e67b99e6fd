#include "optimize/nlp/minimizer.hpp"
#include "optimize/nlp/surrogate/spread.hpp"

#include <benchmark/benchmark.h>
#include <Eigen/Cholesky>
#include <cmath>

/// What the search by models itself costs beside what it asks: forty evaluations in five batches where 200 designs are
/// known already, as late in a long run. The objective is a smooth valley; two limits are told by the program, as if by
/// a solver, or known exactly with their slopes.
namespace {

using namespace strake;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int num_known = 200, num_evaluations = 40;

/// A smooth coupling of neighbours.
MatrixXd coupled(int n, double how) {
    MatrixXd metric = MatrixXd::Identity(n, n);
    for (int i = 0; i + 1 < n; ++i) metric(i, i + 1) = metric(i + 1, i) = how;
    return metric;
}

NonlinearProgram valley(int n, bool has_exact_limits) {
    NonlinearProgram p;
    p.start = VectorXd::Zero(n);
    p.lower = VectorXd::Constant(n, -1);
    p.upper = VectorXd::Constant(n, 1);
    p.metric = n * 0.1 * coupled(n, 0.3);
    p.num_inequalities = 2;
    const MatrixXd M = coupled(n, 0.2);
    const VectorXd aim = VectorXd::LinSpaced(n, 0.1, 0.5), slope = VectorXd::LinSpaced(n, 1, -0.5) / n;
    const auto values = [=](const VectorXd& x) {
        const VectorXd off = x - aim;
        Evaluation at;
        at.objective = off.dot(M * off) + 0.1 * std::pow(off.sum(), 2) / n;
        at.constraints.resize(2);
        at.constraints << x.squaredNorm() / n - 0.02, slope.dot(x) + 0.1 * x.dot(M * x) / n - 0.01;
        return at;
    };
    p.evaluate = values;
    std::vector<KnownPoint> known;
    const MatrixXd cube = sobol_points(1, num_known, n);
    for (Eigen::Index i = 0; i < cube.rows(); ++i) {
        const VectorXd x = 0.2 * (cube.row(i).transpose().array() - 0.5);
        known.push_back({x, values(x)});
    }
    p.known = [=] { return known; };
    if (!has_exact_limits) return p;
    NonlinearProgram cheap = p;
    cheap.known = nullptr;
    cheap.differentiate = [=](const VectorXd& x, Evaluation& at) {
        at.gradient = VectorXd::Zero(n);
        at.jacobian.resize(2, n);
        at.jacobian << 2 * x.transpose() / n, (slope + 0.2 * (M * x) / n).transpose();
    };
    p.low_fidelity = LowFidelity{std::make_shared<const NonlinearProgram>(cheap),
                                 {LowFidelityValue::none, LowFidelityValue::same, LowFidelityValue::same},
                                 nullptr};
    return p;
}

void search(benchmark::State& state) {
    const NonlinearProgram p = valley(static_cast<int>(state.range(0)), state.range(1) != 0);
    MinimizeOptions how;
    how.method = Method::model;
    how.max_evaluations = 1 + num_evaluations;
    how.confirm = false;
    how.minima_in_variables = state.range(2) != 0;
    double objective = 0;
    for (auto _ : state) objective = minimize(p, how).best.objective;
    state.counters["objective"] = objective;
}
BENCHMARK(search)
    ->ArgsProduct({{60, 192, 372}, {0, 1}, {0, 1}})
    ->ArgNames({"variables", "exact", "before"})
    ->Unit(benchmark::kMillisecond);

}  // namespace
