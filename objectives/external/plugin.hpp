#pragma once
#include "objectives/quantity.hpp"

#include <filesystem>

/// Shared libraries as quantities (include/strake/plugin.h; for users docs/external.md).
namespace strake {

struct PluginLibrary {
    std::string name;               ///< of the quantity; values are called as those of an ExternalCommand
    std::filesystem::path library;  ///< file
    std::string options;            ///< handed to the library as it is; without NUL
    std::vector<std::string> gives;
    bool has_gradients = true;
    std::optional<std::vector<std::string>> depends_on;  ///< own variables; without it all
    bool may_lack_derivatives = false;                   ///< by own variables: NaN then; else their lack is a failure
};

/// Loads the library now and keeps it until the program ends. What it does wrong in an evaluation is the result's
/// failure: `plugin` (its own words), not_finite, exception.
/// @throws InvalidInput: it cannot be loaded, lacks a symbol, is of another version, or refuses the options.
Quantity plugin(const PluginLibrary& plugin);

}  // namespace strake
