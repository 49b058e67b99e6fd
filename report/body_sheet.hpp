#pragma once
#include "core/planform/fuselage.hpp"

#include <nlohmann/json.hpp>

/// What `info --planform` and the page of a run show of a body by its length.
namespace strake {

struct BodySheet {
    struct Section {
        double station;
        FuselageStation at;
    };
    double length;
    std::vector<Section> stations;
    std::vector<Section> curve;  ///< at 21 places, for charts; those without a section are left out
};

/// Of the body on any surface of its triangles. @throws InvalidInput where a station has no section.
BodySheet body_sheet(const Fuselage& body, const TriMesh& surface);

/// Adds length and stations. Lengths in the surface's unit, camber over the length.
void add_json(const BodySheet& sheet, nlohmann::ordered_json& body);
nlohmann::ordered_json section_json(const BodySheet::Section& section);

}  // namespace strake
