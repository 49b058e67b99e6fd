#include "cases/case_reader.hpp"

#include <algorithm>

namespace strake {

void CaseReader::read_quantity(const Entry& entry) {
    const Value& map = entry.value;
    QuantityEntry quantity{entry.key, entry.key_place, VolumeEntry{}};
    const Value *type = map.find("type"), *command = map.find("command"), *file = map.find("file");
    const bool has_type = std::any_of(map.entries.begin(), map.entries.end(), [](auto& e) { return e.key == "type"; });
    const bool has_command =
        std::any_of(map.entries.begin(), map.entries.end(), [](auto& e) { return e.key == "command"; });
    if (map.form == Value::Form::map && has_type == has_command)
        errors_.add(entry.key_place,
                    text("quantities.", printable(entry.key), " must have exactly one of type, command"));
    if (type && type->text == "area") quantity.what = AreaEntry{};
    if (type && type->text == "target_shape") {
        const Value* match = map.find("match");
        quantity.what = TargetShapeEntry{file ? dir_ / file->text : "", match && match->text == "same"};
    }
    if (command) {
        ExternalEntry external;
        external.command = texts(command);
        external.gives = texts(map.find("gives"));
        if (const Value* v = map.find("timeout")) external.timeout_s = v->number;
        if (const Value* v = map.find("format")) external.format = v->text;
        if (const Value* v = map.find("gradients")) external.has_gradients = v->number != 0;
        quantity.what = std::move(external);
    }
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
                    text(shown, ".equals excludes min and max"));
    if (c.min && c.max && *c.min > *c.max)
        errors_.add(map.find("min")->place, text(shown, ".min = ", *c.min, " must be <= max = ", *c.max));
    case_.constraints.push_back({c, entry.key_place});
}

}  // namespace strake
