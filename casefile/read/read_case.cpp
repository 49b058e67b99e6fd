#include "casefile/read/case_reader.hpp"

namespace strake {

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
    if (const Value* v = root.find("case")) case_.name = v->text;
    if (const Value* v = root.find("surface")) read_surface_entry(*v);
    if (const Value* v = root.find("repair")) read_repair(*v);
    if (const Value* v = root.find("remesh")) read_remesh(*v);
    if (const Value* v = root.find("regions"))
        for (const Entry& entry : v->entries) read_region(entry);
    if (const Value* v = root.find("fixed")) {
        case_.fixed = references(v);
        case_.fixed_place = v->place;
    }
    if (const Value* v = root.find("symmetry")) read_symmetry(*v);
    if (const Value* v = root.find("shell")) read_shell(*v);
    if (const Value* v = root.find("loads")) read_loads(*v);
    if (const Value* v = root.find("strains")) read_strains(*v);
    if (const Value* v = root.find("attach")) read_attach(*v);
    if (const Value* v = root.find("parameters")) read_parameters(*v);
    if (const Value* v = root.find("variables"))
        for (const Entry& entry : v->entries) read_program_parameter(entry);
    if (const Value* v = root.find("quantities"))
        for (const Entry& entry : v->entries) read_quantity(entry);
    if (const Value* v = root.find("objective")) read_objective(*v);
    case_.fit = references(root.find("fit"));
    if (const Value* v = root.find("constraints"))
        for (const Entry& entry : v->entries) read_constraint(entry);
    if (const Value* v = root.find("optimize")) read_optimize(*v);
    if (const Value* v = root.find("output")) read_output(*v);
}

void read_case(const Value& root, const std::filesystem::path& case_dir, Case& the_case, Diagnostics& errors) {
    CaseReader(case_dir, the_case, errors).read(root);
}

}  // namespace strake
