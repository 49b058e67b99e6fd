#pragma once
#include "core/planform/wing.hpp"
#include "objectives/quantity/quantity.hpp"

#include <array>
#include <memory>

/// Quantities of a wing: `wing.area`, `wing.twist@0.37`.
namespace strake {

/// What the wing's own values need beyond its declaration.
struct WingValueOptions {
    std::array<double, 2> box_chord{0.15, 0.65}, box_span{0, 0.95};  ///< of box_volume, fractions
    std::shared_ptr<const Wing> ahead = {};                          ///< of gap and overlap
};

/// A value's name behind the wing's: a word, and the fractions of the semispan and of the chord where it is taken.
struct WingValue {
    std::string word;
    std::optional<double> station, chord;
    std::optional<double> second;  ///< station, of a step from the first to this
};
struct WingWord {
    std::string word, doc;
    int places = 0;              ///< fractions behind it: 1 of the semispan, 2 of the semispan and of the chord
    bool is_angle = false;       ///< radians
    bool is_step = false;        ///< both places are of the semispan
    bool is_also_whole = false;  ///< without a fraction: of the whole wing
    bool is_slot = false;        ///< between it and the wing ahead
};
const std::vector<WingWord>& wing_words();

/// "twist@0.37", "area", "thickness@0.3@0.15", "twist_step@0.2@0.5". @throws InvalidInput: an unknown word (with the
/// nearest), fractions that are missing, superfluous or outside of [0, 1].
WingValue parse_wing_value(const std::string& name);
bool is_angle(const WingValue& value);
bool is_slot(const WingValue& value);

/// The named values of the wing, in this order, with exact derivatives by the vertices; those of the whole wing, also
/// on half a model (`WingFacts`, `StationFacts`). Leading-edge radii are over the chord.
/// `evaluate` fails with kind `undefined` where a section does not exist.
/// @throws InvalidInput for the same at the start, naming the value; a name that is none.
Quantity wing_values(const std::string& name, const TriMesh& start, std::shared_ptr<const Wing> wing,
                     const std::vector<std::string>& values, const WingValueOptions& options = {});

}  // namespace strake
