#pragma once
#include "casefile/read/read_case.hpp"

/// From the checked tree to the structs, topic by topic. Between the reader's files; not for others.
namespace strake {

class CaseReader {
public:
    CaseReader(const std::filesystem::path& dir, Case& out, Diagnostics& errors)
        : dir_(dir), case_(out), errors_(errors) {}
    void read(const Value& root);

private:
    const std::filesystem::path& dir_;
    Case& case_;
    Diagnostics& errors_;

    // read_surface.cpp
    void read_surface_entry(const Value& map);
    // read_repair.cpp
    void read_repair(const Value& map);
    void read_remesh(const Value& map);
    void read_region(const Entry& entry);
    bool read_shape(const Value& map, const std::string& kind, Region& region);
    bool read_box(const Value& list, const std::string& shown, Region& region);
    // read_made_regions.cpp
    bool read_made_region(const Value& map, const std::string& kind, const Value& value, Region& region);
    // read_planform.cpp
    void read_planform_range(const Entry& entry);
    bool read_change_range(const Value* list, const std::string& shown, PlanformRange& range);
    void read_wing(const Entry& entry);
    void read_body(const Entry& entry);
    std::vector<double> read_sections(const Value* list, const std::string& shown);
    bool read_wing_region(const Value& map, const Value& of, Region& region);
    bool read_range(const Value* list, const std::string& shown, std::array<double, 2>& range);
    // read_surface.cpp
    void read_symmetry(const Value& map);
    void read_axes(const Value& map);
    // read_shell.cpp
    void read_shell(const Value& map);
    void read_wrap(const Value& value);
    void read_loads(const Value& list);
    void read_strains(const Value& list);
    void read_attach(const Value& list);
    // read_parameters.cpp
    void read_parameters(const Value& map);
    void read_levels(const Value& map);
    void read_variable_places(const Value& map);
    void read_variables(const std::vector<std::string>& words);
    void read_directions(const Value* list);
    void read_motion_limits(const Value& limit);
    void read_split(const Value& map);
    // read_user_variables.cpp
    void read_user_variables(const Value& map, const std::string& shown);
    // read_fields.cpp
    void read_fields(const Value& value);
    void read_hold(const Value& value);
    void read_invariance(const Value& map);
    // read_program_parameters.cpp
    void read_program_parameter(const Entry& entry);
    // read_quantities.cpp
    ExternalEntry read_external(const Value& map, const std::string& name);
    void read_gradient_keys(const Value& map, const std::string& name, ExternalEntry& external);
    void read_where_it_runs(const Value& map, ExternalEntry& external) const;
    void read_on_failure(const Value& policy, const std::string& name, ExternalEntry& external);
    void read_quantity(const Entry& entry);
    void read_built_in(const std::string& type, const Value& map, QuantityEntry& quantity);
    LineThicknessEntry read_line_thickness(const Value& map, const std::string& shown);
    void read_objective(const Value& map);
    void read_constraint(const Entry& entry);
    void check_limit_unit(const Value& map, const char* key, const std::string& quantity, const std::string& shown);
    // read_run.cpp
    void read_optimize(const Value& map);
    void read_sample(const Value& map);
    void read_fitting(const Value& map);
    void read_stopping(const Value& map);
    void read_output(const Value& map);
};

/// `number` stays where there is no accepted value.
void set(double& number, const Value* value);
void set(int& number, const Value* value);
void set(bool& flag, const Value* value);
/// Three accepted numbers, or nothing.
std::optional<Eigen::Vector3d> vector_of(const Value* list);
Length length_of(const Value& value);
/// A vector of length one. @return nothing, with an error, for the zero vector.
std::optional<Eigen::Vector3d> direction_of(const Value* list, const std::string& shown, Diagnostics& errors);
/// The same from "+x" or a list.
std::optional<Eigen::Vector3d> direction_or_word(const Value* value, const std::string& shown, Diagnostics& errors);
/// The accepted names of a list, with their places; `list` may be null.
std::vector<Reference> references(const Value* list);
std::vector<std::string> texts(const Value* list);

}  // namespace strake
