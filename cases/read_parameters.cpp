#include "cases/case_reader.hpp"
#include "cases/scalars.hpp"

namespace strake {
namespace {

VariableKind kind_named(const std::string& word) {
    if (word == "load") return VariableKind::load;
    if (word == "load_normal") return VariableKind::load_normal;
    return word == "strain" ? VariableKind::strain : VariableKind::stiffness;
}

}  // namespace

void CaseReader::read_parameters(const Value& map) {
    ParameterEntry& p = case_.parameters;
    case_.parameters_place = map.place;
    if (const Value* levels = map.find("levels"); levels && levels->form == Value::Form::list)
        for (const Entry& entry : levels->entries)
            if (entry.value.accepted) p.levels_deg.push_back(degrees(entry.value.number));
    if (const Value* v = map.find("min_patch")) p.min_patch_percent = v->number * 100;
    if (const Value* v = map.find("patches_per_level"))
        for (const Entry& entry : v->entries)
            if (entry.value.accepted) p.patches_per_level.push_back(static_cast<int>(entry.value.number));
    if (const Value* v = map.find("sharp_angle")) p.sharp_angle_deg = degrees(v->number);
    for (const std::string& word : texts(map.find("variables"))) p.variables.push_back(kind_named(word));
    if (const Value* v = map.find("max_displacement")) p.max_displacement = length_of(*v);
    if (const Value* v = map.find("split"); v && v->form == Value::Form::map) read_split(*v);
    p.on = references(map.find("on"));
}

void CaseReader::read_split(const Value& map) {
    SplitEntry& split = case_.parameters.split;
    if (map.entries.size() != 1)
        errors_.add(map.place, "parameters.split must have exactly one of largest, containing");
    if (const Value* v = map.find("largest")) {
        split.kind = SplitEntry::Kind::largest;
        split.largest = static_cast<int>(v->number);
    }
    const Value* containing = map.find("containing");
    if (!containing) return;
    split.kind = SplitEntry::Kind::containing;
    for (const Entry& entry : containing->entries) {
        const Value& value = entry.value;
        if (!value.accepted) continue;
        if (value.form == Value::Form::scalar)
            split.containing.push_back({static_cast<int>(value.number), value.place});
        else if (const auto point = vector_of(value.find("near")))
            split.containing.push_back({NearPoint{*point}, value.place});
    }
}

}  // namespace strake
