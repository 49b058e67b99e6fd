#include "bench/coarse_to_fine/problems.hpp"

#include "bench/coarse_to_fine/makers.hpp"
#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"

namespace strake::evidence {
namespace {

using Maker = EvidenceProblem (*)(int, Draw&);
using Makers = std::vector<std::pair<std::string, Maker>>;

const Makers& makers() {
    static const Makers all{{"wing", wing_recovery},
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

const Makers& physical_makers() {
    static const Makers all{{"wave_drag", wave_drag_beside_fuselage}, {"lift_over_drag", newtonian_lift_over_drag},
                            {"bending_energy", min_bending},          {"wing_volume", wing_within_thickness},
                            {"frontal_area", min_frontal_area},       {"section_areas", wanted_section_areas}};
    return all;
}

std::vector<std::string> names_of(const Makers& all) {
    std::vector<std::string> names;
    for (const auto& maker : all) names.push_back(maker.first);
    return names;
}

}  // namespace

const std::vector<std::string>& problem_names() {
    static const std::vector<std::string> names = names_of(makers());
    return names;
}

const std::vector<std::string>& physical_names() {
    static const std::vector<std::string> names = names_of(physical_makers());
    return names;
}

std::vector<Method> methods_of(const EvidenceProblem& evidence) {
    if (evidence.has_gradients) return {Method::sqp, evidence.second};
    // bobyqa knows no constraints.
    if (evidence.problem.constraints.empty()) return {Method::sqp, Method::model, Method::cobyla, Method::bobyqa};
    return {Method::sqp, Method::model, Method::cobyla};
}

EvidenceProblem with_automatic_fields(const EvidenceProblem& evidence) {
    return with_displacement_fields(evidence, {27, 60, 192});
}

EvidenceProblem with_displacement_fields(EvidenceProblem evidence, std::vector<int> steps) {
    Problem& problem = evidence.problem;
    FieldConditions conditions;
    conditions.held = problem.fixed;
    conditions.cut = problem.symmetry;
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

bool is_built_in(const Quantity& quantity) { return !quantity.combination && quantity.program.empty(); }

EvidenceProblem with_programs_by_values(const EvidenceProblem& evidence) {
    EvidenceProblem without = without_gradients(evidence);
    for (std::size_t q = 0; q < evidence.problem.quantities.size(); ++q) {
        const Quantity& quantity = evidence.problem.quantities[q];
        if (is_built_in(quantity)) without.problem.quantities[q] = quantity;
    }
    return without;
}

EvidenceProblem with_objective_by_program(EvidenceProblem evidence) {
    const EvidenceProblem without = without_gradients(evidence);
    auto& quantities = evidence.problem.quantities;
    for (std::size_t q = 0; q < quantities.size(); ++q) {
        const auto& names = quantities[q].names;
        if (std::find(names.begin(), names.end(), evidence.problem.objective) == names.end()) continue;
        quantities[q] = without.problem.quantities[q];
        quantities[q].program = "the objective of " + evidence.name;
    }
    evidence.has_gradients = false;
    evidence.problem.optimize.finite_differences = true;
    return evidence;
}

EvidenceProblem make_problem(const std::string& name, int triangles, unsigned seed) {
    std::uint64_t number = 0;
    for (const Makers& all : {makers(), physical_makers()})
        for (const auto& [known, make] : all) {
            Draw draw(1000 * seed + number++);
            if (known == name) return make(triangles, draw);
        }
    throw InvalidInput(text("no problem is called '", name, "'"));
}

}  // namespace strake::evidence
