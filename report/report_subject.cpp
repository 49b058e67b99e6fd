#include "report/report_subject.hpp"
#include "casefile/schema/scalars.hpp"
#include "core/patches/carried.hpp"
#include "core/text/file.hpp"
#include "core/wrap/wrap_map.hpp"

#include "core/mesh/geometry.hpp"
#include "optimize/nlp/program/methods.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace strake {
namespace {

std::string number(double value) { return fmt::format("{:.6g}", value); }

std::string length(const Length& l, const std::string& units) {
    return l.is_relative_to_diagonal ? number(100 * l.value) + " % of the diagonal" : number(l.value) + " " + units;
}

std::string limit_words(const Constraint& c) {
    const std::string of_start = c.relative ? " × start" : "";
    std::vector<std::string> words;
    if (c.equals) words.push_back("= " + number(*c.equals) + of_start);
    if (c.min) words.push_back("≥ " + number(*c.min) + of_start);
    if (c.max) words.push_back("≤ " + number(*c.max) + of_start);
    return joined(words, " and ");
}

std::string names(const std::vector<Reference>& references) {
    std::vector<std::string> words;
    for (const Reference& reference : references) words.push_back(reference.name);
    return joined(words);
}

std::string method_words(const OptimizeOptions& options) {
    if (options.chooses_method) return "auto";  // what it chose is in the log
    const MethodFacts& method = method_facts(options.method);
    return method.method == Method::model ? fmt::format("{}, batches of {}", method.name, options.batch) : method.name;
}

const char* word_of(VariableKind kind) {
    switch (kind) {
        case VariableKind::load:
            return "loads";
        case VariableKind::normal_load:
            return "loads along the normals";
        case VariableKind::strain:
            return "rigid motions";
        case VariableKind::stiffness:
            return "stiffness";
        case VariableKind::field:
            return "displacement fields";
        case VariableKind::planform:
            return "changes of wings";
        case VariableKind::parameter:
            break;
    }
    return "parameter";
}

std::string goal_words(const Case& c) {
    if (!c.fit.empty()) return "fit " + names(c.fit);
    if (c.objective.name.empty()) return "";
    std::string what = c.objective.name;
    for (const QuantityEntry& quantity : c.quantities)
        if (const auto* formula = std::get_if<FormulaEntry>(&quantity.what); formula && quantity.name == what)
            what = formula->text.name;
    return (c.maximize ? "maximize " : "minimize ") + what;
}

/// A user-defined variable with the bound that the case states for it.
std::string user_variable_words(const UserVariableEntry& variable, const std::string& units) {
    if (variable.max_angle) return fmt::format("{} (up to {}°)", variable.name, number(degrees(*variable.max_angle)));
    if (variable.max_displacement)
        return fmt::format("{} (up to {})", variable.name, length(*variable.max_displacement, units));
    return variable.name;
}

std::string planform_words(const Case& c) {
    const auto is_of_body = [&](const PlanformRangeEntry& range) {
        return std::ranges::any_of(c.bodies, [&](const FuselageEntry& body) { return body.name == range.wing; });
    };
    const auto& ranges = c.parameters.planform;
    const auto bodies = std::ranges::count_if(ranges, is_of_body);
    return bodies == 0                             ? "changes of wings"
           : std::cmp_equal(bodies, ranges.size()) ? "changes of bodies"
                                                   : "changes of wings and bodies";
}

std::string variable_words(const Case& c) {
    std::vector<std::string> kinds;
    for (const VariableKind kind : c.parameters.variables) kinds.push_back(word_of(kind));
    if (!c.parameters.planform.empty()) kinds.push_back(planform_words(c));
    if (c.parameters.fields.is_wanted) kinds.push_back("displacement fields");
    for (const UserVariableEntry& variable : c.parameters.user_variables)
        kinds.push_back(user_variable_words(variable, c.units));
    const ParameterEntry& p = c.parameters;
    if (p.limits_variables)
        return joined(kinds) + ", each moving the surface by up to " + length(p.max_displacement, c.units);
    if (!c.fit.empty() && !p.is_limit_stated) return joined(kinds);
    return joined(kinds) + ", the surface moving by up to " + length(p.max_displacement, c.units) +
           (p.max_displacement_by_region.empty() ? "" : ", less or more in some regions");
}

std::string level_words(const Case& c) {
    std::vector<std::string> words;
    for (const double angle : c.parameters.levels_deg) words.push_back(number(angle) + "°");
    if (!words.empty()) return "creases above " + joined(words);
    for (const int patches : c.parameters.patches_per_level) words.push_back(std::to_string(patches));
    return words.empty() ? "automatic" : "automatic, about " + joined(words) + " patches";
}

std::string parameter_words(const ProgramParameter& v) {
    const double unit = v.is_angle ? 180 / std::numbers::pi : 1;
    const char* sign = v.is_angle ? "°" : "";
    return fmt::format("{} from {}{} within {}{} and {}{}", v.name, number(unit * v.start), sign, number(unit * v.min),
                       sign, number(unit * v.max), sign);
}

std::string budget_words(const OptimizeOptions& o) {
    return fmt::format("{} evaluations{}", o.max_evaluations,
                       o.max_seconds > 0 ? fmt::format(", {} s", number(o.max_seconds)) : "");
}

std::string symmetry_words(const SymmetryPlane& plane) {
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(plane.normal[axis]) == 1)
            return fmt::format("about {} = {}", "xyz"[axis], number(plane.offset * plane.normal[axis]));
    return fmt::format("about the plane normal to ({}, {}, {}) at {}", number(plane.normal.x()),
                       number(plane.normal.y()), number(plane.normal.z()), number(plane.offset));
}

