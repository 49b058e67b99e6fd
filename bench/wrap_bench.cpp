#include "cases/geometry/lifting_body.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "core/wrap/wrap_map.hpp"
#include "objectives/geometry/measures.hpp"
#include "objectives/geometry/shape_change.hpp"
#include "optimize/evaluate/evaluation.hpp"

#include <benchmark/benchmark.h>

#include <cmath>

/// One evaluation with its gradients, all within it: equilibrium from that of a neighbour design, the body's shape,
/// guard, motion limit, volume, area and mean motion, and one adjoint. A lifting body by its own shell, and finer ones
/// carried by a wrap: what a million triangles may cost is said in the first one's time.
namespace {

using namespace strake;

struct Evaluated {
    Problem problem;
    std::unique_ptr<ShapeEvaluator> evaluator;
    Eigen::VectorXd x;
    int number = 0;

    Evaluated(int triangles, bool by_wrap) {
        problem.surface = example::lifting_body(triangles);
        if (by_wrap)
            problem.wrap =
                std::make_shared<const WrapMap>(wrap_around(problem.surface).mesh, std::as_const(problem.surface));
        const TriMesh& elastic = elastic_surface(problem);
        AutomaticLevels levels;
        levels.patches_per_level = {4};
        problem.tree = segment_automatically(elastic, adjacency(elastic), levels);
        problem.prism_height = Eigen::VectorXd::Constant(elastic.num_vertices(), 0.02 * box_diagonal(elastic));
        (by_wrap ? problem.supports : problem.fixed).push_back(elastic.num_triangles() / 2);
        problem.parameters.kinds = {VariableKind::normal_load};
        problem.parameters.max_displacement = 0.1;
        problem.quantities = {closed_volume(problem.surface), area(true), displacement("motion", problem.surface)};
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
