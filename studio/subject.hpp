#pragma once
#include "core/planform/find_wings.hpp"
#include "studio/choice.hpp"

#include <memory>
#include <nlohmann/json.hpp>

/// What the studio shows: a surface, and the case that it belongs to. Made once, then only read.
namespace strake {

struct Subject {
    std::filesystem::path surface, case_file;  ///< the latter empty: a bare surface
    RegionGround ground;
    std::string blocks;                       ///< of the case's text that decide about `ground` (`ground_blocks`)
    std::string payload;                      ///< what the page gets (`payload_of`)
    std::optional<FoundWing> wing;            ///< that the page shows
    std::shared_ptr<const Wing> wing_places;  ///< of the same
};

/// Finishes a subject whose ground is there.
void show(Subject& subject, const Case* the_case);

/// A bare surface with its automatic patches, as it is in its file: defects are shown, not refused.
/// @throws InputError.
std::shared_ptr<const Subject> surface_subject(const std::filesystem::path& file);
/// The surface as the case prepares it. @throws CaseError, InputError, SurfaceRefused.
std::shared_ptr<const Subject> case_subject(const std::filesystem::path& case_file, const std::string& yaml);

/// The blocks of a case's text on which the prepared surface and its patches depend.
std::string ground_blocks(const std::string& yaml);

/// Regions of a case on a surface: [{name, line, fixed, triangles, area, marks (`packed_marks`)} or {name, line, fixed,
/// error, error_line}, …]. Errors by region do not throw.
nlohmann::ordered_json regions_json(const Subject& subject, const Case& the_case);

/// One bit a triangle, least significant first, in base64.
std::string packed_marks(const std::vector<char>& marks);

}  // namespace strake
