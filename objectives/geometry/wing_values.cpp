#include "objectives/geometry/wing_values.hpp"

#include "core/error.hpp"
#include "core/text/edit_distance.hpp"
#include "objectives/geometry/measured_values.hpp"

#include <array>
#include <charconv>
#include <map>

namespace strake {
namespace {

/// All values of one surface; what several of them share is measured once.
class MeasuredWing {
public:
    MeasuredWing(const Wing& wing, const TriMesh& surface, const WingValueOptions& options, bool sensitivities)
        : wing_(wing), surface_(surface), options_(options), sensitivities_(sensitivities) {}

    Varying operator()(const WingValue& value) {
        const std::string& word = value.word;
        if (word == "box_volume")
            return wing_.volume(surface_, {options_.box_chord[0], options_.box_chord[1]},
                                {options_.box_span[0], options_.box_span[1]}, sensitivities_);
        if (word == "thickness") {
            Varying total;
            const auto airfoils = wing_.sections(surface_, *value.station, sensitivities_);
            for (const Airfoil& airfoil : airfoils) total = total + airfoil.thickness(*value.chord);
            return total * (1.0 / static_cast<double>(airfoils.size()));
        }
        if (word == "twist_step") return at_station("twist", *value.second) - at_station("twist", *value.station);
        if (word == "chord_step") return at_station("chord", *value.second) - at_station("chord", *value.station);
        if (word == "sweep" && value.station) return panel_at(*value.station).sweep;
        if (word == "dihedral" && value.station) return panel_at(*value.station).dihedral;
        if (is_slot(value)) return word == "gap" ? slot_at(*value.station).gap : slot_at(*value.station).overlap;
        if (word == "spar_offset") return spar_offset(*value.station, *value.chord);
        return value.station ? at_station(word, *value.station) : of_wing(word);
    }

private:
    Varying of_wing(const std::string& word) {
        if (!facts_) facts_ = wing_.facts(surface_, sensitivities_);
        if (word == "span") return facts_->span;
        if (word == "area") return facts_->area;
        if (word == "aspect_ratio") return facts_->aspect_ratio;
        if (word == "taper") return facts_->taper;
        if (word == "sweep") return facts_->sweep;
        if (word == "dihedral") return facts_->dihedral;
        return facts_->mean_chord;
    }
    /// How far downstream a fraction of the chord lies of the straight line through it at the first and last station.
    Varying spar_offset(double station, double fraction) {
        const auto spar = [&](double s) {
            const StationFacts& at = facts_at(s);
            return (1 - fraction) * at.leading_x + fraction * at.trailing_x;
        };
        const double ratio = wing_.place(0, station) / wing_.place(0, 1);
        return spar(station) - ((1 - ratio) * spar(0) + ratio * spar(1));
    }
    const PanelFacts& panel_at(double station) {
        auto known = panels_.find(station);
        if (known == panels_.end())
            known = panels_.emplace(station, wing_.panel(surface_, station, sensitivities_)).first;
        return known->second;
    }
    const SlotFacts& slot_at(double station) {
        if (!options_.ahead) throw InvalidInput("no wing is ahead of this one");
        auto known = slots_.find(station);
        if (known == slots_.end())
            known = slots_.emplace(station, wing_.slot(surface_, *options_.ahead, station, sensitivities_)).first;
        return known->second;
    }
    const StationFacts& facts_at(double station) {
        auto known = stations_.find(station);
        if (known == stations_.end())
            known = stations_.emplace(station, wing_.station(surface_, station, sensitivities_)).first;
        return known->second;
    }
    Varying at_station(const std::string& word, double station) {
        const StationFacts& at = facts_at(station);
        if (word == "chord") return at.chord;
        if (word == "twist") return at.twist;
        if (word == "thickness_to_chord") return at.thickness_to_chord;
        if (word == "camber") return at.camber;
        if (word == "trailing_edge_angle") return at.trailing_edge_angle;
        if (word == "trailing_edge_thickness") return at.trailing_edge_thickness;
        if (!at.leading_edge_radius)
            throw InvalidInput(text("the section at ", 100 * station,
                                    " % of the semispan has no leading-edge radius: fewer than seven points within 4 % "
                                    "of the chord, or no round nose"));
        return *at.leading_edge_radius;
    }

