#include "optimize/run/history.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <sstream>

namespace strake {
namespace {

// Names of values stand between the two, those of parameters behind.
constexpr std::array before_values{"evaluation", "level", "status", "objective"};
constexpr std::array after_values{"max_violation", "accepted"};

bool holds(const auto& columns, const std::string& name) {
    return std::find(columns.begin(), columns.end(), name) != columns.end();
}

/// 17 significant digits, independent of the locale; empty for NaN.
std::string number(double value) {
    if (!std::isfinite(value)) return "";
    char buffer[64];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::scientific, 16);
    return {buffer, end.ptr};
}

}  // namespace

std::string history_row(const EvaluationRecord& record, std::size_t num_values) {
    std::string row = std::to_string(record.evaluation) + "," + std::to_string(record.level) + "," + record.status +
                      "," + number(record.objective);
    for (std::size_t i = 0; i < num_values; ++i) {
        row += ",";
        if (i < record.values.size()) row += number(record.values[i]);
    }
    row += ',';
    row += number(record.max_violation);
    row += record.accepted ? ",1" : ",0";
    for (const double value : record.parameters) row.append(1, ',').append(number(value));
    return row;
}

std::string history_header(const std::vector<std::string>& names, const std::vector<std::string>& parameters) {
    std::string header;
    const auto add = [&](const auto& columns) {
        for (const std::string_view name : columns) header.append(header.empty() ? "" : ",").append(name);
    };
    add(before_values);
    add(names);
    add(after_values);
    add(parameters);
    return header;
}

bool is_history_column(const std::string& name) { return holds(before_values, name) || holds(after_values, name); }

HistoryNames history_names(const std::string& header) {
    HistoryNames names;
    std::istringstream row(header);
    bool is_parameter = false;
    for (std::string name; std::getline(row, name, ',');) {
        if (holds(after_values, name)) is_parameter = true;
        if (!is_history_column(name)) (is_parameter ? names.parameters : names.values).push_back(name);
    }
    return names;
}

HistoryWriter::HistoryWriter(const std::filesystem::path& file, const std::vector<std::string>& names,
                             const std::vector<std::string>& parameters, bool continues)
    : file_(file), num_values_(names.size()) {
    std::error_code missing;
    if (continues && std::filesystem::is_regular_file(file, missing)) kept_ = read_bytes(file);
    errno = 0;
    out_.open(file, std::ios::binary | (kept_.empty() ? std::ios::trunc : std::ios::app));
    if (!out_) refuse();
    write(history_header(names, parameters));
}

void HistoryWriter::add(const EvaluationRecord& record) { write(history_row(record, num_values_)); }

void HistoryWriter::write(const std::string& line) {
    const std::string row = line + "\n";
    if (kept_.size() - same_ >= row.size() && kept_.compare(same_, row.size(), row) == 0) {
        same_ += row.size();
        return;
    }
    finish();
    errno = 0;
    out_ << row << std::flush;
    if (!out_) refuse();
}

void HistoryWriter::finish() {
    if (same_ < kept_.size()) {
        std::error_code why;
        std::filesystem::resize_file(file_, same_, why);
        if (why) throw OutputError(text(file_.string(), ": cannot write: ", why.message()));
    }
    kept_.clear();
    same_ = 0;
}

void HistoryWriter::refuse() const {
    throw OutputError(text(file_.string(), ": cannot write: ", std::strerror(errno ? errno : EIO)));
}

}  // namespace strake
