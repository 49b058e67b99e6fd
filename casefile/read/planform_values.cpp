#include "casefile/read/read_case.hpp"
#include "objectives/geometry/fuselage_values.hpp"
#include "objectives/geometry/wing_values.hpp"

#include <algorithm>

/// Values of wings: `wing.area` in objective, constraints and formulas.
namespace strake {
namespace {

/// What a constraint on many places of a wing stands for: one on each of them.
std::vector<std::string> places_of(const WingEntry& wing, const std::string& word) {
    std::vector<std::string> all;
    if (word == "thickness_grid" || word == "spar_offset_grid") {
        for (const double s : wing.grid_span)
            for (const double x : word == "thickness_grid"
                                      ? wing.grid_chord
                                      : std::vector<double>(wing.box_chord.begin(), wing.box_chord.end()))
                all.push_back(text(word.substr(0, word.size() - 5), "@", s, "@", x));
        return all;
    }
    for (const WingWord& known : wing_words()) {
        if (known.is_step && word == known.word + "_grid")
            for (std::size_t k = 1; k < wing.grid_span.size(); ++k)
                all.push_back(text(known.word, "@", wing.grid_span[k - 1], "@", wing.grid_span[k]));
        if (known.places == 1 && word == known.word + "_grid")
            for (const double s : wing.grid_span) all.push_back(text(known.word, "@", s));
    }
    return all;
}

bool is_name_character(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-';
}

/// What stands behind "wing." in a formula, in its order.
std::vector<std::string> values_in(const std::string& formula, const std::string& wing) {
    std::vector<std::string> found;
    const std::string prefix = wing + ".";
    for (std::size_t at = formula.find(prefix); at != std::string::npos; at = formula.find(prefix, at + 1)) {
        if (at > 0 && (is_name_character(formula[at - 1]) || formula[at - 1] == '.' || formula[at - 1] == '@'))
            continue;
        // Fractions may have a point; a minus ends the name.
        std::size_t end = at + prefix.size();
        while (end < formula.size() && formula[end] != '-' &&
               (is_name_character(formula[end]) || formula[end] == '@' || formula[end] == '.'))
            ++end;
        found.push_back(formula.substr(at + prefix.size(), end - at - prefix.size()));
    }
    return found;
}

/// A constraint on the grid is one on each of its places.
void expand_grid(Case& c, const WingEntry& wing) {
    std::vector<ConstraintEntry> all;
    for (const ConstraintEntry& entry : c.constraints) {
        const std::string& name = entry.constraint.quantity;
        const std::vector<std::string> places = name.starts_with(wing.name + ".")
                                                    ? places_of(wing, name.substr(wing.name.size() + 1))
                                                    : std::vector<std::string>();
        if (places.empty()) all.push_back(entry);
        for (const std::string& place : places) {
            all.push_back(entry);
            all.back().constraint.quantity = wing.name + "." + place;
        }
    }
    c.constraints = std::move(all);
}

/// What objective, constraints and formulas name of a wing or a body, and what it records itself.
struct Named {
    std::vector<std::string> values = {};
    Place place = {};
};

template <class Parse>
Named named_values(const Case& c, const std::string& name, const Place& declared,
                   const std::vector<Reference>& recorded, const Parse& parse, Diagnostics& errors) {
    Named found{{}, declared};
    const auto take = [&](const std::string& value, const Place& where) {
        if (std::find(found.values.begin(), found.values.end(), value) != found.values.end()) return;
        try {
            parse(value);
        } catch (const InvalidInput& error) {
            errors.add(where, text("planform.", name, ": ", error.what()));
            return;
        }
        if (found.values.empty()) found.place = where;
        found.values.push_back(value);
    };
    const auto take_all = [&](const std::string& formula, const Place& where) {
        for (const std::string& value : values_in(formula, name)) take(value, where);
    };
    take_all(c.objective.name, c.objective.place);
    for (const QuantityEntry& quantity : c.quantities)
        if (const auto* formula = std::get_if<FormulaEntry>(&quantity.what))
            take_all(formula->text.name, formula->text.place);
    for (const ConstraintEntry& entry : c.constraints) take_all(entry.constraint.quantity, entry.place);
    for (const Reference& value : recorded) take(value.name, value.place);
    return found;
}

void take_values(Case& c, const WingEntry& wing, Diagnostics& errors) {
    const auto parse = [&](const std::string& value) {
        if (is_slot(parse_wing_value(value)) && !wing.behind)
            throw InvalidInput(text(value, ": of which wing? Write planform.", wing.name,
                                    ": {behind: NAME} with that of the wing ahead"));
    };
    const Named found = named_values(c, wing.name, wing.place, wing.values, parse, errors);
    if (found.values.empty()) return;
    BuiltInEntry made;
    made.outputs = found.values;
    made.make = [wing, values = found.values](const std::string& name, const QuantityContext& ground) {
        return wing_values(name, ground.start, ground.wing(wing.name), values,
                           {wing.box_chord, wing.box_span, wing.behind ? ground.wing(wing.behind->name) : nullptr});
    };
    c.quantities.push_back({wing.name, found.place, std::move(made)});
}

void take_values(Case& c, const FuselageEntry& body, Diagnostics& errors) {
    const Named found = named_values(c, body.name, body.place, body.values, parse_fuselage_value, errors);
    if (found.values.empty()) return;
    BuiltInEntry made;
    made.outputs = found.values;
    made.make = [values = found.values](const std::string& name, const QuantityContext& ground) {
        return fuselage_values(name, ground.start, ground.body(name), values);
    };
    c.quantities.push_back({body.name, found.place, std::move(made)});
}

bool is_body_value(const Case& c, const std::string& name) {
    return std::any_of(c.bodies.begin(), c.bodies.end(),
                       [&](const FuselageEntry& body) { return name.starts_with(body.name + "."); });
}

void check_behind(const Case& c, const WingEntry& wing, Diagnostics& errors) {
    std::vector<std::string> others;
    for (const WingEntry& other : c.planform)
        if (other.name != wing.name) others.push_back(other.name);
    if (!wing.behind || std::ranges::find(others, wing.behind->name) != others.end()) return;
    const std::string near = nearest(wing.behind->name, others);
    errors.add(wing.behind->place,
               text("planform.", wing.name, ".behind = '", printable(wing.behind->name),
                    "' must be another wing under planform", near.empty() ? "" : text("; did you mean '", near, "'?")));
}

}  // namespace

bool is_wing_value(const Case& the_case, const std::string& name) {
    return is_body_value(the_case, name) ||
           std::any_of(the_case.planform.begin(), the_case.planform.end(),
                       [&](const WingEntry& wing) { return name.starts_with(wing.name + "."); });
}

std::optional<bool> is_wing_angle(const Case& the_case, const std::string& name) {
    // Only a wing's values have '@': of a wing that is not declared.
    if (!is_wing_value(the_case, name))
        return name.find('@') == std::string::npos ? std::optional(false) : std::nullopt;
    if (is_body_value(the_case, name)) return false;
    const std::string value = name.substr(name.find('.') + 1);
    for (const WingWord& known : wing_words())
        if (value == known.word + "_grid") return known.is_angle;
    try {
        return is_angle(parse_wing_value(value));
    } catch (const InvalidInput&) {
        return {};
    }
}

void set_planform_values(Case& the_case, Diagnostics& errors) {
    const std::vector<QuantityEntry> declared = the_case.quantities;
    const auto is_free = [&](const std::string& name, const Place& place) {
        const bool is_taken =
            std::any_of(declared.begin(), declared.end(), [&](const auto& q) { return q.name == name; });
        if (is_taken) errors.add(place, text("planform.", name, " has the name of a quantity; rename one of them"));
        return !is_taken;
    };
    for (const WingEntry& wing : the_case.planform) {
        if (!is_free(wing.name, wing.place)) continue;
        check_behind(the_case, wing, errors);
        expand_grid(the_case, wing);
        take_values(the_case, wing, errors);
    }
    for (const FuselageEntry& body : the_case.bodies)
        if (is_free(body.name, body.place)) take_values(the_case, body, errors);
}

}  // namespace strake
