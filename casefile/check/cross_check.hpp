#pragma once
#include "casefile/model/case_source.hpp"

/// Checks beyond the table of keys. Between the files of check/; others call `cross_check`.
namespace strake {

/// References, exclusive keys, limits of methods, programs.
void cross_check(const Value& root, Purpose purpose, Case& the_case, Diagnostics& errors);

/// "region 'tpi' is not declared; did you mean 'tip'? Regions: root, tip"
void check_region(const Case& the_case, const Reference& reference, Diagnostics& errors);

/// `variables` and `depends_on` agree, and some quantity depends on each variable.
void check_program_parameters(const Value& root, const Case& the_case, Diagnostics& errors);

/// `parameters.given` agrees with the rest of the case, as far as names show.
void check_user_variables(const Case& the_case, Diagnostics& errors);

}  // namespace strake
