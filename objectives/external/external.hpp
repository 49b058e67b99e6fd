#pragma once
#include "objectives/quantity.hpp"

#include <filesystem>

/// Other people's programs (DESIGN section 7, External evaluation).
namespace strake {

struct ExternalCommand {
    std::string name;  ///< of the quantity; values are called name.value, or name where there is one
    std::vector<std::string>
        command;  ///< argument list, run without a shell; placeholders {surface} {request} {result} {folder} {case_dir}
    std::vector<std::string> gives;  ///< names of the values; empty: one value
    double timeout_s = 3600;         ///< per evaluation, > 0; then TERM, grace, KILL to the process group
    double grace_s = 5;
    std::string format;                     ///< of the surface handed over: stl, stl-ascii, obj, ply, off, tri
    std::filesystem::path case_dir;         ///< program paths containing '/' are relative to it
    std::filesystem::path evaluations_dir;  ///< fresh folders 000001, 000002, … are made here
    bool has_gradients = true;              ///< false: never asked for sensitivities
    double diagonal = 0;  ///< of the start surface; rows with coordinates are matched within 1e-5 of it
    std::string units;    ///< of length, as the case states it, for request.json
};

Quantity external(const ExternalCommand& command);

}  // namespace strake
