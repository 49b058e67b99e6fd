#include "casefile/model/built_in.hpp"
#include "casefile/read/case_reader.hpp"

#include <algorithm>

namespace strake {

void CaseReader::read_built_in(const std::string& type, const Value& map, QuantityEntry& quantity) {
    const Value* file = map.find("file");
    const std::filesystem::path path = file ? dir_ / file->text : "";
    const std::string shown = "quantities." + printable(quantity.name);
    if (auto made = read_aero(type, map, shown, dir_, case_.aero, errors_)) quantity.what = std::move(*made);
    if (auto made = read_geometry(type, map, shown, dir_, errors_)) quantity.what = std::move(*made);
    if (type == "area") quantity.what = AreaEntry{};
    if (type == "target_shape") {
        const Value* match = map.find("match");
        quantity.what = TargetShapeEntry{path, match && match->text == "same"};
    }
    if (type == "measured_points") quantity.what = MeasuredPointsEntry{path};
    if (type == "thickness") quantity.what = read_line_thickness(map, shown);
    if (type == "section_area") {
        SectionAreaEntry entry;
        const Value *plane = map.find("plane"), *target = map.find("target");
        if (!plane) errors_.add(map.place, shown + ".plane is missing");
        const auto normal = direction_of(plane ? plane->find("normal") : nullptr, shown + ".plane.normal", errors_);
        const Value* at = plane ? plane->find("at") : nullptr;
        if (normal) entry.section.normal = *normal;
        if (at) entry.section.offset = at->number;
        if (target) entry.section.target = target->number;
        quantity.what = entry;
    }
}

LineThicknessEntry CaseReader::read_line_thickness(const Value& map, const std::string& shown) {
    LineThicknessEntry entry;
    const Value *at = map.find("at"), *values = map.find("values");
    if (values && values->text == "smallest") entry.values = ThicknessValues::smallest;
    if (!at) return entry;
    try {
        entry.lines = read_thickness_lines(dir_ / at->text);
    } catch (const InputError& error) {
        errors_.add(at->place, text(shown, ".at: ", error.what()));
    }
    return entry;
}

void CaseReader::read_on_failure(const Value& policy, const std::string& name, ExternalEntry& external) {
    using OnFailure = ExternalEntry::OnFailure;
    if (policy.form == Value::Form::scalar) {
        external.on_failure = policy.text == "shrink_step" ? OnFailure::shrink_step : OnFailure::abort;
        return;
    }
    const Value* value = policy.find("value");
    if (!value) return;
    external.on_failure = OnFailure::value;
    external.value_after_failure = value->number;
    if (external.has_gradients)
        errors_.add(policy.place, text("quantities.", printable(name),
                                       ".on_failure.value has no gradient: it is only allowed with gradients: false; "
                                       "with gradients use shrink_step"));
}

void CaseReader::read_where_it_runs(const Value& map, ExternalEntry& external) const {
    if (const Value* v = map.find("parallel")) external.parallel = static_cast<int>(v->number);
    if (const Value* scheduler = map.find("scheduler")) {
        if (const Value* v = scheduler->find("slurm")) external.slurm = texts(v);
        if (const Value* v = scheduler->find("wait")) external.queue_s = v->number;
        if (const Value* v = scheduler->find("poll")) external.poll_s = v->number;
    }
    if (const Value* v = map.find("cache")) external.cache = dir_ / v->text;
    for (const std::string& file : texts(map.find("cache_files"))) external.cache_files.push_back(dir_ / file);
}

void CaseReader::read_gradient_keys(const Value& map, const std::string& name, ExternalEntry& external) {
    external.gradient_command = texts(map.find("gradient_command"));
    if (const Value* v = map.find("gradient_timeout")) external.gradient_timeout_s = v->number;
    if (const Value* v = map.find("gradient_points")) {
        external.gradient_points = dir_ / v->text;
        external.gradient_points_place = v->place;
    }
    if (const Value* v = map.find("support_radius")) external.support_radius = length_of(*v);
    const Value* command = map.find("gradient_command");
    if (command && !external.has_gradients)
        errors_.add(command->place, text("quantities.", printable(name),
                                         ".gradient_command is only allowed with a program that has gradients"));
}

ExternalEntry CaseReader::read_external(const Value& map, const std::string& name) {
    ExternalEntry external;
    external.command = texts(map.find("command"));
    external.outputs = texts(map.find("outputs"));
    if (const Value* v = map.find("timeout")) external.timeout_s = v->number;
    if (const Value* v = map.find("format")) external.format = v->text;
    if (const Value* v = map.find("gradients")) external.has_gradients = v->number != 0;
    if (const Value* v = map.find("convergence")) {
        external.convergence = std::filesystem::path(v->text).lexically_normal();
        if (external.convergence.is_absolute() || external.convergence.filename().empty() ||
            *external.convergence.begin() == ".." || *external.convergence.begin() == ".")
            errors_.add(v->place, text("quantities.", printable(name), ".convergence: '", printable(v->text),
                                       "' must be a file in the program's folder, for example history.csv"));
    }
    if (const Value* v = map.find("retries")) external.retries = static_cast<int>(v->number);
    if (const Value* v = map.find("on_failure")) read_on_failure(*v, name, external);
    if (const Value* v = map.find("depends_on")) external.depends_on = references(v);
    if (const Value* v = map.find("low_fidelity")) {
        external.low_fidelity_place = v->place;
        if (v->form != Value::Form::map) external.low_fidelity.push_back({{}, {v->text, v->place}});
        for (const Entry& entry : v->entries)
            if (v->form == Value::Form::map)
                external.low_fidelity.push_back({{entry.key, entry.key_place}, {entry.value.text, entry.value.place}});
    }
    read_gradient_keys(map, name, external);
    read_where_it_runs(map, external);
    if (const Value* plugin = map.find("plugin")) {
        const Value *library = plugin->find("library"), *options = plugin->find("options");
        external.plugin = {library ? dir_ / library->text : "", options ? options->text : ""};
    }
    return external;
}

void CaseReader::read_quantity(const Entry& entry) {
    const Value& map = entry.value;
    QuantityEntry quantity{entry.key, entry.key_place, VolumeEntry{}};
    const Value* type = map.find("type");
    const auto says = [&](const char* key) {
        return std::any_of(map.entries.begin(), map.entries.end(), [&](auto& e) { return e.key == key; });
    };
    if (map.form == Value::Form::map && says("type") + says("command") + says("plugin") + says("expression") != 1)
        errors_.add(entry.key_place, text("quantities.", printable(entry.key),
                                          " must have exactly one of type, command, plugin, expression"));
    if (const Value* formula = map.find("expression"))
        quantity.what = FormulaEntry{{formula->text, formula->place}, {}, {}};
    if (type) read_built_in(type->text, map, quantity);
    if (map.find("command") || map.find("plugin")) quantity.what = read_external(map, quantity.name);
    case_.quantities.push_back(std::move(quantity));
}

void CaseReader::read_objective(const Value& map) {
    const Value *low = map.find("minimize"), *high = map.find("maximize");
    if (map.entries.size() != 1) errors_.add(map.place, "objective must have exactly one of minimize, maximize");
    const Value* named = low ? low : high;
    if (!named) return;
    case_.objective = {named->text, named->place};
    case_.maximize = named == high;
}

/// Limits of a wing's angles carry a unit, all others none.
void CaseReader::check_limit_unit(const Value& map, const char* key, const std::string& quantity,
                                  const std::string& shown) {
    const Value* limit = map.find(key);
    if (!limit) return;
    const bool has_unit = limit->text.ends_with("deg") || limit->text.ends_with("rad");
    const bool is_relative = map.find("relative") && map.find("relative")->number != 0;
    const std::optional<bool> is_angle = is_wing_angle(case_, quantity);
    if (!is_angle) return;
    const bool needs_unit = *is_angle && !is_relative && limit->number != 0;
    if (has_unit && !needs_unit && limit->number != 0)
        errors_.add(limit->place, text(shown, ".", key, " = ", printable(limit->text), " must be a plain number: ",
                                       is_relative ? "relative limits are multiples" : "the quantity is not an angle"));
    if (needs_unit && !has_unit)
        errors_.add(limit->place, text(shown, ".", key, " = ", printable(limit->text),
                                       " must carry deg or rad: the quantity is an angle"));
}

void CaseReader::read_constraint(const Entry& entry) {
    const Value& map = entry.value;
    if (!map.accepted) return;
    const std::string shown = "constraints." + printable(entry.key);
    Constraint c;
    c.quantity = entry.key;
    const auto number = [&](const char* key) -> std::optional<double> {
        const Value* v = map.find(key);
        return v ? std::optional<double>(v->number) : std::nullopt;
    };
    for (const char* key : {"min", "max", "equals"}) check_limit_unit(map, key, entry.key, shown);
    c.min = number("min");
    c.max = number("max");
    c.equals = number("equals");
    if (const Value* v = map.find("relative")) c.relative = v->number != 0;
    const auto given = [&](const char* key) {
        return std::any_of(map.entries.begin(), map.entries.end(), [&](auto& e) { return e.key == key; });
    };
    if (!given("min") && !given("max") && !given("equals"))
        errors_.add(entry.key_place, text(shown, " must have min, max or equals"));
    if (given("equals") && (given("min") || given("max")))
        errors_.add(map.find("equals") ? map.find("equals")->place : entry.key_place,
                    text(shown, ".equals cannot be combined with min or max"));
    if (c.min && c.max && *c.min > *c.max)
        errors_.add(map.find("min")->place, text(shown, ".min = ", *c.min, " must be <= max = ", *c.max));
    case_.constraints.push_back({c, entry.key_place});
}

}  // namespace strake
