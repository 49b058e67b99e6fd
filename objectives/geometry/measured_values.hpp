#pragma once
#include "core/error.hpp"
#include "core/planform/varying.hpp"
#include "objectives/quantity/finite.hpp"

/// The values of a part that is measured by sections, as a quantity. Internal to objectives/geometry.
namespace strake {

/// Values `name.value` for each of `values`, with exact derivatives by the vertices. `parse(value)` says what is
/// wanted; `measure(surface, sensitivities)` gives what turns that into a Varying, and keeps what several values share.
/// @throws InvalidInput where one cannot be measured at the start, naming it.
template <class Parse, class Measure>
Quantity measured_values(const std::string& name, const TriMesh& start, const std::vector<std::string>& values,
                         const Parse& parse, const Measure& measure) {
    std::vector<decltype(parse(name))> wanted;
    std::vector<std::string> names;
    for (const std::string& value : values) {
        wanted.push_back(parse(value));
        names.push_back(name + "." + value);
        try {
            measure(start, false)(wanted.back());
        } catch (const InvalidInput& error) {
            throw InvalidInput(text(names.back(), ": ", error.what()));
        }
    }
    return checked_quantity(name, names, start, [wanted, measure](const QuantityRequest& request) {
        QuantityResult result;
        auto plain = measure(request.surface, false), varying = measure(request.surface, true);
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const Varying value = request.wants(i) ? varying(wanted[i]) : plain(wanted[i]);
            result.values.push_back(value.value);
            if (!request.want_sensitivities) continue;
            Points& gradient = result.dJ_dv.emplace_back(0, 3);
            if (!request.wants(i)) continue;
            gradient = Points::Zero(request.surface.num_vertices(), 3);
            for (const auto& [coordinate, d] : value.slope) gradient(coordinate / 3, coordinate % 3) = d;
        }
        return result;
    });
}

}  // namespace strake
