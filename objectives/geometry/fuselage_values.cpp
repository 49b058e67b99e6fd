#include "objectives/geometry/fuselage_values.hpp"

#include "core/error.hpp"
#include "objectives/geometry/measured_values.hpp"

#include <charconv>
#include <map>

namespace strake {
namespace {

/// All values of one surface; what several of them share is measured once.
class MeasuredFuselage {
public:
    MeasuredFuselage(const Fuselage& body, const TriMesh& surface, bool sensitivities)
        : body_(body), surface_(surface), sensitivities_(sensitivities) {}

    Varying operator()(const FuselageValue& value) {
        if (value.word == "length") return body_.length(surface_, sensitivities_);
        auto known = stations_.find(value.station);
        if (known == stations_.end())
            known = stations_.emplace(value.station, body_.station(surface_, value.station, sensitivities_)).first;
        return value.word == "width"    ? known->second.width
               : value.word == "height" ? known->second.height
                                        : known->second.camber;
    }

private:
    const Fuselage& body_;
    const TriMesh& surface_;
    bool sensitivities_;
    std::map<double, FuselageStation> stations_;
};

}  // namespace

FuselageValue parse_fuselage_value(const std::string& name) {
    const std::size_t at = name.find('@');
    FuselageValue value{name.substr(0, at), 0};
    const bool has_station = at != std::string::npos;
    if (value.word == "length") {
        if (has_station) throw InvalidInput(text("'", name, "': write 'length', a value of the whole body"));
        return value;
    }
    if (value.word != "width" && value.word != "height" && value.word != "camber")
        throw InvalidInput(
            text("a body has no value '", value.word,
                 "'. Values: length, width, height, camber, the last three at a fraction of the length"));
    if (!has_station)
        throw InvalidInput(text("'", name, "': write '", value.word, "@0.5' with a fraction of the length"));
    const char *first = name.data() + at + 1, *last = name.data() + name.size();
    const auto [end, error] = std::from_chars(first, last, value.station);
    if (error != std::errc() || end != last || !(value.station >= 0 && value.station <= 1))
        throw InvalidInput(text("'", name, "': '", name.substr(at + 1), "' must be a fraction in [0, 1]"));
    return value;
}

Quantity fuselage_values(const std::string& name, const TriMesh& start, std::shared_ptr<const Fuselage> body,
                         const std::vector<std::string>& values) {
    return measured_values(name, start, values, parse_fuselage_value, [=](const TriMesh& surface, bool sensitivities) {
        return MeasuredFuselage(*body, surface, sensitivities);
    });
}

}  // namespace strake
