#include "bench/coarse_to_fine/problems.hpp"

#include "bench/coarse_to_fine/makers.hpp"
#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"

namespace strake::evidence {
namespace {

using Maker = EvidenceProblem (*)(int, Draw&);
const std::vector<std::pair<std::string, Maker>>& makers() {
    static const std::vector<std::pair<std::string, Maker>> all{{"wing", wing_recovery},
                                                                {"lifting_body", lifting_body_recovery},
                                                                {"fuselage_nacelle", fuselage_recovery},
                                                                {"bent_tube", bent_tube},
                                                                {"blob", blob},
                                                                {"bunny_like", bunny_like},
                                                                {"volume_under_area", lifting_body_volume},
                                                                {"volume_under_limits", wing_under_limits},
                                                                {"local_bump", local_bump},
                                                                {"global_twist", global_twist},
                                                                {"noisy", noisy},
                                                                {"many_minima", many_minima}};
    return all;
}

}  // namespace

const std::vector<std::string>& problem_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const auto& maker : makers()) all.push_back(maker.first);
        return all;
    }();
    return names;
}

std::vector<Method> methods_of(const EvidenceProblem& evidence) {
    if (evidence.has_gradients) return {Method::sqp, evidence.second};
    // bobyqa knows no constraints.
    if (evidence.problem.constraints.empty()) return {Method::sqp, Method::model, Method::cobyla, Method::bobyqa};
    return {Method::sqp, Method::model, Method::cobyla};
}

EvidenceProblem with_displacement_fields(EvidenceProblem evidence, std::vector<int> steps) {
    Problem& problem = evidence.problem;
    FieldConditions conditions;
    conditions.held = problem.fixed;
    FieldOptions options;
    options.number = steps.back();
    const auto fields = std::make_shared<const DisplacementFields>(problem.surface, conditions, options);
    for (int& step : steps) step = std::min(step, fields->size());
    steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
    add_fields(problem.parameters, fields);
    problem.parameters.field_steps = std::move(steps);
    return evidence;
}

EvidenceProblem without_gradients(EvidenceProblem evidence) {
    evidence.has_gradients = false;
    evidence.problem.optimize.finite_differences = true;
    for (Quantity& quantity : evidence.problem.quantities) {
        quantity.has_sensitivities = false;
        quantity.residuals = nullptr;
        quantity.evaluate = [values = quantity.evaluate](const QuantityRequest& request) {
            QuantityRequest without = request;
            without.want_sensitivities = false;
            return values(without);
        };
    }
    return evidence;
}

EvidenceProblem make_problem(const std::string& name, int triangles, unsigned seed) {
    const auto& all = makers();
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].first == name) {
            Draw draw(1000 * seed + i);
            return all[i].second(triangles, draw);
        }
    throw InvalidInput(text("no problem is called '", name, "'"));
}

}  // namespace strake::evidence
