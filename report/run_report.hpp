#pragma once
#include "core/patches/hierarchy.hpp"

#include <filesystem>
#include <map>
#include <optional>

/// report.html: a run as one page that needs nothing else, made of what its folder holds.
namespace strake {

/// What a constraint allows; relative: as multiples of the value at the start.
struct ReportLimit {
    std::string words;
    std::optional<double> min, max;
    bool is_relative = false;
};

/// What the folder alone does not tell.
struct ReportSubject {
    std::string title, units;                                ///< name of the case; unit of length, may be empty
    std::vector<std::pair<std::string, std::string>> asked;  ///< what was asked: heading and words
    bool maximize = false;
    std::map<std::string, ReportLimit> limits;  ///< of constrained values, by name
    /// The surface at the start and its patches; empty: from the folder's series, where there is one.
    TriMesh surface;
    PatchHierarchy tree;
    bool is_over = false;            ///< asked at the end of the run, by itself
    std::vector<std::string> notes;  ///< what is missing on the page, and why
};

/// True where the program was built with the page; else `report_page_missing()` says what was missing then.
bool has_report_page();
std::string report_page_missing();

/// The folder holds shapes of its own: the series of its accepted designs with their patches.
bool has_shapes(const std::filesystem::path& folder);

/// The whole page. A run that goes on, was killed or has failed is as welcome as one that ended well.
/// @throws InputError: the folder holds no run, or its journal cannot be read; OutputError: built without the page.
std::string report_html(const std::filesystem::path& folder, const ReportSubject& subject);

}  // namespace strake
