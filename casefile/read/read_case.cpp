#include "casefile/read/case_reader.hpp"

namespace strake {

void set(double& number, const Value* value) {
    if (value) number = value->number;
}
void set(int& number, const Value* value) {
    if (value) number = static_cast<int>(value->number);
}
void set(bool& flag, const Value* value) {
    if (value) flag = value->number != 0;
}

std::optional<Eigen::Vector3d> vector_of(const Value* list) {
    if (!list || list->entries.size() != 3) return {};
    Eigen::Vector3d v;
    for (int k = 0; k < 3; ++k) {
        if (!list->entries[k].value.accepted) return {};
        v[k] = list->entries[k].value.number;
    }
    return v;
}

Length length_of(const Value& value) { return {value.number, value.relative}; }

std::optional<Eigen::Vector3d> direction_of(const Value* list, const std::string& shown, Diagnostics& errors) {
    const auto v = vector_of(list);
    if (!v) return {};
    // Scaled first: the squares of 1e-200 or 1e200 leave the range of a double.
    const double largest = v->cwiseAbs().maxCoeff();
    if (largest > 0) return (*v / largest).normalized();
    errors.add(list->place, text(shown, " = [0, 0, 0] has no direction"));
    return {};
}

std::optional<Eigen::Vector3d> direction_or_word(const Value* value, const std::string& shown, Diagnostics& errors) {
    if (!value || value->form != Value::Form::scalar) return direction_of(value, shown, errors);
    Eigen::Vector3d unit = Eigen::Vector3d::Zero();
    unit[value->text[1] - 'x'] = value->text[0] == '-' ? -1 : 1;
    return unit;
}

std::vector<Reference> references(const Value* list) {
    std::vector<Reference> all;
    if (!list) return all;
    for (const Entry& entry : list->entries)
        if (entry.value.accepted) all.push_back({entry.value.text, entry.value.place});
    return all;
}

std::vector<std::string> texts(const Value* list) {
    std::vector<std::string> all;
    for (const Reference& item : references(list)) all.push_back(item.name);
    return all;
}

void CaseReader::read(const Value& root) {
    const auto map = [&](const char* key, void (CaseReader::*reader)(const Value&)) {
        if (const Value* v = root.find(key)) (this->*reader)(*v);
    };
    const auto entries = [&](const char* key, void (CaseReader::*reader)(const Entry&)) {
        if (const Value* v = root.find(key))
            for (const Entry& entry : v->entries) (this->*reader)(entry);
    };
    if (const Value* v = root.find("case")) case_.name = v->text;
    map("surface", &CaseReader::read_surface_entry);
    map("repair", &CaseReader::read_repair);
    map("remesh", &CaseReader::read_remesh);
    entries("regions", &CaseReader::read_region);
    if (const Value* v = root.find("fixed")) {
        case_.fixed = references(v);
        case_.fixed_place = v->place;
    }
    map("hold", &CaseReader::read_hold);
    map("invariance", &CaseReader::read_invariance);
    map("symmetry", &CaseReader::read_symmetry);
    map("axes", &CaseReader::read_axes);
    entries("planform", &CaseReader::read_wing);
    map("shell", &CaseReader::read_shell);
    map("wrap", &CaseReader::read_wrap);
    map("loads", &CaseReader::read_loads);
    map("strains", &CaseReader::read_strains);
    map("attach", &CaseReader::read_attach);
    map("parameters", &CaseReader::read_parameters);
    entries("variables", &CaseReader::read_program_parameter);
    entries("quantities", &CaseReader::read_quantity);
    map("objective", &CaseReader::read_objective);
    case_.fit = references(root.find("fit"));
    entries("constraints", &CaseReader::read_constraint);
    map("optimize", &CaseReader::read_optimize);
    map("sample", &CaseReader::read_sample);
    map("output", &CaseReader::read_output);
}

void read_case(const Value& root, const std::filesystem::path& case_dir, Case& the_case, Diagnostics& errors) {
    CaseReader(case_dir, the_case, errors).read(root);
}

}  // namespace strake
