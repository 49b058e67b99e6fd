#pragma once
#include "objectives/quantity/quantity.hpp"

#include <filesystem>

/// Shared libraries as quantities (include/strake/plugin.h; for users docs/external.md).
namespace strake {

struct PluginLibrary {
    std::string name;               ///< of the quantity; values are named like those of an ExternalCommand
    std::filesystem::path library;  ///< file
    std::string options;            ///< passed to the library verbatim; without NUL
    std::vector<std::string> outputs;
    bool has_gradients = true;
    std::optional<std::vector<std::string>> depends_on;  ///< parameters that the values depend on; default: all
    bool may_lack_derivatives = false;  ///< by parameters: NaN if missing; false: a missing one is a failure
};

/// Loads the library now and keeps it until the program ends. Its errors in an evaluation become the result's failure:
/// `plugin` (its own message), not_finite, exception.
/// @throws InvalidInput: it cannot be loaded, lacks a symbol, is of another version, or refuses the options.
Quantity plugin(const PluginLibrary& plugin);

}  // namespace strake
