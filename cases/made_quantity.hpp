#pragma once
#include "cases/diagnostics.hpp"
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity.hpp"

#include <filesystem>
#include <optional>

/// Built-in quantities that a case makes by name of their `type`: what each family reads, and what it needs to be made.
namespace strake {

struct Value;

/// A name used somewhere, and where.
struct Reference {
    std::string name;
    Place place;
};

/// What a quantity is made of besides its own keys.
struct QuantityGround {
    const TriMesh& start;
    double diagonal;
    const std::optional<SymmetryPlane>& symmetry;
    std::function<std::vector<char>(const Reference& region)> marks;  ///< per triangle
};

struct MadeQuantity {
    std::vector<std::string> gives = {};    ///< names of its values, behind the dot; empty: one, called as the quantity
    std::vector<Reference> variables = {};  ///< the case's own that it reads
    std::vector<Reference> regions = {};    ///< that it names
    /// @param name of the quantity. @throws InvalidInput; InputError about a file.
    std::function<Quantity(const std::string& name, const QuantityGround& ground)> make;
};

/// Nothing for the types of other families. @param shown "quantities.aero".
std::optional<MadeQuantity> read_aero(const std::string& type, const Value& map, const std::string& shown,
                                      Diagnostics& errors);

std::optional<MadeQuantity> read_form(const std::string& type, const Value& map, const std::string& shown,
                                      const std::filesystem::path& dir, Diagnostics& errors);

}  // namespace strake
