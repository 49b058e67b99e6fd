#include "optimize/history.hpp"

#include "core/error.hpp"

#include <cerrno>
#include <charconv>
#include <cstring>

namespace strake {
namespace {

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
    for (const double value : record.own) row.append(1, ',').append(number(value));
    return row;
}

HistoryWriter::HistoryWriter(const std::filesystem::path& file, const std::vector<std::string>& names,
                             const std::vector<std::string>& own)
    : file_(file), out_(file, std::ios::binary | std::ios::trunc), num_values_(names.size()) {
    std::string header = "evaluation,level,status,objective";
    for (const std::string& name : names) header += "," + name;
    header += ",max_violation,accepted";
    for (const std::string& name : own) header += "," + name;
    write(header);
}

void HistoryWriter::add(const EvaluationRecord& record) { write(history_row(record, num_values_)); }

void HistoryWriter::write(const std::string& line) {
    errno = 0;
    out_ << line << '\n' << std::flush;
    if (!out_) throw OutputError(text(file_.string(), ": cannot write: ", std::strerror(errno ? errno : EIO)));
}

}  // namespace strake
