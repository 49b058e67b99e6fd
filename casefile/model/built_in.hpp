#pragma once
#include "casefile/yaml/diagnostics.hpp"
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity/quantity.hpp"

#include <filesystem>
#include <optional>

/// Built-in quantities by the name of their `type`.
namespace strake {

struct Value;

/// A name used somewhere, and where.
struct Reference {
    std::string name;
    Place place;
};

/// The surroundings from which a quantity is built.
struct QuantityContext {
    const TriMesh& start;
    double diagonal;
    const std::optional<SymmetryPlane>& symmetry;
    std::function<std::vector<char>(const Reference& region)> marks;  ///< per triangle
};

struct BuiltInEntry {
    std::vector<std::string> outputs =
        {};  ///< names of its values, behind the dot; empty: one, named like the quantity
    std::vector<Reference> variables = {};  ///< `variables` that it reads
    std::vector<Reference> regions = {};    ///< that it names
    /// @param name of the quantity. @throws InvalidInput; InputError about a file.
    std::function<Quantity(const std::string& name, const QuantityContext& ground)> make;
};

/// Nothing for the types of other families. @param shown "quantities.aero".
std::optional<BuiltInEntry> read_aero(const std::string& type, const Value& map, const std::string& shown,
                                      Diagnostics& errors);

std::optional<BuiltInEntry> read_geometry(const std::string& type, const Value& map, const std::string& shown,
                                          const std::filesystem::path& dir, Diagnostics& errors);

}  // namespace strake
