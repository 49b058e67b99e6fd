#include "casefile/read/case_reader.hpp"
#include "casefile/schema/scalars.hpp"

namespace strake {
namespace {

std::vector<double> fractions_of(const Value* list) {
    std::vector<double> all;
    for (const Entry& entry : list ? list->entries : std::vector<Entry>())
        if (entry.value.accepted) all.push_back(entry.value.number);
    return all;
}

/// "y" is "+y".
std::optional<Eigen::Vector3d> span_of(const Value* value, const std::string& shown, Diagnostics& errors) {
    if (!value || value->form != Value::Form::scalar) return direction_of(value, shown, errors);
    Eigen::Vector3d unit = Eigen::Vector3d::Zero();
    unit[value->text.back() - 'x'] = value->text[0] == '-' ? -1 : 1;
    return unit;
}

/// "25% chord", "25%", "0.25".
std::optional<double> axis_of(std::string written) {
    const std::string word = "chord";
    if (written.ends_with(word)) written.resize(written.size() - word.size());
    while (!written.empty() && written.back() == ' ') written.pop_back();
    Value value;
    value.text = written;
    const bool is_legal = convert_scalar(value, Type::fraction, Key{}, {}).empty();
    return is_legal && value.number >= 0 && value.number <= 1 ? std::optional(value.number) : std::nullopt;
}

}  // namespace

/// Two ascending fractions in [0, 1]. False, with an error, where they are not.
bool CaseReader::read_range(const Value* list, const std::string& shown, std::array<double, 2>& range) {
    const std::vector<double> ends = fractions_of(list);
    if (!list || ends.size() != 2) return !list;
    range = {ends[0], ends[1]};
    if (range[0] >= 0 && range[0] < range[1] && range[1] <= 1) return true;
    errors_.add(list->place,
                text(shown, " = [", 100 * range[0], "%, ", 100 * range[1], "%] must ascend and lie in [0%, 100%]"));
    return false;
}

void CaseReader::read_wing(const Entry& entry) {
    const Value& map = entry.value;
    const std::string shown = "planform." + printable(entry.key);
    WingEntry wing;
    wing.name = entry.key;
    wing.place = entry.key_place;
    if (const Value* on = map.find("on")) wing.on = Reference{on->text, on->place};
    if (const auto span = span_of(map.find("span"), shown + ".span", errors_)) wing.span = *span;
    if (const Value* list = map.find("stations"); list && list->form == Value::Form::list) {
        wing.stations = fractions_of(list);
        for (std::size_t i = 0; i < wing.stations.size(); ++i)
            if (!(wing.stations[i] >= 0 && wing.stations[i] <= 1) ||
                (i > 0 && wing.stations[i] <= wing.stations[i - 1]))
                errors_.add(list->place, text(shown, ".stations[", i, "] = ", wing.stations[i],
                                              " must be in [0, 1] and above the one before"));
    }
    if (const Value* axis = map.find("axis")) {
        const auto fraction = axis_of(axis->text);
        if (fraction)
            wing.axis = *fraction;
        else
            errors_.add(axis->place, text(shown, ".axis = ", printable(axis->text),
                                          " must be a fraction of the chord, for example 25% chord"));
    }
    if (const Value* grid = map.find("grid")) {
        wing.grid_span = fractions_of(grid->find("span"));
        wing.grid_chord = fractions_of(grid->find("chord"));
    }
    if (const Value* box = map.find("box")) {
        read_range(box->find("chord"), shown + ".box.chord", wing.box_chord);
        read_range(box->find("span"), shown + ".box.span", wing.box_span);
    }
    wing.values = references(map.find("values"));
    case_.planform.push_back(std::move(wing));
}

/// Regions of a wing. False: the value was refused.
bool CaseReader::read_wing_region(const Value& map, const Value& of, Region& region) {
    const std::string shown = "regions." + printable(region.name);
    WingRegion part;
    part.of = {of.text, of.place};
    const bool has_ranges = read_range(map.find("chord"), shown + ".chord", part.chord) &&
                            read_range(map.find("span"), shown + ".span", part.span);
    if (const Value* side = map.find("side")) {
        if (side->text == "above" || side->text == "below") {
            errors_.add(side->place, text(shown, ".side of a wing must be upper, lower or both"));
            return false;
        }
        part.side = side->text == "upper" ? 1 : side->text == "lower" ? -1 : 0;
    }
    if (const Value* edge = map.find("edge")) {
        part.edge = edge->text == "leading" ? WingRegion::Edge::leading : WingRegion::Edge::trailing;
        if (map.find("chord")) {
            errors_.add(edge->place, text(shown, " has chord and edge; use one of them"));
            return false;
        }
    }
    region.shape = part;
    return has_ranges;
}

}  // namespace strake
