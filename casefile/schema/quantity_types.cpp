#include "casefile/schema/quantity_types.hpp"

#include "core/error.hpp"

#include <algorithm>

namespace strake {

const std::vector<QuantityType>& quantity_types() {
    static const std::vector<QuantityType> table{
        {"volume", "Enclosed volume.", ""},
        {"area", "Surface area.", ""},
        {"target_shape", "Distance from another surface, for fits.", ""},
        {"measured_points", "Distance from measured points, for fits.", ""},
        {"thickness", "Thickness of the body along given lines.", "1, 2, ...; with values: smallest only one"},
        {"section_area", "Area that a plane cuts out of the body.", ""},
        {"newtonian", "Forces and moments of a hypersonic flow, by modified Newtonian pressures.",
         "drag, lift, side, lift_to_drag, roll, pitch, yaw; a half model at no sideslip has no side, roll and yaw"},
        {"wave_drag", "Zero-lift wave drag of a slender body in supersonic flow, from the areas of its sections.", ""},
        {"friction", "Flat-plate friction drag on the wetted area.", ""},
        {"projected_area", "Area of the silhouette along the stream: frontal or plan area.", ""},
        {"mass_properties", "Centroid, inertia tensor and principal axes of the enclosed solid.",
         "centroid_x/y/z, ixx, iyy, izz, ixy, iyz, izx, principal_1/2/3, axis_1_x ... axis_3_z"},
        {"extent", "Length along a direction, and the smallest and largest coordinate.", "length, min, max"},
        {"section_areas", "Areas of evenly spaced sections along a direction.", "1, 2, ... up to stations"},
        {"wall_thickness", "Thickness along inward rays: a smooth lower bound, and the minimum.", "smooth, smallest"},
        {"bending_energy", "Bending energy of the surface.", ""},
        {"fairness", "Bending relative to the start: keeps its bumps and prevents new ones.", ""},
        {"creases", "Mean square change of the dihedral angles at the creases of the start.", ""},
        {"clearance", "Minimum distance to another closed surface, to stay outside or inside of it.", ""},
        {"planarity", "Mean square distance of a region from its best plane.", ""},
        {"symmetry_error", "Mean square distance of the surface from its mirror image.", ""},
        {"edge_radius", "Radius of a leading edge or nose.", ""},
        {"displacement", "Mean square distance from the start shape.", ""},
    };
    return table;
}

std::vector<std::string> quantity_type_words() {
    std::vector<std::string> words;
    for (const QuantityType& type : quantity_types()) words.push_back(type.word);
    return words;
}

std::string quantity_hint(const std::string& goal) {
    const std::vector<std::string> types = quantity_type_words();
    if (std::find(types.begin(), types.end(), goal) != types.end())
        return text("'", goal, "' is a type: declare it, for example quantities: {", goal, ": {type: ", goal,
                    ", ...}} (strake explain ", goal, ")");
    std::string word;
    for (const char c : goal) word += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    const auto holds = [&](const char* part) { return word.find(part) != std::string::npos; };
    const std::vector<std::string> coefficients{"cd", "cl", "cm", "cdi", "cx", "cy", "cz", "l/d"};
    const bool is_force = holds("drag") || holds("lift") || holds("moment") || holds("pressure") || holds("force") ||
                          std::find(coefficients.begin(), coefficients.end(), word) != coefficients.end();
    if (!is_force) return "";
    return "forces of a flow are declared under quantities: type: newtonian (hypersonic), wave_drag (supersonic) or "
           "friction, or a program of your own with command: [...] (docs/external.md)";
}

}  // namespace strake
