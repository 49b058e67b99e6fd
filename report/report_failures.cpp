#include "core/text/file.hpp"
#include "report/json_number.hpp"
#include "report/report_parts.hpp"

#include <cstdio>
#include <fstream>
#include <map>

/// The report's failed evaluations and the cost of the run.
namespace strake::page {
namespace {

namespace fs = std::filesystem;

constexpr std::streamoff tail_bytes = 4000;
constexpr std::size_t max_failures = 300, max_logs = 60, max_logs_each = 4;

/// The end of a file, beginning at the start of a line.
std::string tail(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    in.seekg(0, std::ios::end);
    const std::streamoff size = in.tellg();
    if (!in || size <= 0) return "";
    const std::streamoff from = std::max<std::streamoff>(0, size - tail_bytes);
    in.seekg(from);
    std::string bytes(static_cast<std::size_t>(size - from), '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, in.gcount())));
    const std::size_t line = bytes.find('\n');
    if (from > 0 && line != std::string::npos && line + 1 < bytes.size()) bytes = "...\n" + bytes.substr(line + 1);
    return clean_lines(bytes);
}

/// Logs in an evaluation folder and its subfolders, by name.
std::vector<fs::path> logs_in(const fs::path& folder, int deeper = 1) {
    std::vector<fs::path> files, below;
    std::error_code why;
    for (fs::directory_iterator at(folder, why), end; !why && at != end; at.increment(why)) {
        std::error_code ignored;
        if (at->is_symlink(ignored)) continue;
        if (at->is_regular_file(ignored) && at->path().extension() == ".log") files.push_back(at->path());
        if (deeper > 0 && at->is_directory(ignored)) below.push_back(at->path());
    }
    std::sort(files.begin(), files.end());
    std::sort(below.begin(), below.end());
    for (const fs::path& next : below)
        for (const fs::path& file : logs_in(next, deeper - 1)) files.push_back(file);
    return files;
}

Json logs_of(const fs::path& run, int evaluation) {
    char name[32];
    std::snprintf(name, sizeof name, "evaluations/%06d", evaluation);
    Json logs = Json::array();
    for (const fs::path& file : logs_in(run / name)) {
        const std::string words = tail(file);
        if (!words.empty()) logs.push_back({{"name", printable(fs::relative(file, run).string())}, {"tail", words}});
        if (logs.size() == max_logs_each) break;
    }
    return logs;
}

}  // namespace

std::string clean_lines(const std::string& bytes) {
    std::string out, line;
    const auto end_line = [&] {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        for (char& c : line)
            if (c == '\t') c = ' ';
        out += printable(line, 2000);
        line.clear();
    };
    for (const char c : bytes) {
        if (c != '\n') {
            line += c;
            continue;
        }
        end_line();
        out += '\n';
    }
    end_line();
    return out;
}

Json failures_json(const RunFiles& run) {
    Json out = {{"count", 0}, {"kinds", Json::object()}, {"rows", Json::array()}};
    std::size_t count = 0;
    std::vector<const JournalEvaluation*> failed;
    for (const JournalEvaluation& e : run.journal->evaluations()) {
        if (e.status == "ok") continue;
        ++count;
        out["kinds"][e.status] = out["kinds"].value(e.status, 0) + 1;
        failed.push_back(&e);
    }
    out["count"] = count;
    // The last ones include those that ended the run.
    const std::size_t begin = failed.size() > max_failures ? failed.size() - max_failures : 0;
    for (std::size_t i = begin; i < failed.size(); ++i) {
        const JournalEvaluation& e = *failed[i];
        out["rows"].push_back(
            {{"evaluation", e.number},
             {"level", e.level},
             {"status", e.status},
             {"reason", clean_lines(e.reason)},
             {"ends_run", e.is_final_failure},
             {"seconds", json_number(e.seconds)},
             {"logs", failed.size() - i <= max_logs ? logs_of(run.folder, e.number) : Json::array()}});
    }
    out["left_out"] = begin;
    return out;
}

Json cost_json(const RunFiles& run) {
    struct Sum {
        int evaluations = 0, failed = 0, taken_over = 0;
        double seconds = 0;
    };
    std::map<int, Sum> levels;
    double elapsed = 0, inside = 0;
    for (const JournalEvaluation& e : run.journal->evaluations()) {
        Sum& sum = levels[e.level];
        ++sum.evaluations;
        sum.failed += e.status != "ok";
        sum.taken_over += e.is_taken_over;
        sum.seconds += e.seconds;
        inside += e.seconds;
        elapsed = e.elapsed;
    }
    Json out = {{"levels", Json::array()}, {"programs", Json::array()}};
    for (const auto& [level, sum] : levels)
        out["levels"].push_back({{"level", level},
                                 {"evaluations", sum.evaluations},
                                 {"failed", sum.failed},
                                 {"taken_over", sum.taken_over},
                                 {"seconds", json_number(sum.seconds)}});
    for (const ProgramCost& cost : run.journal->program_costs())
        out["programs"].push_back({{"name", cost.quantity},
                                   {"calls", cost.calls},
                                   {"failed", cost.failed},
                                   {"cached", cost.cached},
                                   {"seconds", json_number(cost.seconds)}});
    out["elapsed"] = json_number(elapsed);
    out["in_evaluations"] = json_number(inside);
    return out;
}

}  // namespace strake::page
