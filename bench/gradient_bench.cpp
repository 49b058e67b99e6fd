#include "cases/geometry/wing.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "objectives/geometry/measures.hpp"
#include "optimize/evaluate/evaluation.hpp"

#include <benchmark/benchmark.h>

/// What a gradient costs beside its deformation, by the number of design variables: vertex sensitivities of the
/// objective, one adjoint solve, and the projection on the variables. A wing with vector loads, at a shape that is
/// moved by some percent of the diagonal.
namespace {

using namespace strake;

struct Deformed {
    Problem problem;
    std::unique_ptr<ShapeEvaluator> evaluator;
    ShapeEvaluation at;

    Deformed(int triangles, int variables) {
        problem.surface = example::wing(triangles);
        AutomaticLevels levels;
        levels.patches_per_level = {std::max(2, variables / 3)};
        problem.tree = segment_automatically(problem.surface, adjacency(problem.surface), levels);
        problem.prism_height =
            Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.02 * box_diagonal(problem.surface));
        const Points c = triangle_centroids(problem.surface);
        for (int t = 0; t < problem.surface.num_triangles(); ++t)
            if (c(t, 1) < 0.02) problem.fixed.push_back(t);
        problem.symmetry = SymmetryPlane{{0, 1, 0}, 0};
        problem.quantities = {volume(problem.surface, problem.symmetry), area()};
        const auto rest = rest_facts(problem);
        const DesignSpace space = design_space(rest, 1);
        evaluator = std::make_unique<ShapeEvaluator>(problem, rest, std::vector<std::string>{"volume"});
        evaluator->enter(space);
        Eigen::VectorXd x(space.size());
        for (int j = 0; j < space.size(); ++j) x[j] = 0.3 * std::sin(1.0 + j) / std::sqrt(double(space.size()));
        at = evaluator->evaluate(x, 1);
        if (at.status != EvaluationStatus::ok) throw std::runtime_error(at.reason);
    }
};

void gradient(benchmark::State& state) {
    Deformed wing(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
    const TriMesh surface = with_vertices(wing.problem.surface, wing.at.vertices);
    wing.evaluator->differentiate(wing.at);  // what is built on the first call of a run stays outside
    for (auto _ : state) {
        ShapeEvaluation again = wing.at;
        again.dJ_dv = wing.problem.quantities[0].evaluate({surface, true, 1, 1, {}}).dJ_dv;
        wing.evaluator->differentiate(again);
        benchmark::DoNotOptimize(again.gradients.data());
    }
    state.counters["variables"] = wing.evaluator->space().size();
}
BENCHMARK(gradient)
    ->ArgsProduct({{5000, 22000}, {10, 100, 1000}})
    ->ArgNames({"triangles", "variables"})
    ->Unit(benchmark::kMillisecond);

}  // namespace
