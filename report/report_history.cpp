#include "core/error.hpp"
#include "core/text/file.hpp"
#include "report/json_number.hpp"
#include "report/report_parts.hpp"

#include <charconv>
#include <cmath>

/// The report's evaluations, levels and values.
namespace strake::page {
namespace {

/// x is only displayed: four digits are enough.
Json rounded(const Eigen::VectorXd& x) {
    Json row = Json::array();
    for (const double value : x) row.push_back(json_number(std::round(value * 1e4) / 1e4));
    return row;
}

Json numbers(const std::vector<double>& values) {
    Json row = Json::array();
    for (const double value : values) row.push_back(json_number(value));
    return row;
}

std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields(1);
    for (const char c : line)
        if (c == ',')
            fields.emplace_back();
        else
            fields.back() += c;
    return fields;
}

bool read_number(const std::string& word, double& value) {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size();
}

constexpr std::size_t max_x = 400000;  ///< numbers; beyond this only accepted designs have x on the page

std::string variables_file(int level) { return "levels/variables_" + std::to_string(level) + ".csv"; }

Json level_variables(const RunFiles& run, int level) {
    const VariableTable table = read_variables(run.folder / variables_file(level));
    return {{"names", table.names},
            {"kinds", table.kinds},
            {"lower", numbers(table.lower)},
            {"upper", numbers(table.upper)},
            {"unit", numbers(table.unit)}};
}

Json absolute(const std::optional<double>& limit, bool is_relative, const Json& start) {
    if (!limit || (is_relative && !start.is_number())) return nullptr;
    return json_number(is_relative ? *limit * start.get<double>() : *limit);
}

/// Summary of a level from its evaluations in the journal.
Json level_from_journal(const RunFiles& run, int level) {
    int count = 0;
    double first = std::numeric_limits<double>::quiet_NaN(), best = first;
    for (const JournalEvaluation& e : run.journal->evaluations()) {
        if (e.level != level) continue;
        ++count;
        if (e.status == "ok" && !std::isfinite(first)) first = e.objective;
        if (e.status == "ok" && (e.accepted || !std::isfinite(best))) best = e.objective;
    }
    return {{"level", level},
            {"evaluations", count},
            {"objective_start", json_number(first)},
            {"objective_end", json_number(best)},
            {"stop", ""}};
}

}  // namespace

VariableTable read_variables(const std::filesystem::path& file) {
    std::error_code ignored;
    VariableTable table;
    if (!std::filesystem::is_regular_file(file, ignored)) return table;
    std::istringstream lines(read_bytes(file));
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line)) {
        const std::vector<std::string> f = fields_of(line);
        double x = 0, lower = 0, upper = 0, unit = 0;
        if (f.size() != 8 || !read_number(f[3], x) || !read_number(f[4], lower) || !read_number(f[5], upper) ||
            !read_number(f[6], unit))
            return {};
        table.names.push_back(clean_lines(f[0]));
        table.kinds.push_back(clean_lines(f[1]));
        table.x.push_back(x);
        table.lower.push_back(lower);
        table.upper.push_back(upper);
        table.unit.push_back(unit);
    }
    return table;
}

Json history_json(const RunFiles& run) {
    Json h;
    std::size_t count = 0;
    for (const JournalEvaluation& e : run.journal->evaluations()) count += static_cast<std::size_t>(e.x.size());
    for (const char* column : {"evaluation", "level", "status", "objective", "violation", "accepted", "seconds",
                               "elapsed", "moved", "taken_over", "values", "parameters", "x"})
        h[column] = Json::array();
    for (const JournalEvaluation& e : run.journal->evaluations()) {
        h["evaluation"].push_back(e.number);
        h["level"].push_back(e.level);
        h["status"].push_back(e.status);
        h["objective"].push_back(json_number(e.objective));
        h["violation"].push_back(json_number(e.max_violation));
        h["accepted"].push_back(e.accepted ? 1 : 0);
        h["seconds"].push_back(json_number(std::round(1e3 * e.seconds) / 1e3));
        h["elapsed"].push_back(json_number(std::round(1e3 * e.elapsed) / 1e3));
        h["moved"].push_back(json_number(e.max_displacement));
        h["taken_over"].push_back(e.is_taken_over ? 1 : 0);
        h["values"].push_back(numbers(e.values));
        h["parameters"].push_back(numbers(e.parameters));
        h["x"].push_back(count <= max_x || e.accepted ? rounded(e.x) : Json());
    }
    h["cached"] = run.journal->cached();
    return h;
}

Json levels_json(const RunFiles& run) {
    Json levels = Json::array();
    if (run.end.contains("levels") && run.end["levels"].is_array())
        for (const Json& level : run.end["levels"])
            if (level.is_object() && level.contains("level") && level["level"].is_number_integer())
                levels.push_back(level);
    // For an unfinished level, or a run that did not end, the journal has the numbers.
    int last = 0;
    for (const Json& level : levels) last = std::max(last, level["level"].get<int>());
    for (const JournalEvaluation& e : run.journal->evaluations()) {
        if (e.level <= last) continue;
        last = e.level;
        levels.push_back(level_from_journal(run, e.level));
    }
    for (Json& level : levels) level["shape_variables"] = level_variables(run, level["level"].get<int>());
    return levels;
}

Json values_json(const RunFiles& run, const ReportSubject& subject) {
    const JournalEvaluation *first = nullptr, *best = nullptr;
    for (const JournalEvaluation& e : run.journal->evaluations()) {
        if (!e.accepted) continue;
        if (!first) first = &e;
        best = &e;
    }
    const auto at = [](const JournalEvaluation* e, std::size_t i, bool is_parameter) {
        if (!e) return Json(nullptr);
        const std::vector<double>& from = is_parameter ? e->parameters : e->values;
        return Json(i < from.size() ? json_number(from[i]) : nullptr);
    };
    Json out = {{"values", Json::array()}, {"parameters", Json::array()}};
    const JournalFacts& facts = run.journal->facts();
    for (std::size_t i = 0; i < facts.values.size(); ++i) {
        Json value = {{"name", facts.values[i]}, {"start", at(first, i, false)}, {"best", at(best, i, false)}};
        const auto found = subject.limits.find(facts.values[i]);
        const ReportLimit limit = found == subject.limits.end() ? ReportLimit{} : found->second;
        value["limit"] = limit.words;
        value["min"] = absolute(limit.min, limit.is_relative, value["start"]);
        value["max"] = absolute(limit.max, limit.is_relative, value["start"]);
        out["values"].push_back(value);
    }
    for (std::size_t i = 0; i < facts.parameters.size(); ++i) {
        Json parameter = {{"name", facts.parameters[i]}, {"start", at(first, i, true)}, {"best", at(best, i, true)}};
        const Json variables = run.end.value("variables", Json::object());
        if (variables.is_object() && variables.contains(facts.parameters[i]) &&
            variables[facts.parameters[i]].is_object())
            parameter["unit"] = variables[facts.parameters[i]].value("unit", Json(nullptr));
        out["parameters"].push_back(parameter);
    }
    return out;
}

}  // namespace strake::page
