#include "casefile/model/case.hpp"

#include <algorithm>

#include "casefile/model/case_source.hpp"

namespace strake {

std::vector<std::string> known_values(const Case& the_case) {
    std::vector<std::string> known;
    for (const QuantityEntry& quantity : the_case.quantities)
        for (const std::string& name : quantity.value_names()) known.push_back(name);
    for (const char* built_in : {"volume", "area"})
        if (std::find(known.begin(), known.end(), built_in) == known.end()) known.push_back(built_in);
    return known;
}

std::vector<std::string> QuantityEntry::value_names() const {
    std::vector<std::string> names;
    if (const auto* external = std::get_if<ExternalEntry>(&what))
        for (const std::string& value : external->outputs) names.push_back(name + "." + value);
    if (const auto* made = std::get_if<BuiltInEntry>(&what))
        for (const std::string& value : made->outputs) names.push_back(name + "." + value);
    const auto* along = std::get_if<LineThicknessEntry>(&what);
    if (along && along->values == ThicknessValues::each)
        for (std::size_t i = 1; i <= along->lines.size(); ++i) names.push_back(text(name, ".", i));
    if (names.empty()) names.push_back(name);
    return names;
}

std::optional<BodyAxes> body_axes(const Case& the_case) {
    std::optional<BodyAxes> axes = the_case.aero.axes;
    for (const QuantityEntry& quantity : the_case.quantities)
        if (const auto* made = std::get_if<BuiltInEntry>(&quantity.what); made && made->axes && !axes)
            axes = made->axes;
    if (!axes) return {};
    // Old keys state `up` only up to a component along the stream.
    axes->up = (axes->up - axes->up.dot(axes->downstream) * axes->downstream).normalized();
    return axes;
}

Diagnostics diagnostics_of(const Case& the_case) {
    return {the_case.file.string(), the_case.source->lines, the_case.source->settings};
}

}  // namespace strake
