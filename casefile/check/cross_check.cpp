#include "casefile/check/cross_check.hpp"

#include "casefile/check/cheap_models.hpp"
#include "casefile/read/read_case.hpp"
#include "casefile/schema/quantity_types.hpp"
#include "objectives/external/external.hpp"
#include "optimize/nlp/program/methods.hpp"

#include <algorithm>
#include <set>

namespace strake {
namespace {

const Entry* entry_of(const Value* map, const std::string& key) {
    if (!map) return nullptr;
    for (const Entry& entry : map->entries)
        if (entry.key == key) return &entry;
    return nullptr;
}

std::vector<std::string> region_names(const Case& the_case) {
    std::vector<std::string> names;
    for (const Region& region : the_case.regions) names.push_back(region.name);
    return names;
}

void check_fixed(const Case& c, Diagnostics& errors) {
    std::set<std::string> held, seen_fixed;
    for (const Reference& fixed : c.fixed) {
        check_region(c, fixed, errors);
        if (!seen_fixed.insert(fixed.name).second)
            errors.add(fixed.place, text("region '", fixed.name, "' is named twice under fixed"));
        held.insert(fixed.name);
    }
    std::set<std::string> strained;
    for (const StrainEntry& strain : c.strains) {
        check_region(c, strain.region, errors);
        if (!strained.insert(strain.region.name).second)
            errors.add(strain.region.place, text("region '", strain.region.name, "' is named twice under strains"));
        if (held.count(strain.region.name))
            errors.add(strain.region.place,
                       text("region '", strain.region.name, "' is under fixed and under strains; choose one"));
    }
    for (const LoadEntry& load : c.loads) {
        check_region(c, load.region, errors);
        if (held.count(load.region.name) || strained.count(load.region.name))
            errors.add(load.region.place,
                       text("region '", load.region.name, "' is under loads and under ",
                            held.count(load.region.name) ? "fixed" : "strains", "; a held region cannot be loaded"));
    }
}

void check_loads(const Value* list, Diagnostics& errors) {
    if (!list) return;
    for (const Entry& load : list->entries) {
        if (load.value.form != Value::Form::map) continue;
        std::vector<std::string> given;
        for (const char* key : {"traction", "force", "displacement"})
            if (entry_of(&load.value, key)) given.push_back(key);
        if (given.size() > 1) errors.add(load.value.place, text("a load must have only one of ", joined(given)));
        if (given.empty() && !entry_of(&load.value, "spring"))
            errors.add(load.value.place, "a load must have traction, force, displacement or spring");
    }
}

void check_thickness(const Case& c, Diagnostics& errors) {
    for (const ThicknessEntry& entry : c.thickness_by_region) check_region(c, entry.region, errors);
    for (const Region& region : c.regions)
        if (region.name == "default")
            errors.add(region.place, "regions.default: 'default' is a key of shell.thickness; use another name");
}

/// Without a shell the fields alone move the surface.
void check_without_shell(const Value& root, const Case& c, Diagnostics& errors) {
    if (c.has_shell) return;
    const auto refuse = [&](const Place& place, const std::string& what) {
        errors.add(place, what + " an elastic shell, and shell: none leaves it out; remove one of the two");
    };
    if (!c.strains.empty()) refuse(c.strains.front().place, "strains need");
    if (!c.loads.empty()) refuse(c.loads.front().place, "loads need");
    if (!c.attach.empty()) refuse(c.attach.front().part.place, "attach needs");
    const Value* parameters = root.find("parameters");
    const Value* variables = parameters ? parameters->find("variables") : nullptr;
    if (variables && !variables->entries.empty()) refuse(variables->place, "parameters.variables need");
    for (const UserVariableEntry& given : c.parameters.user_variables)
        refuse(given.place, text("parameters.given '", given.name, "' needs"));
    if (!c.parameters.fields.is_wanted && c.parameters.planform.empty())
        errors.add(
            c.shell_place,
            "with shell: none displacement fields and changes of wings alone move the surface; write parameters: "
            "{fields: auto} or parameters.planform");
}

/// What stands on the body's own triangles is not for a wrap.
void check_wrap(const Case& c, Diagnostics& errors) {
    if (!c.wrap) return;
    if (!c.has_shell)
        errors.add(c.wrap->place,
                   "wrap: with shell: none nothing is elastic that a wrap could take the place of; remove one of them");
    if (!c.attach.empty())
        errors.add(c.attach.front().part.place,
                   "attach: the wrap carries all parts of the body, near ones with each other; remove attach or wrap");
    if (c.invariance)
        errors.add(c.invariance_place,
                   "invariance: a wrap is no exactly extruded, revolved or cyclic surface; remove one of the two "
                   "(fields alone keep the kind of shape: shell: none)");
}

void check_levels(const Value& parameters, const ParameterEntry& p, Diagnostics& errors) {
    if (const Value* levels = parameters.find("levels"))
        for (std::size_t k = 1; k < p.levels_deg.size(); ++k)
            if (!(p.levels_deg[k] < p.levels_deg[k - 1]))
                errors.add(k < levels->entries.size() ? levels->entries[k].value.place : levels->place,
                           text("parameters.levels[", k, "] = ", p.levels_deg[k], "deg must be < parameters.levels[",
                                k - 1, "] = ", p.levels_deg[k - 1], "deg"));
    if (const Value* counts = parameters.find("patches_per_level"))
        for (std::size_t k = 1; k < p.patches_per_level.size(); ++k)
            if (p.patches_per_level[k] <= p.patches_per_level[k - 1])
                errors.add(k < counts->entries.size() ? counts->entries[k].value.place : counts->place,
                           text("parameters.patches_per_level[", k, "] = ", p.patches_per_level[k],
                                " must be > parameters.patches_per_level[", k - 1, "] = ", p.patches_per_level[k - 1]));
}

void check_variables(const Value& parameters, Diagnostics& errors) {
    const Value* variables = parameters.find("variables");
    if (!variables) return;
    std::set<std::string> seen;
    for (const Entry& entry : variables->entries)
        if (entry.value.accepted && !seen.insert(entry.value.text).second)
            errors.add(entry.value.place, text("parameters.variables names '", entry.value.text, "' twice"));
    const std::pair<const char*, const char*> contained[] = {
        {"load", "normal"}, {"strain", "strain_rotation"}, {"strain", "strain_translation"}};
    for (const auto& [whole, part] : contained)
        if (seen.count(whole) && seen.count(part))
            errors.add(variables->place,
                       text("parameters.variables: ", whole, " contains ", part, "; use one of them"));
}

/// A name given twice in a list of regions and patches.
void check_names(const std::string& shown, const std::vector<Reference>& names, Diagnostics& errors) {
    std::set<std::string> seen;
    for (const Reference& name : names)
        if (!seen.insert(name.name).second)
            errors.add(name.place, text(shown, " names '", printable(name.name), "' twice"));
}

void check_parameters(const Value* parameters, const Case& c, Diagnostics& errors) {
    if (!parameters) return;
    const ParameterEntry& p = c.parameters;
    check_levels(*parameters, p, errors);
    check_variables(*parameters, errors);
    check_names("parameters.variables_on", p.variables_on, errors);
    check_names("parameters.frozen", p.frozen, errors);
    for (const MotionLimitEntry& limit : p.max_displacement_by_region) check_region(c, limit.region, errors);
    std::vector<Reference> grouped;
    for (const auto& group : p.groups) grouped.insert(grouped.end(), group.begin(), group.end());
    check_names("parameters.groups", grouped, errors);
}

/// Empty when the program of a command can be started.
std::string program_error(const QuantityEntry& quantity, const ExternalEntry& entry, const Case& c) {
    ExternalCommand command;
    command.name = quantity.name;
    command.command = entry.command;
    command.gradient_command = entry.gradient_command;
    command.outputs = entry.outputs;
    command.timeout_s = entry.timeout_s;
    command.format = entry.format.empty() ? "stl" : entry.format;
    command.case_dir = c.command_dir.empty() ? c.dir() : c.command_dir;
    command.slurm = entry.slurm;
    command.diagonal = 1;  // not known yet, not used here
    try {
        const auto failure = check_program(command);
        return failure ? failure->message : "";
    } catch (const InvalidInput& e) {
        return e.what();
    }
}

void check_quantities(const Value* list, const Case& c, Diagnostics& errors) {
    for (const QuantityEntry& quantity : c.quantities) {
        if (const auto* made = std::get_if<BuiltInEntry>(&quantity.what))
            for (const Reference& region : made->regions) check_region(c, region, errors);
        const auto* external = std::get_if<ExternalEntry>(&quantity.what);
        const Entry* entry = entry_of(list, quantity.name);
        const Value* command = entry ? entry->value.find("command") : nullptr;
        const bool complete = external && command && external->command.size() == command->entries.size();
        const std::string why = complete ? program_error(quantity, *external, c) : "";
        if (!why.empty()) errors.add(command->place, "quantities." + why);
    }
}

std::string unknown_value(const Case& c, const std::string& name) {
    for (const QuantityEntry& quantity : c.quantities)
        if (const auto* made = std::get_if<BuiltInEntry>(&quantity.what))
            for (const std::string& value : made->omitted)
                if (name == quantity.name + "." + value)
                    return text("quantity '", printable(name),
                                "' is left out: a half model at no sideslip has no side force, roll or yaw");
    if (name.find('@') != std::string::npos) {  // only values of wings and bodies have it
        std::vector<std::string> wings;
        for (const WingEntry& wing : c.planform) wings.push_back(wing.name);
        for (const FuselageEntry& body : c.bodies) wings.push_back(body.name);
        return text("quantity '", printable(name), "' is not known: no wing or body '",
                    printable(name.substr(0, name.find('.'))), "' is declared under planform",
                    wings.empty() ? "" : text("; declared: ", joined(wings)));
    }
    std::vector<std::string> known = known_values(c);
    const std::string near = nearest(name, known);
    const std::string hint = near.empty() ? quantity_hint(name) : "";
    return text("quantity '", printable(name), "' is not known",
                near.empty() ? "" : text("; did you mean '", near, "'?"), near.empty() ? "; q" : " Q",
                "uantities: ", joined(known), hint.empty() ? "" : "; " + hint);
}

/// The quantity that gives the value of this name, or null.
const QuantityEntry* quantity_of(const Case& c, const std::string& value) {
    for (const QuantityEntry& quantity : c.quantities)
        for (const std::string& name : quantity.value_names())
            if (name == value) return &quantity;
    return nullptr;
}

void check_gradients(const Case& c, const Reference& value, Diagnostics& errors) {
    const QuantityEntry* quantity = quantity_of(c, value.name);
    if (const auto* formula = quantity ? std::get_if<FormulaEntry>(&quantity->what) : nullptr)
        for (const std::string& part : formula->of) check_gradients(c, {part, value.place}, errors);
    const auto* external = quantity ? std::get_if<ExternalEntry>(&quantity->what) : nullptr;
    if (!external || external->has_gradients || c.optimize.finite_differences || c.optimize.chooses_method) return;
    if (!method_facts(c.optimize.method).needs_gradients || c.sample) return;
    std::vector<std::string> without;
    for (const MethodFacts& method : all_methods())
        if (!method.needs_gradients) without.push_back(method.name);
    errors.add(value.place, text("'", value.name,
                                 "' has no gradients: add optimize.finite_differences: true, or a "
                                 "derivative-free optimize.method (",
                                 joined(without), ")"));
}

const char* const residual_types =
    "type: target_shape or measured_points, or thickness or section_area with a target value";

bool has_residuals(const QuantityEntry& quantity) {
    if (const auto* along = std::get_if<LineThicknessEntry>(&quantity.what))
        return along->lines.empty() || along->lines.front().target;  // empty: the file was refused
    if (const auto* area = std::get_if<SectionAreaEntry>(&quantity.what)) return area->section.target.has_value();
    return std::holds_alternative<TargetShapeEntry>(quantity.what) ||
           std::holds_alternative<MeasuredPointsEntry>(quantity.what);
}

/// A fit takes whole quantities, not single values.
void check_fitted(const Case& c, const Reference& target, Diagnostics& errors) {
    const auto is_named = [&](const QuantityEntry& quantity) { return quantity.name == target.name; };
    const auto named = std::find_if(c.quantities.begin(), c.quantities.end(), is_named);
    const QuantityEntry* quantity = named != c.quantities.end() ? &*named : quantity_of(c, target.name);
    const bool built_in = target.name == "volume" || target.name == "area";
    if (!quantity && !built_in)
        errors.add(target.place, unknown_value(c, target.name));
    else if (!quantity || !has_residuals(*quantity))
        errors.add(target.place, text("quantity '", target.name, "' has no residuals; fit needs ", residual_types));
    else if (quantity->name != target.name)
        errors.add(target.place, text("'", target.name, "' is a single value; fit takes the whole quantity: write '",
                                      quantity->name, "'"));
}

void check_targets(const Case& c, bool is_fit, Diagnostics& errors) {
    const std::vector<std::string> known = known_values(c);
    const auto check = [&](const Reference& value) {
        const bool is_known = std::find(known.begin(), known.end(), value.name) != known.end();
        if (!is_known && is_wing_value(c, value.name)) return;  // has its error
        if (!is_known)
            errors.add(value.place, unknown_value(c, value.name));
        else if (!is_fit)
            check_gradients(c, value, errors);
    };
    if (!c.objective.name.empty()) check(c.objective);
    for (const ConstraintEntry& entry : c.constraints) check({entry.constraint.quantity, entry.place});
    std::set<std::string> seen;
    for (const Reference& target : c.fit) {
        check_fitted(c, target, errors);
        if (!seen.insert(target.name).second)
            errors.add(target.place, text("quantity '", target.name, "' is named twice under fit"));
    }
}

/// Refuses keys that a fit would ignore.
void check_fit(const Value& root, const Case& c, Diagnostics& errors) {
    for (const ConstraintEntry& entry : c.constraints)
        errors.add(entry.place, "constraints are not supported together with fit");
    const Value* parameters = root.find("parameters");
    if (const Value* variables = parameters ? parameters->find("variables") : nullptr)
        for (const Entry& entry : variables->entries)
            if (entry.value.accepted && entry.value.text == "stiffness")
                errors.add(entry.value.place,
                           "parameters.variables: stiffness cannot be fitted; use load, normal or strain");
    const Value* optimize = root.find("optimize");
    if (!optimize) return;
    const Entry* method = entry_of(optimize, "method");
    if (method && !method->value.from_default)
        errors.add(method->key_place, "optimize.method is not used by fit, which is always a least-squares fit");
    for (const char* key : {"batch", "finite_differences", "difference_step", "starts", "seed"})
        if (const Entry* entry = entry_of(optimize, key); entry && !entry->value.from_default)
            errors.add(entry->key_place, text("optimize.", key, " is not used by fit"));
    const Value* tolerances = optimize->find("tolerances");
    const Entry* constraint = entry_of(tolerances, "constraint");
    if (constraint && !constraint->value.from_default)
        errors.add(constraint->key_place, "optimize.tolerances.constraint is not used by fit");
}

/// Refuses keys that an optimization would ignore.
void check_run(const Value& root, Diagnostics& errors) {
    for (const char* key : {"loss", "loss_scale", "icp_iterations"})
        if (const Entry* entry = entry_of(root.find("optimize"), key); entry && !entry->value.from_default)
            errors.add(entry->key_place, text("optimize.", key, " is used by fit only"));
}

void check_purpose(const Value& root, Purpose purpose, const Case& c, Diagnostics& errors) {
    const Entry *objective = entry_of(&root, "objective"), *fit = entry_of(&root, "fit");
    if (objective && fit)
        errors.add(fit->key_place, "a case cannot have both objective and fit");
    else if (purpose == Purpose::run && !objective && !errors.suggests("objective"))
        errors.add(root.place, fit ? "objective is missing; this is a case for 'strake fit'"
                                   : "objective is missing; add one, for example objective: {maximize: volume}");
    else if (purpose == Purpose::fit && !fit && !errors.suggests("fit"))
        errors.add(root.place, objective ? "fit is missing; this is a case for 'strake run'"
                                         : "fit is missing; add one, for example fit: [match]");
    else if (fit)
        check_fit(root, c, errors);
    else if (objective)
        check_run(root, errors);
    if (const Entry* sample = entry_of(&root, "sample"); sample && fit)
        errors.add(sample->key_place, "sample needs an objective, which a case for 'strake fit' does not have");
    if (const Entry* constraints = entry_of(&root, "constraints"); constraints && !objective && !fit)
        if (!errors.suggests("objective") && !errors.suggests("fit"))
            errors.add(constraints->key_place, "constraints without an objective");
}

}  // namespace

void check_region(const Case& the_case, const Reference& reference, Diagnostics& errors) {
    const std::vector<std::string> names = region_names(the_case);
    if (std::find(names.begin(), names.end(), reference.name) != names.end()) return;
    const std::string near = nearest(reference.name, names);
    const std::string list = names.empty() ? "no region is declared" : text("Regions: ", joined(names));
    errors.add(reference.place, text("region '", printable(reference.name), "' is not declared; ",
                                     near.empty() ? "" : text("did you mean '", near, "'? "), list));
}

void cross_check(const Value& root, Purpose purpose, Case& the_case, Diagnostics& errors) {
    check_fixed(the_case, errors);
    check_loads(root.find("loads"), errors);
    check_thickness(the_case, errors);
    check_without_shell(root, the_case, errors);
    check_wrap(the_case, errors);
    check_parameters(root.find("parameters"), the_case, errors);
    check_user_variables(the_case, errors);
    check_program_parameters(root, the_case, errors);
    if (purpose != Purpose::deform) check_quantities(root.find("quantities"), the_case, errors);
    check_targets(the_case, !the_case.fit.empty(), errors);
    if (purpose != Purpose::deform) cheap_models(the_case, errors);
    check_purpose(root, purpose, the_case, errors);
}

}  // namespace strake
