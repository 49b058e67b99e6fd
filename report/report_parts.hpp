#pragma once
#include "optimize/journal/journal.hpp"
#include "report/run_report.hpp"
#include "report/run_status.hpp"

#include <nlohmann/json.hpp>

/// The parts of report.html, each as JSON. Internal.
namespace strake::page {

using Json = nlohmann::ordered_json;

/// A run folder as read for the report.
struct RunFiles {
    std::filesystem::path folder;
    std::unique_ptr<Journal> journal;
    RunStatus status;
    Json end;  ///< run.json, or an empty object
    int num_values() const { return static_cast<int>(journal->facts().values.size()); }
};

/// The contents of levels/variables_K.csv or levels/best.csv.
struct VariableTable {
    std::vector<std::string> names, kinds;
    std::vector<double> x, lower, upper, unit;
};
/// Empty if the file is missing or is not such a table.
VariableTable read_variables(const std::filesystem::path& file);

/// The folder's own name, also for "." and "runs/a/".
std::string folder_name(const std::filesystem::path& folder);

/// A multi-line text from outside as valid UTF-8 without control characters.
std::string clean_lines(const std::string& bytes);

Json history_json(const RunFiles& run);
Json levels_json(const RunFiles& run);
Json values_json(const RunFiles& run, const ReportSubject& subject);
Json failures_json(const RunFiles& run);
Json cost_json(const RunFiles& run);
std::vector<std::string> advice(const RunFiles& run, const ReportSubject& subject);

/// Named compressed arrays for the page.
using Blobs = std::vector<std::pair<std::string, std::string>>;

/// {surface, frames, tree, ...} and the arrays they name; null without shapes.
Json shapes_json(const RunFiles& run, const ReportSubject& subject, Blobs& blobs);

/// [{title, words, image}, ...]: the start, and the best design in the colours of its displacement, as data URLs.
/// @param best its vertices; empty: there is none
Json pictures_json(const TriMesh& start, const Points& best, const ReportSubject& subject);
/// [{name, axis, start, best}, ...]: the sheets of the declared wings; best is null where there is none. A wing that
/// cannot be measured costs a note. @param best vertices; empty: there is no best design
Json wings_json(const ReportSubject& subject, const Points& best, std::vector<std::string>& notes);
/// [{name, start, best}, ...]: likewise of the declared bodies.
Json bodies_json(const ReportSubject& subject, const Points& best, std::vector<std::string>& notes);
/// Of levels/best.design; empty without it. @throws InputError: damaged.
Points best_vertices(const std::filesystem::path& folder);

}  // namespace strake::page
