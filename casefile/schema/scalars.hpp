#pragma once
#include "casefile/schema/schema.hpp"

/// Strict conversion of scalars. Refuses what YAML tools read in two ways (010, 1_000, yes, .nan, quoted numbers).
namespace strake {

/// Surroundings of a scalar.
struct ScalarContext {
    std::filesystem::path case_dir;
    std::string units;  ///< of the surface; empty: not stated
};

/// Converts `value.text` by `type` into value.number and value.relative (see Value); limits and words included.
/// @return the reason for refusing, to follow "path = text "; empty when accepted.
std::string convert_scalar(Value& value, Type type, const Key& key, const ScalarContext& context);

/// Number as the whole text: digits, point, exponent; finite. @return the reason for refusing, or empty.
std::string read_number(const std::string& text, double& number);

/// Lower case, without "nlopt_", "ld_", "ln_", "gd_", "gn_", "g_" and '-': how names of algorithms are compared.
std::string algorithm_word(const std::string& name);

/// Degrees of an angle in radians, rounded to 1e-12: 90deg comes back as 90.
double degrees(double radians);

/// "3deg" of an angle in radians, else the number.
std::string shown_value(double value, bool is_angle);

const std::vector<std::string>& length_units();

}  // namespace strake
