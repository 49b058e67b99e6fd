#include "cases/case_reader.hpp"
#include "cases/scalars.hpp"

#include <Eigen/QR>
#include <algorithm>

namespace strake {
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
    read_variables(texts(map.find("variables")));
    read_directions(map.find("directions"));
    if (const Value* v = map.find("core")) p.core = v->number;
    if (const Value* v = map.find("max_displacement")) p.max_displacement = length_of(*v);
    if (const Value* v = map.find("split")) read_split(*v);
    if (const Value* v = map.find("split_share")) p.split_share = v->number;
    if (const Value* v = map.find("growth")) p.growth = v->number;
    p.on = references(map.find("on"));
    p.freeze = references(map.find("freeze"));
    if (const Value* v = map.find("groups"))
        for (const Entry& group : v->entries)
            if (group.value.accepted) p.groups.push_back(references(&group.value));
    if (const Value* v = map.find("given"))
        for (std::size_t i = 0; i < v->entries.size(); ++i)
            if (v->entries[i].value.accepted) read_given(v->entries[i].value, text("parameters.given[", i, "]"));
    if (const Value* v = map.find("mirror")) {
        p.mirror = v->number != 0;
        p.mirror_place = v->place;
    }
}

void CaseReader::read_variables(const std::vector<std::string>& words) {
    ParameterEntry& p = case_.parameters;
    p.strain_rotates = p.strain_translates = false;
    for (const std::string& word : words) {
        VariableKind kind = VariableKind::strain;
        if (word == "load") kind = VariableKind::load;
        if (word == "load_normal") kind = VariableKind::load_normal;
        if (word == "stiffness") kind = VariableKind::stiffness;
        p.strain_rotates |= word == "strain" || word == "strain_rotation";
        p.strain_translates |= word == "strain" || word == "strain_translation";
        if (std::find(p.variables.begin(), p.variables.end(), kind) == p.variables.end()) p.variables.push_back(kind);
    }
}

void CaseReader::read_directions(const Value* list) {
    if (!list) return;
    std::vector<Eigen::Vector3d>& directions = case_.parameters.directions;
    for (std::size_t k = 0; k < list->entries.size(); ++k)
        if (const auto v = direction_of(&list->entries[k].value, text("parameters.directions[", k, "]"), errors_))
            directions.push_back(*v);
    if (directions.size() < list->entries.size()) return;
    Eigen::Matrix3Xd columns(3, directions.size());
    for (std::size_t k = 0; k < directions.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = directions[k];
    Eigen::ColPivHouseholderQR<Eigen::Matrix3Xd> qr;
    qr.setThreshold(1e-6);
    if (qr.compute(columns).rank() < columns.cols())
        errors_.add(list->place,
                    text("parameters.directions: ", directions.size(),
                         " directions of which one follows from the others; at most 3, linearly independent"));
}

void CaseReader::read_split(const Value& map) {
    SplitEntry& split = case_.parameters.split;
    if (map.form == Value::Form::scalar) {
        if (map.text == "sensitivity") split.kind = SplitEntry::Kind::sensitivity;
        if (map.text == "gradient") split.kind = SplitEntry::Kind::gradient;
        return;
    }
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
