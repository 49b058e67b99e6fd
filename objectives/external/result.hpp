#pragma once
#include <string>
#include <vector>

namespace strake {

/// What result.json says.
struct ProgramResult {
    std::vector<double> values;               ///< one per wanted name
    std::vector<std::string> gradient_files;  ///< one per wanted name where gradients are wanted, else empty
};

/// Reads the text of result.json: {"values": {name: number}, "gradients": {name: "file.csv"}, "variables": {name:
/// {variable: number}}, "info": {…}}, or "value" and "gradient" where there is one. `gives` holds the names, none for
/// a single unnamed value; names beyond those are left alone.
/// @throws Refused: unreadable (line:column), missing_key, wrong_type, not_finite.
ProgramResult parse_result(const std::string& bytes, const std::vector<std::string>& gives, bool want_gradients);

}  // namespace strake
