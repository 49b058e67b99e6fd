#pragma once
#include "core/planform/fuselage.hpp"
#include "objectives/quantity/quantity.hpp"

#include <memory>

/// Quantities of a body by its length: `fuselage.length`, `fuselage.width@0.5`.
namespace strake {

/// "length", "width@0.5": a word and, but for the length, the fraction of the length where it is taken.
struct FuselageValue {
    std::string word;
    double station = 0;
};
/// @throws InvalidInput: an unknown word, a fraction that is missing, superfluous or outside of [0, 1].
FuselageValue parse_fuselage_value(const std::string& name);

/// The named values of the body, in this order, with exact derivatives by the vertices. Camber is over the length.
/// `evaluate` fails with kind `undefined` where a section does not exist.
/// @throws InvalidInput for the same at the start, naming the value; a name that is none.
Quantity fuselage_values(const std::string& name, const TriMesh& start, std::shared_ptr<const Fuselage> body,
                         const std::vector<std::string>& values);

}  // namespace strake
