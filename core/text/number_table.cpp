#include "core/text/number_table.hpp"

#include "core/error.hpp"
#include "core/text/text_scanner.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <utility>

namespace strake {
namespace {

std::string contents(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in || std::filesystem::is_directory(file)) throw InputError(text(file.string(), ": cannot be read"));
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::string joined(const std::vector<std::string>& columns, int required) {
    std::string words;
    for (std::size_t i = 0; i < columns.size(); ++i)
        words += (i == 0 ? "" : ",") + (static_cast<int>(i) < required ? columns[i] : "[" + columns[i] + "]");
    return words;
}

TableRow row_of(TextScanner& scanner, std::string_view first, const std::vector<std::string>& columns, int required) {
    TableRow row;
    row.line = scanner.line();
    for (std::string_view word = first; !word.empty(); word = scanner.word()) {
        if (row.values.size() == columns.size())
            scanner.fail(text("more than ", columns.size(), " numbers; expected ", joined(columns, required)));
        row.values.push_back(scanner.number(word, columns[row.values.size()]));
    }
    if (static_cast<int>(row.values.size()) < required)
        scanner.fail(text(row.values.size(), " numbers; expected ", joined(columns, required)));
    return row;
}

}  // namespace

std::vector<TableRow> read_table(const std::filesystem::path& file, const std::vector<std::string>& columns,
                                 int required) {
    std::string all = contents(file);
    std::replace_if(
        all.begin(), all.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
    TextScanner scanner(all, file.string(), {.comment = '#'});
    std::vector<TableRow> rows;
    bool may_be_header = true;
    while (scanner.next_line()) {
        const std::string_view first = scanner.word();
        if (first.empty()) continue;
        const bool header = std::exchange(may_be_header, false) && std::isalpha(static_cast<unsigned char>(first[0])) &&
                            first != "nan" && first != "inf";
        if (!header) rows.push_back(row_of(scanner, first, columns, required));
    }
    if (rows.empty()) scanner.fail(text("no rows; expected ", joined(columns, required)));
    return rows;
}

}  // namespace strake
