#include "casefile/read/case_reader.hpp"

namespace strake {
namespace {

bool has_unit(const Value& value) { return value.text.ends_with("deg") || value.text.ends_with("rad"); }

}  // namespace

void CaseReader::read_program_parameter(const Entry& entry) {
    const std::string shown = "variables." + printable(entry.key);
    const char* const keys[] = {"start", "min", "max"};
    const Value* given[3];
    const Value* angle = nullptr;
    for (int k = 0; k < 3; ++k) {
        given[k] = entry.value.find(keys[k]);
        if (!given[k]) return;  // reported
        if (has_unit(*given[k])) angle = given[k];
    }
    const auto [start, min, max] = std::tie(given[0], given[1], given[2]);
    for (int k = 0; k < 3; ++k)
        if (angle && !has_unit(*given[k]) && given[k]->number != 0) {
            errors_.add(given[k]->place, text(shown, ".", keys[k], " = ", given[k]->text,
                                              " must be an angle with a "
                                              "unit (deg or rad), like ",
                                              angle->text));
            return;
        }
    if (!(min->number < max->number))
        errors_.add(min->place, text(shown, ".min = ", min->text, " must be < max = ", max->text));
    else if (!(min->number <= start->number && start->number <= max->number))
        errors_.add(start->place,
                    text(shown, ".start = ", start->text, " must be in [", min->text, ", ", max->text, "]"));
    case_.variables.push_back(
        {{entry.key, start->number, min->number, max->number, angle != nullptr}, entry.key_place});
}

}  // namespace strake
