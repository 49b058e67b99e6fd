#include "report/run_report.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"
#include "report/json_number.hpp"
#include "report/report_page.hpp"
#include "report/report_parts.hpp"

namespace strake {
namespace {

namespace fs = std::filesystem;
using page::Json;

page::RunFiles read_run(const fs::path& folder, bool is_over) {
    page::RunFiles run{folder, nullptr, run_status(folder, is_over), Json::object()};
    run.journal = Journal::look(folder / "journal.sqlite");
    std::error_code ignored;
    // While a run is in progress, run.json describes an earlier end.
    if (!run.status.holder && fs::is_regular_file(folder / "run.json", ignored)) {
        Json end = Json::parse(read_bytes(folder / "run.json"), nullptr, false);
        if (end.is_object()) run.end = std::move(end);
    }
    return run;
}

Json end_json(const page::RunFiles& run) {
    double start = std::numeric_limits<double>::quiet_NaN();
    for (const JournalEvaluation& e : run.journal->evaluations())
        if (e.accepted) {
            start = e.objective;
            break;
        }
    const RunStatus& s = run.status;
    return {{"status", s.status},
            {"reason", page::clean_lines(s.reason)},
            {"level", s.level},
            {"evaluations", s.evaluations},
            {"max_evaluations", s.max_evaluations},
            {"best_evaluation", s.best_evaluation},
            {"objective_start", json_number(start)},
            {"objective", json_number(s.objective)},
            {"max_violation", json_number(s.max_violation)},
            {"seconds", json_number(s.seconds)}};
}

Json pairs(const std::vector<std::pair<std::string, std::string>>& rows) {
    Json out = Json::array();
    for (const auto& [heading, words] : rows) out.push_back({heading, page::clean_lines(words)});
    return out;
}

}  // namespace

std::string page::folder_name(const fs::path& folder) {
    const fs::path whole = fs::absolute(folder).lexically_normal();
    return printable((whole.has_filename() ? whole : whole.parent_path()).filename().string());
}

std::string report_html(const fs::path& folder, const ReportSubject& subject) {
    if (!has_report_page()) throw OutputError(report_page_missing());
    const page::RunFiles run = read_run(folder, subject.is_over);
    Json data = {
        {"format", 1}, {"title", subject.title}, {"folder", page::folder_name(folder)}, {"units", subject.units}};
    data["is_fit"] = run.journal->facts().is_fit;
    data["maximize"] = subject.maximize;
    data["asked"] = pairs(subject.asked);
    data["yaml"] = page::clean_lines(run.journal->facts().case_yaml);
    data["end"] = end_json(run);
    data["next"] = page::advice(run, subject);
    data["quantities"] = page::values_json(run, subject);
    data["history"] = page::history_json(run);
    data["levels"] = page::levels_json(run);
    data["samples"] = run.end.value("samples", Json());
    data["failures"] = page::failures_json(run);
    data["cost"] = page::cost_json(run);
    std::vector<std::string> notes = subject.notes;
    page::Blobs blobs;
    try {
        data["shapes"] = page::shapes_json(run, subject, blobs);
    } catch (const InputError& error) {
        // A damaged series costs the page its shapes, nothing else.
        blobs.clear();
        data["shapes"] = nullptr;
        notes.push_back(text("The shapes are not shown: ", printable(error.what())));
    }
    const bool has_sheets = !subject.wings.empty() || !subject.bodies.empty();
    const Points best = has_sheets ? page::best_vertices(folder) : Points();
    data["wings"] = page::wings_json(subject, best, notes);
    data["bodies"] = page::bodies_json(subject, best, notes);
    data["notes"] = notes;
    return page::html(subject.title, data, blobs);
}

}  // namespace strake
