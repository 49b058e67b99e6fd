#pragma once
#include <string>
#include <vector>

namespace strake {

/// What result.json says.
struct ProgramResult {
    std::vector<double> values;                    ///< one per wanted name
    std::vector<std::string> gradient_files;       ///< one per wanted name where gradients are wanted, else empty
    std::vector<std::string> gradient_fields;      ///< of each of these files; "": the only one
    std::vector<std::vector<double>> by_variable;  ///< likewise, one per wanted variable; NaN where there is none
};

/// Reads the text of result.json: {"values": {name: number}, "gradients": {name: "file.csv"}, "variables": {name:
/// {variable: number}}, "info": {…}} (a gradient also {"file": "out.vtp", "field": "dDrag"}), or "value", "gradient"
/// and "variables": {variable: number} where there is one. `gives` holds the names, none for a single unnamed value;
/// names beyond those are left alone.
/// @param variables names of those whose derivatives are wanted, with the gradients.
/// @param may_lack a derivative that is missing (not one that is misspelt) becomes NaN.
/// @param name of the file, for messages. @param want_values false: values may be missing, as after `gradient_command`.
/// @throws Refused: unreadable (line:column), missing_key, wrong_type, not_finite.
ProgramResult parse_result(const std::string& bytes, const std::vector<std::string>& gives, bool want_gradients,
                           const std::vector<std::string>& variables = {}, bool may_lack = false,
                           const std::string& name = "result.json", bool want_values = true);

}  // namespace strake
