#pragma once
#include "casefile/yaml/diagnostics.hpp"
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity/quantity.hpp"

#include <filesystem>
#include <memory>
#include <optional>

/// Built-in quantities by the name of their `type`.
namespace strake {

struct Value;
class Fuselage;
class Wing;

/// A name used somewhere, and where.
struct Reference {
    std::string name;
    Place place;
};

/// Of the body; the right wing points along up x downstream.
struct BodyAxes {
    Eigen::Vector3d downstream = Eigen::Vector3d::UnitX(), up = Eigen::Vector3d::UnitZ();  ///< unit, perpendicular
    bool is_stated = false;  ///< in the case, not by default
    Place place = {};
    Eigen::Vector3d right() const { return up.cross(downstream); }
};

/// What quantities with a stream take from the case.
struct AeroGround {
    std::optional<BodyAxes> axes = {};
    std::optional<SymmetryPlane> symmetry = {};
    bool whole_coefficients = false;  ///< of a half model
    bool keeps_side_values = false;   ///< side force, roll and yaw of a half model: of a run that began so
};

/// The surroundings from which a quantity is built.
struct QuantityContext {
    const TriMesh& start;
    double diagonal;
    const std::optional<SymmetryPlane>& symmetry;
    std::function<std::vector<char>(const Reference& region)> marks;  ///< per triangle
    /// A declared wing. @throws InvalidInput where it cannot be measured.
    std::function<std::shared_ptr<const Wing>(const std::string& name)> wing = {};
    std::function<std::shared_ptr<const Fuselage>(const std::string& name)> body = {};  ///< likewise
};

struct BuiltInEntry {
    std::vector<std::string> outputs =
        {};  ///< names of its values, behind the dot; empty: one, named like the quantity
    std::vector<Reference> variables = {};  ///< `variables` that it reads
    std::vector<Reference> regions = {};    ///< that it names
    std::optional<BodyAxes> axes = {};      ///< of its stream
    std::vector<std::string> omitted = {};  ///< outputs that a half model does not have
    /// @param name of the quantity. @throws InvalidInput; InputError about a file.
    std::function<Quantity(const std::string& name, const QuantityContext& ground)> make;
};

/// Nothing for the types of other families. @param shown "quantities.aero".
std::optional<BuiltInEntry> read_aero(const std::string& type, const Value& map, const std::string& shown,
                                      const std::filesystem::path& dir, const AeroGround& ground, Diagnostics& errors);

std::optional<BuiltInEntry> read_geometry(const std::string& type, const Value& map, const std::string& shown,
                                          const std::filesystem::path& dir, Diagnostics& errors);

}  // namespace strake