std::string sample_words(const Case& c) {
    if (c.sample_table) return "designs of " + c.sample_table->filename().string();
    return *c.sample == Spread::sobol ? "samples: Sobol' sequence"
           : *c.sample == Spread::lhs ? "samples: Latin hypercube"
                                      : "samples: all combinations of levels";
}

}  // namespace

ReportSubject report_subject(const Case& c, const BuiltProblem* built) {
    ReportSubject subject;
    subject.title = c.name;
    subject.units = c.units;
    subject.maximize = c.maximize;
    const auto ask = [&](const std::string& heading, const std::string& words) {
        if (!words.empty()) subject.asked.emplace_back(heading, words);
    };
    ask("Goal", goal_words(c));
    for (const ConstraintEntry& entry : c.constraints) {
        const Constraint& limit = entry.constraint;
        subject.limits[limit.quantity] = {limit_words(limit), limit.equals ? limit.equals : limit.min,
                                          limit.equals ? limit.equals : limit.max, limit.relative};
        ask("Constraint", limit.quantity + " " + limit_words(limit));
    }
    ask("Surface", c.surface.filename().string() + (c.repair ? ", repaired" : "") + (c.remesh ? ", remeshed" : ""));
    ask("Held", names(c.fixed));
    if (c.symmetry) ask("Symmetry", symmetry_words(*c.symmetry));
    ask("Shape variables", variable_words(c));
    ask("Levels", level_words(c));
    for (const ProgramParameterEntry& entry : c.variables) ask("Parameter", parameter_words(entry.variable));
    if (c.fit.empty()) ask("Method", c.sample ? sample_words(c) : method_words(c.optimize));
    ask("Budget", budget_words(c.optimize));
    subject.symmetry = c.symmetry;
    if (const std::optional<BodyAxes> axes = body_axes(c); axes && axes->is_stated) {
        subject.downstream = axes->downstream;
        subject.up = axes->up;
    }
    if (built) {
        subject.surface = built->problem.surface;
        subject.tree = built->problem.tree;
        subject.wings = built->wings;
        subject.bodies = built->bodies;
        if (const auto& wrap = built->problem.wrap) {
            subject.wrap_triangle = wrap->wrap_triangle();
            subject.tree = carried(subject.tree, subject.wrap_triangle, subject.surface);
        }
    }
    return subject;
}

void write_report(const std::filesystem::path& folder, const ReportSubject& subject, const std::filesystem::path& out) {
    write_atomically(out, report_html(folder, subject));
}

}  // namespace strake
