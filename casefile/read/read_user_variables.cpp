#include "casefile/read/case_reader.hpp"

namespace strake {
namespace {

const char* const kinds[] = {"load", "translate", "rotate", "twist"};

/// The one of load, translate, rotate, twist that the entry has; null, with an error, if there is not exactly one.
const Value* only_kind(const Value& map, const std::string& shown, std::string& kind, Diagnostics& errors) {
    std::vector<std::string> has;
    for (const char* word : kinds)
        for (const Entry& entry : map.entries)
            if (entry.key == word) has.push_back(word);
    if (has.size() != 1) {
        errors.add(map.place, text(shown, " must have exactly one of load, translate, rotate, twist; it has ",
                                   has.empty() ? "none" : joined(has)));
        return nullptr;
    }
    kind = has[0];
    return map.find(kind);
}

void refuse(const Value& map, const std::string& shown, const char* key, const char* with, Diagnostics& errors) {
    for (const Entry& entry : map.entries)
        if (entry.key == key) errors.add(entry.key_place, text(shown, ".", key, " is only allowed with ", with));
}

/// Keys that do not go together.
void check_keys(const Value& map, const std::string& shown, const UserVariableEntry& given, Diagnostics& errors) {
    const bool twists = given.kind == UserVariableEntry::Kind::twist,
               turns = given.kind == UserVariableEntry::Kind::rotate;
    if (!twists) refuse(map, shown, "stations", "twist", errors);
    if (!twists && !turns) {
        refuse(map, shown, "about", "rotate or twist", errors);
        refuse(map, shown, "max_angle", "rotate or twist", errors);
    }
    if (twists) refuse(map, shown, "max_displacement", "load, translate or rotate; a twist has max_angle", errors);
    if (turns && given.max_angle && given.max_displacement)
        errors.add(map.place, text(shown, " must have only one of max_displacement, max_angle"));
    if (twists && !map.find("about")) errors.add(map.place, text(shown, ".about is missing: a point on the axis"));
    if (!twists && !map.find("region")) errors.add(map.place, text(shown, ".region is missing"));
}

/// A number of stations, or their places along the axis.
void read_stations(const Value& value, const std::string& shown, UserVariableEntry& given, Diagnostics& errors) {
    if (value.form == Value::Form::scalar) given.num_stations = static_cast<int>(value.number);
    std::vector<double>& at = given.stations;
    for (std::size_t k = 0; k < value.entries.size(); ++k) {
        const Value& one = value.entries[k].value;
        if (one.accepted) at.push_back(one.number);
        if (k > 0 && at.size() == k + 1 && !(at[k] > at[k - 1]))
            errors.add(one.place, text(shown, ".stations[", k, "] = ", at[k], " must be > ", at[k - 1]));
    }
}

}  // namespace

void CaseReader::read_user_variables(const Value& map, const std::string& shown) {
    UserVariableEntry given;
    given.place = map.place;
    std::string kind;
    const Value* what = only_kind(map, shown, kind, errors_);
    const Value* name = map.find("name");
    if (!what || !name) return;
    given.name = name->text;
    given.kind = kind == "translate"                 ? UserVariableEntry::Kind::translate
                 : kind == "rotate"                  ? UserVariableEntry::Kind::rotate
                 : kind == "twist"                   ? UserVariableEntry::Kind::twist
                 : what->form == Value::Form::scalar ? UserVariableEntry::Kind::normal_load
                                                     : UserVariableEntry::Kind::load;
    if (what->form == Value::Form::list) {
        const auto direction = direction_of(what, shown + "." + kind, errors_);
        if (!direction) return;
        given.direction = *direction;
    }
    if (const Value* region = map.find("region")) given.region = Reference{region->text, region->place};
    given.about = vector_of(map.find("about"));
    if (const Value* v = map.find("max_displacement")) given.max_displacement = length_of(*v);
    if (const Value* v = map.find("max_angle")) given.max_angle = v->number;
    if (const Value* v = map.find("stations")) read_stations(*v, shown, given, errors_);
    check_keys(map, shown, given, errors_);
    case_.parameters.user_variables.push_back(std::move(given));
}

}  // namespace strake
