#pragma once
#include "casefile/model/case.hpp"
#include "casefile/yaml/value.hpp"

namespace strake {

/// The file that the case was read from.
struct Case::Source {
    Value root;  ///< checked, defaults filled in
    std::vector<std::string> lines;
    std::vector<std::string> settings;  ///< KEY=VALUE of the command line, already in `root`
};

}  // namespace strake
