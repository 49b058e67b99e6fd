#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "core/patches/hierarchy.hpp"
#include "core/planform/fuselage.hpp"
#include "core/planform/wing.hpp"

#include <filesystem>
#include <map>
#include <memory>
#include <optional>

/// report.html: a run as one self-contained page, made from the run folder.
namespace strake {

/// The limits of a constraint; relative: multiples of the start value.
struct ReportLimit {
    std::string words;
    std::optional<double> min, max;
    bool is_relative = false;
};

/// What the folder alone does not contain.
struct ReportSubject {
    std::string title, units;                                ///< name of the case; unit of length, may be empty
    std::vector<std::pair<std::string, std::string>> asked;  ///< what the case asks for: heading and words
    bool maximize = false;
    std::map<std::string, ReportLimit> limits;  ///< of constrained values, by name
    /// The start surface and its patches; empty: taken from the folder's series, if it has one.
    TriMesh surface;
    PatchHierarchy tree;             ///< on the triangles of the surface
    std::vector<int> wrap_triangle;  ///< with a wrap, per triangle of the surface: the nearest of the wrap
    std::optional<Eigen::Vector3d> downstream = {}, up = {};   ///< the body's axes where the case states them, unit
    std::optional<SymmetryPlane> symmetry = {};                ///< of a half model
    std::vector<std::shared_ptr<const Wing>> wings = {};       ///< that the case declares, of `surface`
    std::vector<std::shared_ptr<const Fuselage>> bodies = {};  ///< likewise
    bool is_over = false;                                      ///< written by the run itself at its end
    std::vector<std::string> notes;                            ///< what is missing on the page, and why
};

/// True if the program was built with the page; otherwise `report_page_missing()` says what was missing.
bool has_report_page();
std::string report_page_missing();

/// True if the folder holds shapes: the series of its accepted designs with their patches.
bool has_shapes(const std::filesystem::path& folder);

/// The whole page, for a run in any state: in progress, killed, failed or ended.
/// @throws InputError: not a run folder, or its journal cannot be read; OutputError: built without the page.
std::string report_html(const std::filesystem::path& folder, const ReportSubject& subject);

}  // namespace strake
