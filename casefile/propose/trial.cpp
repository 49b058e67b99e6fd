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
    for (int level = coarsest_level(rest->parameters); level < static_cast<int>(rest->tree->levels.size()); ++level) {
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
        ShapeEvaluator evaluator(problem, rest, {});
        evaluator.keep_calls(nullptr, [&] { return seconds() > max_seconds; });
        evaluator.enter(space);
        for (int k = 0; k < 2 * num_probes; ++k) {
            if (seconds() > max_seconds) throw Interrupted{};
            const int variable = (k / 2) * space.num_shape() / num_probes;
            Eigen::VectorXd x = Eigen::VectorXd::Zero(space.size());
            x[variable] = k % 2 == 0 ? probe_size : -probe_size;
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
