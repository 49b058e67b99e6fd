#pragma once
#include "core/planform/find_wings.hpp"
#include "report/wing_sheet.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>

/// The sheet of a wing: `strake info --planform`.
namespace strake::cli {

struct PlanformSheet {
    FoundWing found;
    bool is_half = false;  ///< measured on one side
    WingSheet now;
    std::optional<WingSheet> start;  ///< of the surface that this one is compared to
};

/// The wing of the surface, or nothing. @param stations fractions of the semispan; empty: at kinks.
/// @param start the same triangles before they were moved, whose wing and stations count; null: none
/// @throws InvalidInput: other triangles
std::optional<PlanformSheet> planform_sheet(const TriMesh& mesh, const std::vector<double>& stations,
                                            const TriMesh* start = nullptr);

std::string planform_words(const std::string& file, const std::optional<PlanformSheet>& sheet);
/// Lengths in the file's unit, angles in radians; null without a wing.
nlohmann::ordered_json planform_json(const std::optional<PlanformSheet>& sheet);

/// Sections in fractions of their chords: rows station,outline,x,z for .csv, a picture with charts along the span for
/// .svg.
std::string sections_csv(const PlanformSheet& sheet);
std::string sections_svg(const PlanformSheet& sheet);

/// For pictures of sheets: one value over fractions of the semispan or of a length, the start in grey (may be empty),
/// now in blue.
using SheetCurve = std::vector<std::pair<double, double>>;
std::string curve_svg(const std::string& title, const SheetCurve& start, const SheetCurve& now, double left, double top,
                      double width, double height);
/// @throws InvalidInput: other triangles
void check_same_triangles(const TriMesh& start, const TriMesh& mesh);
/// "+x", or the vector.
std::string way_words(const Eigen::Vector3d& d);

}  // namespace strake::cli
