#include "optimize/problem/place_user_variables.hpp"

#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/planform/kept_sections.hpp"
#include "core/planform/planform_motion.hpp"

#include <algorithm>
#include <set>

namespace strake {
namespace {

void check_one(const UserVariable& v, int num_triangles) {
    if (v.name.empty()) throw InvalidInput("a user variable has no name");
    if (v.field >= 0 || v.planform >= 0) return;  // checked as a whole
    if (v.triangles.empty()) throw InvalidInput(text("variable ", v.name, ": it has no triangles"));
    for (const int t : v.triangles)
        if (t < 0 || t >= num_triangles)
            throw InvalidInput(text("variable ", v.name, ": triangle ", t, " must be in [0, ", num_triangles, ")"));
    if (!std::is_sorted(v.triangles.begin(), v.triangles.end(), std::less_equal<>()))
        throw InvalidInput(text("variable ", v.name, ": its triangles must be ascending"));
    if (v.traction.rows() > 0 && v.traction.rows() != static_cast<Eigen::Index>(v.triangles.size()))
        throw InvalidInput(
            text("variable ", v.name, ": ", v.traction.rows(), " tractions for ", v.triangles.size(), " triangles"));
    if (!v.traction.allFinite() || !v.motion.rotation.allFinite() || !v.motion.translation.allFinite() ||
        !v.motion.about.allFinite())
        throw InvalidInput(text("variable ", v.name, ": its traction or motion is not finite"));
    const bool is_load = v.traction.rows() > 0;
    if (is_load ? v.traction.isZero(0) : v.motion.rotation.isZero(0) && v.motion.translation.isZero(0))
        throw InvalidInput(text("variable ", v.name, ": its ", is_load ? "traction" : "motion", " is zero"));
    if (!(v.unit >= 0) || !std::isfinite(v.unit))
        throw InvalidInput(text("variable ", v.name, ": unit = ", v.unit, " must be >= 0"));
    if (!(v.max_displacement >= 0) || !std::isfinite(v.max_displacement))
        throw InvalidInput(text("variable ", v.name, ": max_displacement = ", v.max_displacement, " must be >= 0"));
}

void check_fields(const Problem& problem) {
    const std::shared_ptr<const DisplacementFields>& fields = problem.parameters.fields;
    for (const UserVariable& v : problem.parameters.user_variables)
        if (v.field >= (fields ? fields->size() : 0))
            throw InvalidInput(text("variable ", v.name, ": there is no displacement field ", v.field));
    if (!fields) return;
    const std::vector<int>& steps = problem.parameters.field_steps;
    for (std::size_t k = 0; k < steps.size(); ++k)
        if (steps[k] <= (k == 0 ? 0 : steps[k - 1]) || (k + 1 == steps.size() && steps[k] != fields->size()))
            throw InvalidInput(text("field_steps: ", steps[k], " must be above the one before, and the last ",
                                    fields->size(), ", the number of fields"));
    if (fields->num_vertices() != problem.surface.num_vertices())
        throw InvalidInput(text("displacement fields of ", fields->num_vertices(), " vertices for a surface of ",
                                problem.surface.num_vertices()));
}

/// A vertex of what is fixed may not move: changes of wings do not know of it.
void check_planform(const Problem& problem) {
    const std::shared_ptr<const PlanformMotion>& planform = problem.parameters.planform;
    for (const UserVariable& v : problem.parameters.user_variables)
        if (v.planform >= (planform ? planform->size() : 0))
            throw InvalidInput(text("variable ", v.name, ": there is no change of a wing ", v.planform));
    if (const auto& kept = problem.parameters.kept_sections) {
        if (kept->num_vertices() != problem.surface.num_vertices())
            throw InvalidInput(text("kept sections of wings with ", kept->num_vertices(), " vertices for a surface of ",
                                    problem.surface.num_vertices()));
        if (!problem.attached.empty() || problem.parameters.invariance || !problem.fit.empty())
            throw InvalidInput("sections of wings cannot be kept together with attached parts, an invariance or a fit");
    }
    if (!planform) return;
    if (planform->num_vertices() != problem.surface.num_vertices())
        throw InvalidInput(text("changes of wings with ", planform->num_vertices(), " vertices for a surface of ",
                                problem.surface.num_vertices()));
    const auto refuse = [](const char* what) {
        throw InvalidInput(text("parameters.planform is not possible together with ", what));
    };
    if (!problem.attached.empty()) refuse("attach");
    if (problem.parameters.invariance) refuse("invariance");
    if (!problem.fit.empty()) refuse("fit");
    refuse_held(*planform, problem.surface, problem.fixed, "fixed");
    if (problem.wrap) return refuse_held(*planform, problem.surface, problem.still, "strains");
    for (const PrescribedStrain& strain : problem.strains)
        refuse_held(*planform, problem.surface, strain.triangles, "strains");
}

/// Joins the motion of an earlier variable of the same triangles. False: there is none.
bool join_motion(const std::vector<UserVariable>& user, int g, int first, PlacedVariables& placed) {
    for (int other = 0; other < g; ++other) {
        if (placed.motion[other] < 0 || user[other].triangles != user[g].triangles) continue;
        RigidMotion& motion = placed.motions[placed.motion[other] - first];
        for (int k = 0; k < g; ++k)
            if (placed.motion[k] == placed.motion[other] && !user[k].motion.rotation.isZero(0) &&
                !user[g].motion.rotation.isZero(0) && user[k].motion.about != user[g].motion.about)
                throw InvalidInput(text("variables ", user[k].name, " and ", user[g].name,
                                        " turn the same triangles about different points"));
        if (!user[g].motion.rotation.isZero(0)) motion.about = user[g].motion.about;
        placed.motion[g] = placed.motion[other];
        placed.pinned[g] = placed.pinned[other];
        return true;
    }
    return false;
}

void pin_motion(const std::vector<UserVariable>& user, int g, int first, std::vector<int>& pins,
                PlacedVariables& placed) {
    if (join_motion(user, g, first, placed)) return;
    const UserVariable& v = user[g];
    const int number = first + static_cast<int>(placed.motions.size());
    int fixed = 0;
    for (const int t : v.triangles) {
        int& pin = pins[t];
        if (pin > 0) throw InvalidInput(text("variable ", v.name, ": triangle ", t, " follows another motion already"));
        if (pin == fixed_prism) {
            ++fixed;
            continue;
        }
        pin = number + 1;
        placed.pinned[g].push_back(t);
    }
    if (placed.pinned[g].empty()) throw InvalidInput(text("variable ", v.name, ": all of its triangles are fixed"));
    if (fixed > 0)
        placed.warnings.push_back(
            text("variable ", v.name, ": ", fixed, " of its triangles are fixed as well and stay fixed"));
    placed.motions.push_back({{0, 0, 0}, {0, 0, 0}, v.motion.about});
    placed.motion[g] = number;
}

}  // namespace

void refuse_held(const PlanformMotion& planform, const TriMesh& surface, const std::vector<int>& triangles,
                 const std::string& what) {
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(planform.size());
    for (int j = 0; j < planform.size(); ++j) {
        const Points moved = planform.derivative(none, j);
        for (const int t : triangles)
            for (const int v : surface.triangles.row(t))
                if (!moved.row(v).isZero(0))
                    throw InvalidInput(text(planform.variables()[static_cast<std::size_t>(j)].name, " moves vertex ", v,
                                            ", which is under ", what,
                                            "; leave those triangles out of the wing (planform: {wing: {on: all - "
                                            "root}}), or use hold: point"));
    }
}

void add_fields(Parameters& parameters, std::shared_ptr<const DisplacementFields> fields) {
    for (int b = 0; b < fields->size(); ++b) {
        UserVariable variable;
        variable.name = fields->name(b);
        variable.field = b;
        parameters.user_variables.push_back(std::move(variable));
    }
    parameters.fields = std::move(fields);
}

void add_planform(Parameters& parameters, std::shared_ptr<const PlanformMotion> planform) {
    for (int j = 0; j < planform->size(); ++j) {
        const PlanformMotion::Variable& change = planform->variables()[static_cast<std::size_t>(j)];
        UserVariable variable;
        variable.name = change.name;
        variable.planform = j;
        variable.unit = std::max(-change.lower, change.upper);
        parameters.user_variables.push_back(std::move(variable));
    }
    parameters.planform = std::move(planform);
}

PlacedVariables place_user_variables(const Problem& problem, int first, std::vector<int>& pin) {
    const auto& user = problem.parameters.user_variables;
    PlacedVariables placed;
    placed.motion.assign(user.size(), -1);
    placed.pinned.assign(user.size(), {});
    check_fields(problem);
    check_planform(problem);
    std::set<std::string> names;
    for (std::size_t g = 0; g < user.size(); ++g) {
        check_one(user[g], static_cast<int>(pin.size()));
        if (!names.insert(user[g].name).second)
            throw InvalidInput(text("two user variables are called '", user[g].name, "'"));
        if (user[g].traction.rows() == 0 && user[g].field < 0 && user[g].planform < 0)
            pin_motion(user, static_cast<int>(g), first, pin, placed);
    }
    return placed;
}

}  // namespace strake
