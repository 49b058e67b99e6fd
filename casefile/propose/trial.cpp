#include "casefile/propose/trial.hpp"

#include "core/error.hpp"
#include "optimize/evaluate/evaluation.hpp"

#include <ctime>

namespace strake {
namespace {

constexpr double probe_size = 0.1;  ///< thin wings bear it, slivers do not
constexpr int num_probes = 3;
constexpr double joint_size = 0.3;  ///< of neighbours against each other, around a dirty body

std::vector<int> patch_variables(const DesignSpace& space) {
    std::vector<int> of_patches;
    for (int j = 0; j < space.num_shape(); ++j)
        if (space.variables[static_cast<std::size_t>(j)].patch >= 0) of_patches.push_back(j);
    return of_patches;
}

/// The first level with variables of patches, which are what may fail; around a dirty body the last one, whose motions
/// are the roughest. Without a shell that of the fields.
DesignSpace tried_space(const std::shared_ptr<const RestFacts>& rest) {
    const int levels = static_cast<int>(rest->tree->levels.size());
    for (int k = 1; rest->has_shell && k < levels; ++k) {
        DesignSpace space = design_space(rest, rest->wrap ? levels - k : k);
        if (!patch_variables(space).empty()) return space;
    }
    for (int level = coarsest_level(rest->parameters); level < levels; ++level) {
        DesignSpace space = design_space(rest, level);
        if (space.num_shape() > 0 && !rest->wrap) return space;
    }
    throw InvalidInput("no variable can move it");
}

/// The k-th design: a variable alone, or all of them, one up and the next one down; odd ones are the even ones
/// reversed.
Eigen::VectorXd probe(const std::vector<int>& probed, int k, Eigen::Index size) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(size);
    const double sign = k % 2 == 0 ? 1 : -1;
    if (k < 2 * num_probes)
        x[probed[static_cast<std::size_t>(k / 2) * probed.size() / num_probes]] = sign * probe_size;
    else
        for (std::size_t i = 0; i < probed.size(); ++i) x[probed[i]] = (i % 2 == 0 ? sign : -sign) * joint_size;
    return x;
}

}  // namespace

Trial try_deformations(Problem problem, double max_work) {
    Trial trial;
    problem.quantities.clear();
    const std::clock_t begin = std::clock();
    const double triangles = elastic_surface(problem).num_triangles();
    double work = 0;
    try {
        const std::shared_ptr<const RestFacts> rest = rest_facts(problem);
        const DesignSpace space = tried_space(rest);
        std::vector<int> probed = patch_variables(space);
        for (int j = 0; probed.empty() && j < space.num_shape(); ++j) probed.push_back(j);
        ShapeEvaluator evaluator(problem, rest, {});
        evaluator.keep_calls(nullptr, [&] { return (work += triangles) > max_work; });
        evaluator.enter(space);
        for (int k = 0; k < 2 * (rest->wrap ? num_probes + 1 : num_probes); ++k) {
            if (work > max_work) throw Interrupted{};
            const ShapeEvaluation shape = evaluator.evaluate(probe(probed, k, space.size()), k + 1);
            ++trial.tried;
            if (shape.status == EvaluationStatus::ok) continue;
            if (trial.failed++ == 0) trial.reason = shape.reason;
            if (trial.failed == 2) break;  // no more can make it sound, and one tells little of how much fails
        }
    } catch (const Interrupted&) {
        trial.is_cut_short = true;
    } catch (const std::runtime_error& error) {
        trial.tried = trial.failed = 2 * num_probes;
        trial.reason = error.what();
    } catch (const std::invalid_argument& error) {
        trial.tried = trial.failed = 2 * num_probes;
        trial.reason = error.what();
    }
    trial.cpu_seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    return trial;
}

}  // namespace strake
