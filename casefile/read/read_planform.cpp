#include "casefile/read/case_reader.hpp"
#include "casefile/schema/scalars.hpp"

#include <algorithm>
#include <numbers>

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

std::vector<double> CaseReader::read_sections(const Value* list, const std::string& shown) {
    if (!list || list->form != Value::Form::list) return {};
    std::vector<double> stations = fractions_of(list);
    for (std::size_t i = 0; i < stations.size(); ++i)
        if (!(stations[i] >= 0 && stations[i] <= 1) || (i > 0 && stations[i] <= stations[i - 1]))
            errors_.add(list->place, text(shown, ".stations[", i, "] = ", stations[i],
                                          " must be in [0, 1] and above the one before"));
    return stations;
}

void CaseReader::read_body(const Entry& entry) {
    const Value& map = entry.value;
    const std::string shown = "planform." + printable(entry.key);
    FuselageEntry body;
    body.name = entry.key;
    body.place = entry.key_place;
    if (const Value* on = map.find("on")) body.on = Reference{on->text, on->place};
    if (const auto length = span_of(map.find("length"), shown + ".length", errors_)) body.length = *length;
    body.stations = read_sections(map.find("stations"), shown);
    body.values = references(map.find("values"));
    case_.bodies.push_back(std::move(body));
}

void CaseReader::read_wing(const Entry& entry) {
    const Value& map = entry.value;
    const std::string shown = "planform." + printable(entry.key);
    const Value *span = map.find("span"), *length = map.find("length");
    if (!span == !length)
        return errors_.add(entry.key_place,
                           text(shown, span ? " has span and length; a wing has a span, a body a length"
                                            : ".span is missing; a body has length in its place"));
    if (length) return read_body(entry);
    WingEntry wing;
    wing.name = entry.key;
    wing.place = entry.key_place;
    if (const Value* on = map.find("on")) wing.on = Reference{on->text, on->place};
    if (const auto span = span_of(map.find("span"), shown + ".span", errors_)) wing.span = *span;
    wing.stations = read_sections(map.find("stations"), shown);
    if (const Value* behind = map.find("behind")) wing.behind = Reference{behind->text, behind->place};
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
    if (const Value* keep = map.find("keep")) wing.keeps_outline = keep->text != "none";
    case_.planform.push_back(std::move(wing));
}

/// "wing.twist: {by: station, range: [-4deg, 4deg]}", "wing.twist@0.37: ...".
void CaseReader::read_planform_range(const Entry& entry) {
    const std::string shown = "parameters.planform." + printable(entry.key);
    PlanformRangeEntry found;
    found.place = entry.key_place;
    std::string word = entry.key;
    if (const std::size_t at = word.find('@'); at != std::string::npos) {
        Value station;
        station.text = word.substr(at + 1);
        const std::string error = convert_scalar(station, Type::fraction, Key{}, {});
        if (!error.empty()) return errors_.add(entry.key_place, text(shown, ": the station ", error));
        found.range.only = {station.number};
        found.range.by_station = true;
        word.resize(at);
    }
    const std::size_t dot = word.rfind('.');
    const auto& words = planform_changes();
    const std::string change = dot == std::string::npos ? "" : word.substr(dot + 1);
    const auto known = std::find(words.begin(), words.end(), change);
    if (known == words.end())
        return errors_.add(entry.key_place,
                           text(shown,
                                " must be a wing or a body and what of it changes, for example wing.twist; "
                                "changes: ",
                                joined(words)));
    found.wing = word.substr(0, dot);
    found.range.change = static_cast<PlanformChange>(known - words.begin());
    const Value& map = entry.value;
    if (const Value* by = map.find("by")) {
        if (by->text == "station" && !found.range.only.empty())
            errors_.add(by->place, text(shown, " is of one station already; remove by"));
        found.range.by_station = found.range.by_station || by->text == "station";
    }
    if (const Value* root = map.find("root")) found.range.root_held = root->text == "held";
    if (const Value* thickness = map.find("thickness")) {
        if (found.range.change != PlanformChange::chord && thickness->text == "kept")
            errors_.add(thickness->place, shown + ".thickness belongs to chord");
        found.range.keeps_thickness = thickness->text == "kept";
    }
    read_change_range(map.find("range"), shown, found.range);
    case_.parameters.planform.push_back(std::move(found));  // also after an error: that nothing moves is another one
}

/// Two changes with their units: deg or rad, or %. False, with an error, where they are not.
bool CaseReader::read_change_range(const Value* list, const std::string& shown, PlanformRange& range) {
    if (!list || list->entries.size() != 2) return false;  // said by the schema
    std::array<double, 2> ends{};
    for (std::size_t k = 0; k < 2; ++k) {
        Value end = list->entries[k].value;
        end.quoted = false;  // a resolved case writes text with quotes
        const bool angle = is_angle(range.change);
        std::string error = convert_scalar(end, angle ? Type::angle : Type::fraction, Key{}, {});
        if (error.empty() && !angle && end.number != 0 && !end.text.ends_with('%'))
            error = text("= ", printable(end.text), " needs a unit: a percentage, for example 5%");
        if (!error.empty()) {
            errors_.add(end.place, text(shown, ".range[", k, "] ", error));
            return false;
        }
        ends[k] = end.number;
    }
    const double unit = is_angle(range.change) ? 180 / std::numbers::pi : 100;
    const char* sign = is_angle(range.change) ? " deg" : " %";
    range.lower = ends[0], range.upper = ends[1];
    if (ends[0] < ends[1] && ends[0] <= 0 && ends[1] >= 0) return true;
    errors_.add(list->place, text(shown, ".range = [", unit * ends[0], sign, ", ", unit * ends[1], sign,
                                  "] must ascend and contain 0, which is the start"));
    return false;
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
