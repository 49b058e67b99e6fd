// What a wrap adds to gradients: wrap_adjoint FILE|KIND...   (a kind of make_surface; none: gaps and crossing_boxes)
// Each row: vertices of body and wrap; milliseconds, the least of fifteen, of the gradients of volume and area, of
// those of six functionals, of one shape (equilibrium, guard and values; mean of six), each by the wrap and by a shell
// on the wrap alone, as a body without one.
#include "bench/dirty_bodies.hpp"
#include "bench/four_patches.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

using namespace strake;

namespace {

double milliseconds() { return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Times {
    double two = 0, six = 0, shape = 0;
};

Times times(const TriMesh& surface, std::shared_ptr<const WrapMap> wrap) {
    const Problem problem = four_patches(surface, std::move(wrap));
    const auto rest = rest_facts(problem);
    const DesignSpace space = design_space(rest, 1);
    ShapeEvaluator evaluator(problem, rest, std::vector<std::string>{"volume"});
    evaluator.enter(space);
    Times found;
    ShapeEvaluation at;
    constexpr int shapes = 6, repetitions = 15;
    for (int i = 0; i <= shapes; ++i) {
        Eigen::VectorXd x(space.size());
        for (int j = 0; j < space.size(); ++j) x[j] = 0.05 * std::sin(1.0 + 3 * i + j);
        const double begin = milliseconds();
        at = evaluator.evaluate(x, i + 1);
        if (i > 0) found.shape += (milliseconds() - begin) / shapes;  // the first one builds the shell
        if (at.status != EvaluationStatus::ok) throw InvalidInput(at.reason);
    }
    const auto least = [&](const ShapeEvaluation& shape) {
        double min_time = 1e300;
        for (int i = 0; i < repetitions; ++i) {
            ShapeEvaluation again = shape;
            const double begin = milliseconds();
            evaluator.differentiate(again);
            min_time = std::min(min_time, milliseconds() - begin);
        }
        return min_time;
    };
    const TriMesh now = with_vertices(surface, at.vertices);
    at.dJ_dv.clear();
    for (const Quantity& quantity : problem.quantities)
        at.dJ_dv.push_back(quantity.evaluate({now, true, 1, 1, {}}).dJ_dv.at(0));
    at.dJ_dp.assign(6, Eigen::VectorXd());
    found.two = least(at);
    for (std::size_t k = 0; k < 4; ++k) at.dJ_dv.emplace_back(at.dJ_dv[k % 2].array().sin().matrix());
    found.six = least(at);
    return found;
}

void row(const std::string& name, const TriMesh& body) {
    const TriMesh around = wrap_around(body).mesh;
    const Times by_wrap = times(body, std::make_shared<const WrapMap>(around, body)), alone = times(around, nullptr);
    std::printf("%-24s %7d %6d  two %6.1f %6.1f ms (%.2f), six %6.1f %6.1f ms (%.2f), shape %6.1f %6.1f ms (%.2f)\n",
                name.c_str(), body.num_vertices(), around.num_vertices(), by_wrap.two, alone.two,
                by_wrap.two / alone.two, by_wrap.six, alone.six, by_wrap.six / alone.six, by_wrap.shape, alone.shape,
                by_wrap.shape / alone.shape);
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) { return table_of_bodies(argc, argv, {"gaps", "crossing_boxes"}, row); }
