#pragma once
#include "cases/case.hpp"
#include "cases/value.hpp"

/// Between the loader's files; not for others.
namespace strake {

/// What the case was read from.
struct Case::Source {
    Value root;  ///< checked, defaults filled in
    std::vector<std::string> lines;
};

/// Fills the structs from the checked tree; whatever was refused is left out.
void read_case(const Value& root, const std::filesystem::path& case_dir, Case& the_case, Diagnostics& errors);

/// Reads the formulas and puts them behind all other quantities. Before `cross_check`.
void set_formulas(Case& the_case, Diagnostics& errors);

/// What the table cannot say: references, exclusive keys, limits of methods, programs.
void cross_check(const Value& root, Purpose purpose, Case& the_case, Diagnostics& errors);

/// "region 'tpi' is not declared; did you mean 'tip'? Regions: root, tip"
void check_region(const Case& the_case, const Reference& reference, Diagnostics& errors);

/// What `variables` and `depends_on` say fits together, and somebody reads each variable.
void check_own_variables(const Value& root, const Case& the_case, Diagnostics& errors);

/// What `parameters.given` says fits together with the rest of the case, as far as names tell.
void check_given(const Case& the_case, Diagnostics& errors);

/// Names of all values that objective, fit and constraints may use, `volume` and `area` included.
std::vector<std::string> known_values(const Case& the_case);

}  // namespace strake
