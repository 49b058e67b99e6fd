#pragma once
#include "core/planform/wing.hpp"

#include <nlohmann/json.hpp>

/// What `info --planform` and the page of a run show of a wing.
namespace strake {

struct WingSheet {
    WingFacts facts;
    std::vector<StationFacts> stations;
    std::vector<PanelFacts> panels;   ///< between root, stations and tip
    std::vector<StationFacts> curve;  ///< at 21 places, for charts; those without a section are left out
};

/// Of the wing on any surface of its triangles. @throws InvalidInput where a station has no section.
WingSheet wing_sheet(const Wing& wing, const TriMesh& surface);

/// Adds span, area, aspect_ratio, taper, mean_chord, sweep, dihedral, stations and panels. Lengths in the surface's
/// unit, angles in radians.
void add_json(const WingSheet& sheet, nlohmann::ordered_json& wing);
nlohmann::ordered_json station_json(const StationFacts& at);

}  // namespace strake
