#include "report/run_status.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"
#include "core/text/shell_word.hpp"
#include "report/json_number.hpp"

#include <algorithm>
#include <deque>
#include <nlohmann/json.hpp>

namespace strake {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Status and reason of a run that has ended.
void read_end(const fs::path& file, RunStatus& status) {
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) return;
    const Json end = Json::parse(read_bytes(file), nullptr, false);
    if (!end.is_object() || !end.contains("status") || !end["status"].is_string()) return;
    status.status = end["status"];
    if (end.contains("reason") && end["reason"].is_string()) status.reason = end["reason"];
}

std::vector<std::string> files_in(const fs::path& folder) {
    std::vector<std::string> files;
    std::error_code why;
    for (fs::directory_iterator at(folder, why), end; !why && at != end; at.increment(why))
        if (at->is_regular_file(why)) files.push_back(at->path().string());
    std::sort(files.begin(), files.end());
    return files;
}

/// Run folders inside this one, quoted for the shell.
std::vector<std::string> runs_in(const fs::path& folder) {
    std::vector<std::string> runs;
    std::error_code why, ignored;
    for (fs::directory_iterator at(folder, why), end; !why && at != end; at.increment(why))
        if (fs::exists(at->path() / "journal.sqlite", ignored)) runs.push_back(typed_path(at->path().string()));
    std::sort(runs.begin(), runs.end());
    return runs;
}

}  // namespace

void need_run(const fs::path& folder) {
    std::error_code ignored;
    if (fs::exists(folder / "journal.sqlite", ignored)) return;
    const std::string name = printable(folder.native());
    if (!fs::exists(folder, ignored)) throw InputError(name + ": no such folder");
    if (!fs::is_directory(folder, ignored))
        throw InputError(name + ": is not a folder; give the run folder that `strake run` printed");
    constexpr std::size_t enough = 5;
    const std::vector<std::string> runs = runs_in(folder);
    std::string words;
    for (std::size_t i = 0; i < std::min(enough, runs.size()); ++i) words += (i > 0 ? ", " : "") + runs[i];
    if (runs.size() > enough) words += text(" and ", runs.size() - enough, " more");
    throw InputError(text(name, ": is not a run folder (it has no journal.sqlite)",
                          runs.empty() ? "" : "; run folders below it: " + words));
}

RunStatus run_status(const fs::path& folder, bool is_over) {
    need_run(folder);
    RunStatus status;
    if (!is_over) status.holder = lock_holder(folder);
    const auto journal = Journal::look(folder / "journal.sqlite");
    status.evaluations = static_cast<int>(journal->evaluations().size());
    status.max_evaluations = journal->limits().evaluations;
    status.max_seconds = journal->limits().seconds;
    std::deque<double> ends;
    for (const JournalEvaluation& e : journal->evaluations()) {
        ends.push_back(e.elapsed);
        if (ends.size() > 11) ends.pop_front();
        if (e.status == "ok") status.last_objective = e.objective;
        status.level = e.level;
        status.seconds = e.elapsed;
        if (!e.accepted) continue;
        status.best_evaluation = e.number;
        status.objective = e.objective;
        status.max_violation = e.max_violation;
    }
    if (ends.size() > 3) status.seconds_each = (ends.back() - ends.front()) / static_cast<double>(ends.size() - 1);
    status.files = files_in(folder);
    read_end(folder / "run.json", status);
    if (status.holder) {
        status.status = "running";
        status.reason = text(status.holder->words(), " is at evaluation ", status.evaluations + 1);
    } else if (status.status.empty()) {
        status.status = "killed";
        status.reason = text("the process ended unexpectedly after ", status.evaluations,
                             " evaluations; `strake resume ", typed_path(folder.string()), "` continues it");
    }
    return status;
}

std::string status_json(const RunStatus& s) {
    Json j;
    j["status"] = s.status;
    j["reason"] = s.reason;
    j["level"] = s.level;
    j["evaluations"] = s.evaluations;
    j["objective"] = json_number(s.objective);
    j["best"] = json_number(s.objective);
    j["max_violation"] = json_number(s.max_violation);
    j["files"] = s.files;
    j["best_evaluation"] = s.best_evaluation;
    j["max_evaluations"] = s.max_evaluations;
    j["seconds"] = json_number(s.seconds);
    j["seconds_each"] = json_number(s.seconds_each);
    if (s.holder) j["running"] = {{"process", s.holder->process}, {"host", s.holder->host}};
    return j.dump(2, ' ', false, Json::error_handler_t::replace);
}

EvaluationRecord record_of(const JournalEvaluation& e) {
    EvaluationRecord record;
    record.evaluation = e.number;
    record.level = e.level;
    record.status = e.status;
    record.reason = e.reason;
    record.objective = e.objective;
    record.values = e.values;
    record.parameters = e.parameters;
    record.max_violation = e.max_violation;
    record.accepted = e.accepted;
    record.max_displacement = e.max_displacement;
    record.seconds = e.seconds;
    record.is_taken_over = e.is_taken_over;
    return record;
}

}  // namespace strake