    const Wing& wing_;
    const TriMesh& surface_;
    const WingValueOptions& options_;
    bool sensitivities_;
    std::optional<WingFacts> facts_;
    std::map<double, StationFacts> stations_;
    std::map<double, PanelFacts> panels_;
    std::map<double, SlotFacts> slots_;
};

double fraction_of(const std::string& name, const std::string& digits) {
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size() || !(value >= 0 && value <= 1))
        throw InvalidInput(text("'", name, "': '", digits, "' must be a fraction in [0, 1]"));
    return value;
}

const WingWord* word_named(const std::string& word) {
    for (const WingWord& known : wing_words())
        if (known.word == word) return &known;
    return nullptr;
}

}  // namespace

const std::vector<WingWord>& wing_words() {
    static const std::vector<WingWord> words{
        {"span", "from tip to tip", 0, false},
        {"area", "of the exposed wing, both sides", 0, false},
        {"aspect_ratio", "square of the exposed span over the area", 0, false},
        {"taper", "last chord over first chord", 0, false},
        {"sweep", "of the axis, tip aft; at a fraction, of the panel between two stations", 1, true, false, true},
        {"dihedral", "of the axis, tip up; at a fraction, of the panel between two stations", 1, true, false, true},
        {"mean_chord", "mean aerodynamic chord", 0, false},
        {"box_volume", "volume between two spars, both sides", 0, false},
        {"chord", "chord", 1, false},
        {"twist", "nose up, against the stream", 1, true},
        {"thickness_to_chord", "largest thickness over the chord", 1, false},
        {"camber", "largest height of the mean line over the chord", 1, false},
        {"leading_edge_radius", "radius over the chord", 1, false},
        {"trailing_edge_angle", "angle between upper and lower surface over the last 5 %", 1, true},
        {"trailing_edge_thickness", "thickness of the blunt edge", 1, false},
        {"thickness", "thickness at a fraction of the chord", 2, false},
        {"twist_step", "twist at the second fraction of the semispan less that at the first", 2, true, true},
        {"chord_step", "likewise of the chord", 2, false, true},
        {"spar_offset",
         "how far aft a fraction of the chord lies of the straight line through it at root and tip, a length", 2,
         false},
        {"gap", "distance of the trailing edge of the wing ahead (behind)", 1, false, false, false, true},
        {"overlap", "how far that trailing edge lies downstream of the leading edge", 1, false, false, false, true}};
    return words;
}

namespace {

[[noreturn]] void refuse_word(const std::string& word) {
    std::string all, near;
    int least = 3;  // more edits than that are another word
    for (const WingWord& known : wing_words()) {
        all += (all.empty() ? "" : ", ") + known.word;
        if (const int edits = edit_distance(word, known.word); edits < least) least = edits, near = known.word;
    }
    throw InvalidInput(text("a wing has no value '", word, "'",
                            near.empty() ? ". Values: " : text("; did you mean '", near, "'? Values: "), all));
}

}  // namespace

WingValue parse_wing_value(const std::string& name) {
    std::vector<std::string> parts(1);
    for (const char c : name)
        if (c == '@')
            parts.emplace_back();
        else
            parts.back() += c;
    const WingWord* known = word_named(parts[0]);
    if (!known) refuse_word(parts[0]);
    if (known->is_also_whole && parts.size() == 1) return {known->word, {}, {}, {}};
    if (static_cast<int>(parts.size()) - 1 != known->places) {
        if (known->is_step)
            throw InvalidInput(
                text("'", name, "': write '", known->word, "@0.2@0.5' with two fractions of the semispan"));
        const std::array<const char*, 3> shape{", a value of the whole wing", "@0.5' with a fraction of the semispan",
                                               "@0.5@0.3' with fractions of the semispan and of the chord"};
        throw InvalidInput(text("'", name, "': write '", known->word, known->places == 0 ? "'" : "",
                                shape[static_cast<std::size_t>(known->places)]));
    }
    WingValue value{known->word, {}, {}, {}};
    if (known->places > 0) value.station = fraction_of(name, parts[1]);
    if (known->places > 1) (known->is_step ? value.second : value.chord) = fraction_of(name, parts[2]);
    return value;
}

bool is_angle(const WingValue& value) {
    const WingWord* known = word_named(value.word);
    return known && known->is_angle;
}

bool is_slot(const WingValue& value) {
    const WingWord* known = word_named(value.word);
    return known && known->is_slot;
}

Quantity wing_values(const std::string& name, const TriMesh& start, std::shared_ptr<const Wing> wing,
                     const std::vector<std::string>& values, const WingValueOptions& options) {
    return measured_values(name, start, values, parse_wing_value, [=](const TriMesh& surface, bool sensitivities) {
        return MeasuredWing(*wing, surface, options, sensitivities);
    });
}

}  // namespace strake
