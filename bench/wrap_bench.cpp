#include "bench/four_patches.hpp"
#include "cases/geometry/lifting_body.hpp"
#include "objectives/geometry/shape_change.hpp"

#include <benchmark/benchmark.h>

#include <cmath>
#include <stdexcept>

/// One evaluation with its gradients, all within it: equilibrium from that of a neighbour design, the body's shape,
/// guard, motion limit, volume, area and mean motion, and one adjoint. A lifting body by its own shell, and by a wrap:
/// there a million triangles may cost twice what 131 000 cost with the shell.
namespace {

using namespace strake;

struct Evaluated {
    Problem problem;
    std::unique_ptr<ShapeEvaluator> evaluator;
    Eigen::VectorXd x;
    int number = 0;

    Evaluated(int triangles, bool by_wrap) {
        const TriMesh body = example::lifting_body(triangles);
        problem = four_patches(body, by_wrap ? std::make_shared<const WrapMap>(wrap_around(body).mesh, body) : nullptr);
        problem.quantities.push_back(displacement("motion", body));
        problem.parameters.max_displacement = 0.1;
        const auto rest = rest_facts(problem);
        const DesignSpace space = design_space(rest, 1);
        evaluator =
            std::make_unique<ShapeEvaluator>(problem, rest, std::vector<std::string>{"volume", "area", "motion"});
        evaluator->limit_motion();
        evaluator->enter(space);
        x = Eigen::VectorXd::Constant(space.size(), 0.1);
        next();  // builds the shell
    }

    /// Steps of a fiftieth of the variables' unit, as of a run that closes in.
    void next() {
        for (int j = 0; j < x.size(); ++j) x[j] += 0.02 * std::sin(1.0 + 3 * number + j);
        ShapeEvaluation at = evaluator->evaluate(x, ++number);
        if (at.status != EvaluationStatus::ok) throw std::runtime_error(at.reason);
        evaluator->differentiate(at);
        evaluator->accept();
        benchmark::DoNotOptimize(at.gradients.data());
    }
};

void evaluation(benchmark::State& state, bool by_wrap) {
    Evaluated body(static_cast<int>(state.range(0)), by_wrap);
    for (auto _ : state) body.next();
}
BENCHMARK_CAPTURE(evaluation, shell, false)->Arg(131000)->Iterations(8)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(evaluation, wrap, true)->Arg(131000)->Arg(1000000)->Iterations(8)->Unit(benchmark::kMillisecond);

}  // namespace
