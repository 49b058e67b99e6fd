#include "casefile/propose/trial.hpp"

#include "core/error.hpp"
#include "optimize/evaluate/evaluation.hpp"

#include <chrono>

namespace strake {
namespace {

constexpr double probe_size = 0.1;  ///< thin wings bear it, slivers do not
constexpr int num_probes = 3;

/// The first level that has variables of shape.
DesignSpace first_space(const std::shared_ptr<const RestFacts>& rest) {
    const int first = rest->wrap ? 1 : coarsest_level(rest->parameters);  // fields beside a wrap are the safe part
    for (int level = first; level < static_cast<int>(rest->tree->levels.size()); ++level) {
        DesignSpace space = design_space(rest, level);
        if (space.num_shape() > 0) return space;
    }
    throw InvalidInput("no variable can move it");
}

}  // namespace

Trial try_deformations(Problem problem, double max_seconds) {
    Trial trial;
    problem.quantities.clear();
    const auto begin = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    try {
        const std::shared_ptr<const RestFacts> rest = rest_facts(problem);
        const DesignSpace space = first_space(rest);
        std::vector<int> probed;
        for (int j = 0; j < space.num_shape(); ++j)
            if (!rest->wrap || space.variables[static_cast<std::size_t>(j)].patch >= 0) probed.push_back(j);
        if (probed.empty()) throw InvalidInput("no variable of a patch can move it");
        ShapeEvaluator evaluator(problem, rest, {});
        evaluator.keep_calls(nullptr, [&] { return seconds() > max_seconds; });
        evaluator.enter(space);
        for (int k = 0; k < 2 * num_probes; ++k) {
            if (seconds() > max_seconds) throw Interrupted{};
            Eigen::VectorXd x = Eigen::VectorXd::Zero(space.size());
            x[probed[static_cast<std::size_t>(k / 2) * probed.size() / num_probes]] =
                k % 2 == 0 ? probe_size : -probe_size;
            const ShapeEvaluation shape = evaluator.evaluate(x, k + 1);
            ++trial.tried;
            if (shape.status == EvaluationStatus::ok) continue;
            if (trial.failed++ == 0) trial.reason = shape.reason;
            if (6 * trial.failed > 2 * num_probes) break;  // no more can make it sound
        }
    } catch (const Interrupted&) {
        trial.is_out_of_time = true;
    } catch (const std::runtime_error& error) {
        trial.tried = trial.failed = 2 * num_probes;
        trial.reason = error.what();
    } catch (const std::invalid_argument& error) {
        trial.tried = trial.failed = 2 * num_probes;
        trial.reason = error.what();
    }
    trial.seconds = seconds();
    return trial;
}

}  // namespace strake
