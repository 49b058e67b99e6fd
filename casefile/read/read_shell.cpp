#include "casefile/read/case_reader.hpp"

namespace strake {

void CaseReader::read_shell(const Value& map) {
    case_.shell_place = map.place;
    case_.has_shell = map.form == Value::Form::map;
    if (const Value* spring = map.find("spring")) case_.spring = spring->number;
    if (const Value* mode = map.find("nonmanifold")) case_.couple_nonmanifold = mode->text == "couple";
    if (const Value* solver = map.find("solver"))
        case_.solver = solver->text == "direct"      ? LinearSolver::direct
                       : solver->text == "multigrid" ? LinearSolver::multigrid
                                                     : LinearSolver::automatic;
    const Value* thickness = map.find("thickness");
    if (!thickness) return;
    case_.thickness_place = thickness->place;
    if (thickness->form == Value::Form::scalar) {
        case_.thickness = length_of(*thickness);
        return;
    }
    for (const Entry& entry : thickness->entries) {
        if (!entry.value.accepted) continue;
        if (entry.key == "default")
            case_.thickness = length_of(entry.value);
        else
            case_.thickness_by_region.push_back({{entry.key, entry.key_place}, length_of(entry.value)});
    }
}

void CaseReader::read_wrap(const Value& value) {
    if (!value.accepted || (value.form == Value::Form::scalar && value.text == "none")) return;
    WrapEntry wrap;
    wrap.place = value.place;
    if (value.form == Value::Form::map) {
        if (const Value* alpha = value.find("alpha")) wrap.alpha = length_of(*alpha);
        if (const Value* offset = value.find("offset")) wrap.offset = length_of(*offset);
        if (const Value* edge = value.find("edge_length")) wrap.edge_length = length_of(*edge);
    }
    case_.wrap = wrap;
}

void CaseReader::read_loads(const Value& list) {
    for (const Entry& entry : list.entries) {
        const Value& map = entry.value;
        const Value* region = map.find("region");
        if (!map.accepted || !region) continue;
        LoadEntry load;
        load.region = {region->text, region->place};
        load.place = map.place;
        load.traction = vector_of(map.find("traction"));
        load.force = vector_of(map.find("force"));
        if (const Value* v = map.find("displacement")) load.displacement = length_of(*v);
        if (const auto v = direction_of(map.find("direction"), "loads.direction", errors_)) load.direction = *v;
        if (const Value* v = map.find("spring")) load.spring = v->number;
        case_.loads.push_back(std::move(load));
    }
}

void CaseReader::read_strains(const Value& list) {
    for (const Entry& entry : list.entries) {
        const Value& map = entry.value;
        const Value* region = map.find("region");
        if (!map.accepted || !region) continue;
        StrainEntry strain;
        strain.region = {region->text, region->place};
        strain.place = map.place;
        const Value* translate = map.find("translate");
        if (vector_of(translate))
            for (int k = 0; k < 3; ++k) strain.translate[k] = length_of(translate->entries[k].value);
        if (const auto v = vector_of(map.find("rotate"))) strain.rotate = *v;
        strain.about = vector_of(map.find("about"));
        if (!map.find("translate") && !map.find("rotate"))
            errors_.add(map.place, "a strain must have translate, rotate or both");
        case_.strains.push_back(std::move(strain));
    }
}

void CaseReader::read_attach(const Value& list) {
    for (const Entry& entry : list.entries) {
        const Value &map = entry.value, *part = map.find("part"), *to = map.find("to"), *how = map.find("how");
        if (!map.accepted || !part || !to) continue;
        AttachEntry attach{{part->text, part->place}, {to->text, to->place}};
        if (how && how->text == "follow") attach.how = AttachHow::follow;
        case_.attach.push_back(std::move(attach));
    }
}

}  // namespace strake
