#include "casefile/read/case_reader.hpp"
#include "casefile/schema/scalars.hpp"

#include <Eigen/QR>
#include <algorithm>

namespace strake {

void CaseReader::read_levels(const Value& map) {
    ParameterEntry& p = case_.parameters;
    if (const Value* levels = map.find("levels"); levels && levels->form == Value::Form::list)
        for (const Entry& entry : levels->entries)
            if (entry.value.accepted) p.levels_deg.push_back(degrees(entry.value.number));
    if (const Value* v = map.find("min_patch")) p.min_patch_percent = v->number * 100;
    if (const Value* v = map.find("patches_per_level")) {
        p.patches_are_stated = !v->from_default;
        for (const Entry& entry : v->entries)
            if (entry.value.accepted) p.patches_per_level.push_back(static_cast<int>(entry.value.number));
    }
    if (const Value* v = map.find("sharp_angle")) p.sharp_angle_deg = degrees(v->number);
    if (const Value* v = map.find("split")) read_split(*v);
    set(p.marking_fraction, map.find("marking_fraction"));
    set(p.max_variable_ratio, map.find("max_variable_ratio"));
}

/// Which patches carry variables.
void CaseReader::read_variable_places(const Value& map) {
    ParameterEntry& p = case_.parameters;
    p.variables_on = references(map.find("variables_on"));
    p.frozen = references(map.find("frozen"));
    if (const Value* v = map.find("groups"))
        for (const Entry& group : v->entries)
            if (group.value.accepted) p.groups.push_back(references(&group.value));
    if (const Value* v = map.find("mirror")) {
        p.mirror = v->number != 0;
        p.mirror_place = v->place;
    }
}

void CaseReader::read_parameters(const Value& map) {
    ParameterEntry& p = case_.parameters;
    case_.parameters_place = map.place;
    read_levels(map);
    read_variables(texts(map.find("variables")));
    read_directions(map.find("directions"));
    set(p.free_border, map.find("free_border"));
    if (const Value* v = map.find("max_displacement")) read_motion_limits(*v);
    if (const Value* v = map.find("variable_scale")) p.variable_scale = length_of(*v);
    read_variable_places(map);
    if (const Value* v = map.find("fields")) read_fields(*v);
    if (const Value* v = map.find("planform"))
        for (const Entry& entry : v->entries) read_planform_range(entry);
    if (const Value* v = map.find("keep")) p.keeps_smooth_border = v->accepted && v->text == "smooth_border";
    if (const Value* v = map.find("given"))
        for (std::size_t i = 0; i < v->entries.size(); ++i)
            if (v->entries[i].value.accepted)
                read_user_variables(v->entries[i].value, text("parameters.given[", i, "]"));
}

void CaseReader::read_motion_limits(const Value& limit) {
    ParameterEntry& p = case_.parameters;
    p.is_limit_stated = !limit.from_default;
    p.max_displacement_place = limit.place;
    if (limit.form == Value::Form::scalar) {
        p.max_displacement = length_of(limit);
        return;
    }
    for (const Entry& entry : limit.entries) {
        const Value& value = entry.value;
        if (!value.accepted) continue;
        if (entry.key == "default") {
            p.max_displacement = length_of(value);
            continue;
        }
        MotionLimitEntry region{{entry.key, entry.key_place}, {}, {}};
        if (value.form == Value::Form::scalar) region.inward = region.outward = length_of(value);
        if (const Value* v = value.find("inward")) region.inward = length_of(*v);
        if (const Value* v = value.find("outward")) region.outward = length_of(*v);
        const std::string shown = text("parameters.max_displacement.", entry.key);
        if (!region.inward && !region.outward)
            errors_.add(value.place, text(shown, " must be a length, or have inward or outward"));
        else if (region.inward && region.outward && region.inward->value == 0 && region.outward->value == 0)
            errors_.add(value.place,
                        text(shown, value.form == Value::Form::scalar ? " = 0" : ": inward and outward are both 0",
                             "; a region that is not to move is for `fixed`: add it there, `fixed: [",
                             printable(entry.key), "]`"));
        p.max_displacement_by_region.push_back(std::move(region));
    }
}

void CaseReader::read_variables(const std::vector<std::string>& words) {
    ParameterEntry& p = case_.parameters;
    p.strain_rotates = p.strain_translates = false;
    for (const std::string& word : words) {
        VariableKind kind = VariableKind::strain;
        if (word == "load") kind = VariableKind::load;
        if (word == "normal") kind = VariableKind::normal_load;
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
        errors_.add(list->place, text("parameters.directions: ", directions.size(),
                                      " directions that are linearly dependent; give at most 3 independent ones"));
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
