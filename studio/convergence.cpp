#include "studio/convergence.hpp"

#include "studio/file_places.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

namespace strake {

namespace fs = std::filesystem;

namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// Calls `line(words)` for each whole line.
template <class Line>
void for_lines(std::string_view bytes, const Line& line) {
    for (std::size_t end; (end = bytes.find('\n')) != std::string_view::npos; bytes.remove_prefix(end + 1)) {
        std::string_view words = bytes.substr(0, end);
        if (!words.empty() && words.back() == '\r') words.remove_suffix(1);
        line(words);
    }
}

std::string_view trimmed(std::string_view words, std::string_view of = " \t\"#") {
    const std::size_t from = words.find_first_not_of(of), to = words.find_last_not_of(of);
    return from == std::string_view::npos ? std::string_view{} : words.substr(from, to - from + 1);
}

/// Between commas where the line has any, else between blanks.
std::vector<std::string_view> cells_of(std::string_view line) {
    const bool has_commas = line.find(',') != std::string_view::npos;
    const std::string_view between = has_commas ? "," : " \t";
    std::vector<std::string_view> cells;
    line = has_commas ? line : trimmed(line, " \t#");
    while (!line.empty()) {
        const std::size_t end = std::min(line.find_first_of(between), line.size());
        if (has_commas || end > 0) cells.push_back(trimmed(line.substr(0, end)));
        line.remove_prefix(std::min(end + 1, line.size()));
    }
    return cells;
}

std::optional<double> number_in(std::string_view cell) {
    if (!cell.empty() && cell.front() == '+') cell.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
    return std::isfinite(value) ? value : missing;
}

using Cells = std::vector<std::string_view>;

/// With the names of the last line before the first row, if there are as many.
ConvergenceTable empty_table(const Cells& names, std::size_t num_columns) {
    ConvergenceTable table{{}, std::vector<std::vector<double>>(num_columns)};
    for (std::size_t k = 0; k < num_columns; ++k)
        table.names.push_back(names.size() == num_columns ? std::string(names[k])
                              : k == 0                    ? "iteration"
                                                          : "column " + std::to_string(k + 1));
    return table;
}

void drop_columns_without_numbers(ConvergenceTable& table) {
    for (std::size_t k = table.columns.size(); k-- > 1;) {
        const auto& column = table.columns[k];
        if (std::any_of(column.begin(), column.end(), [](double v) { return std::isfinite(v); })) continue;
        table.columns.erase(table.columns.begin() + static_cast<std::ptrdiff_t>(k));
        table.names.erase(table.names.begin() + static_cast<std::ptrdiff_t>(k));
    }
}

ConvergenceTable read_table(std::string_view bytes) {
    ConvergenceTable table;
    Cells names;
    for_lines(bytes, [&](std::string_view line) {
        const Cells cells = cells_of(line);
        if (cells.empty()) return;
        if (line.find('#') != std::string_view::npos || !number_in(cells[0])) {
            names = cells;
            return;
        }
        if (table.columns.empty()) table = empty_table(names, cells.size());
        for (std::size_t k = 0; k < table.columns.size(); ++k)
            table.columns[k].push_back(k < cells.size() ? number_in(cells[k]).value_or(missing) : missing);
    });
    drop_columns_without_numbers(table);
    return table;
}

constexpr std::string_view solving = "Solving for ", residual = "Initial residual = ";

ConvergenceTable read_openfoam_log(std::string_view bytes) {
    ConvergenceTable table{{"Time"}, {{}}};
    for_lines(bytes, [&](std::string_view line) {
        auto& times = table.columns[0];
        if (line.starts_with("Time = ")) {
            const auto time = number_in(trimmed(line.substr(7), " \ts"));
            if (!time) return;
            times.push_back(*time);
            for (std::size_t k = 1; k < table.columns.size(); ++k) table.columns[k].push_back(missing);
            return;
        }
        const std::size_t at = line.find(solving), value = line.find(residual);
        if (at == std::string_view::npos || value == std::string_view::npos || times.empty()) return;
        const std::string_view field = line.substr(at + solving.size());
        const std::string name(field.substr(0, field.find(',')));
        const std::string_view rest = line.substr(value + residual.size());
        const auto found = std::find(table.names.begin() + 1, table.names.end(), name);
        const auto column = static_cast<std::size_t>(found - table.names.begin());
        if (found == table.names.end()) {
            table.names.push_back(name);
            table.columns.emplace_back(times.size(), missing);
        }
        double& last = table.columns[column].back();
        if (std::isnan(last)) last = number_in(rest.substr(0, rest.find(','))).value_or(missing);
    });
    return table;
}

void thin(ConvergenceTable& table, std::size_t max_rows) {
    const std::size_t count = table.columns.empty() ? 0 : table.columns[0].size();
    if (count <= max_rows) return;
    for (auto& column : table.columns) {
        std::vector<double> kept(max_rows);
        for (std::size_t k = 0; k < max_rows; ++k) kept[k] = column[k * (count - 1) / (max_rows - 1)];
        column = std::move(kept);
    }
}

/// 12 of "000012" and "000012-2"; 0: no folder of an evaluation.
int evaluation_of(const std::string& name) {
    int number = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
    const bool is_whole = end == name.data() + name.size() || *end == '-';
    return error == std::errc() && is_whole ? number : 0;
}

}  // namespace

ConvergenceTable read_convergence(std::string_view bytes, std::size_t max_rows) {
    const bool is_log = bytes.find(solving) != std::string_view::npos && bytes.find(residual) != std::string_view::npos;
    ConvergenceTable table = is_log ? read_openfoam_log(bytes) : read_table(bytes);
    thin(table, max_rows);
    return table;
}

std::vector<ConvergenceFile> convergence_files(const fs::path& run, const std::map<std::string, fs::path>& file_of,
                                               std::size_t max_count) {
    std::vector<std::pair<int, std::string>> folders;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(run / "evaluations", ignored)) {
        const std::string name = entry.path().filename().string();
        if (const int number = evaluation_of(name); number > 0) folders.emplace_back(number, name);
    }
    std::sort(folders.rbegin(), folders.rend());
    std::vector<ConvergenceFile> files;
    for (const auto& [number, name] : folders)
        for (const auto& [program, file] : file_of)
            for (const fs::path& inner : {fs::path(name) / program / file, fs::path(name) / file}) {
                const fs::path path = run / "evaluations" / inner;
                if (files.size() >= max_count) return files;
                if (!fs::is_regular_file(path, ignored) || !lies_in(path, run)) continue;
                files.push_back({number, inner.generic_string(), program, path});
                break;
            }
    return files;
}

}  // namespace strake
