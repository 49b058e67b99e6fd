#pragma once
#include "report/body_sheet.hpp"

#include <optional>
#include <string>

/// The sheet of a body by its length: `strake info --planform --length x`.
namespace strake::cli {

struct BodyMeasures {
    FuselageDeclaration declared;
    bool is_beside_wing = false;  ///< what is not of the wing that is found
    BodySheet now;
    std::optional<BodySheet> start;  ///< of the surface that this one is compared to
};

/// Of the whole surface, or of what is not of a wing on it.
/// @param file name of the surface, for messages
/// @param way of the length, from the nose to the tail: "x", "+x", "-y" and so on; up is z, of a length along z y
/// @param stations fractions of the length; empty: the default ones
/// @param start the same triangles before they were moved; null: none
/// @throws InvalidInput: no such direction, the surface is a wing alone, a station without a section, other triangles
BodyMeasures body_measures(const TriMesh& mesh, const std::string& file, const std::string& way,
                           const std::vector<double>& stations, const TriMesh* start = nullptr);

std::string body_words(const std::string& file, const BodyMeasures& body);
nlohmann::ordered_json body_json(const BodyMeasures& body);  ///< lengths in the file's unit, camber over the length
/// Sections: rows station,outline,across,up for .csv, a picture with charts along the length for .svg.
std::string body_csv(const BodyMeasures& body);
std::string body_svg(const BodyMeasures& body);

}  // namespace strake::cli
