#pragma once
#include <string>
#include <vector>

/// What a program writes: result.json, its text to values and names of gradient files. Internal.
namespace strake {

/// Contents of result.json.
struct ProgramResult {
    std::vector<double> values;                    ///< one per output
    std::vector<std::string> gradient_files;       ///< one per output if gradients are requested, else empty
    std::vector<std::string> gradient_fields;      ///< field in each of these files; "": the only one
    std::vector<std::vector<double>> by_variable;  ///< likewise, one per requested variable; NaN if missing
};

/// Reads the text of result.json: {"values": {name: number}, "gradients": {name: "file.csv"}, "variables": {name:
/// {variable: number}}, "info": {…}} (a gradient also {"file": "out.vtp", "field": "dDrag"}), or "value", "gradient"
/// and "variables": {variable: number} for a single output. `outputs` holds the names, none for a single unnamed value;
/// other names are ignored.
/// @param variables names for the derivatives requested with the gradients
/// @param may_lack a missing derivative (not a misspelt one) becomes NaN
/// @param name of the file, for messages. @param want_values false: values may be missing, as after `gradient_command`.
/// @throws Refused: unreadable (line:column), missing_key, wrong_type, not_finite.
ProgramResult parse_result(const std::string& bytes, const std::vector<std::string>& outputs, bool want_gradients,
                           const std::vector<std::string>& variables = {}, bool may_lack = false,
                           const std::string& name = "result.json", bool want_values = true);

}  // namespace strake
