#include "objectives/point_file.hpp"

#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/mesh/formats.hpp"
#include "core/mesh/io.hpp"
#include "core/mesh/npy.hpp"
#include "core/mesh/text_scanner.hpp"

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

enum class ListKind { none, text, npy };

ListKind list_kind(const std::filesystem::path& file) {
    const std::string extension = file.extension().string();
    if (extension == ".npy") return ListKind::npy;
    return extension == ".csv" || extension == ".txt" || extension == ".xyz" ? ListKind::text : ListKind::none;
}

Points read_array(const std::filesystem::path& file) {
    const std::string name = printable(file.native());
    try {
        Points points = parse_npy(read_bytes(file));
        for (Eigen::Index i = 0; i < points.rows(); ++i)
            if (!points.row(i).allFinite())
                throw InputError(text(name, ": row ", i, " = ", points.row(i), " is not finite"));
        return points;
    } catch (const NpyError& error) {
        throw InputError(text(name, ": ", error.what()));
    }
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

bool is_point_list(const std::filesystem::path& file) { return list_kind(file) != ListKind::none; }

Points read_points(const std::filesystem::path& file) {
    if (list_kind(file) == ListKind::npy) return read_array(file);
    if (list_kind(file) == ListKind::none) return read_surface(file).mesh.vertices;
    const std::vector<TableRow> rows = read_table(file, {"x", "y", "z"}, 3);
    Points points(static_cast<Eigen::Index>(rows.size()), 3);
    for (std::size_t i = 0; i < rows.size(); ++i)
        points.row(static_cast<Eigen::Index>(i)) << rows[i].values[0], rows[i].values[1], rows[i].values[2];
    return points;
}

void write_points(const std::filesystem::path& file, const Points& points) {
    const ListKind kind = list_kind(file);
    if (kind == ListKind::none)
        throw InvalidInput(text(printable(file.native()), ": points are written as .npy, .csv, .txt or .xyz"));
    if (kind == ListKind::npy) return write_atomically(file, npy_bytes(points));
    std::string out = "x,y,z\n";
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        for (int c = 0; c < 3; ++c) {
            formats::append(out, points(i, c));
            out += c < 2 ? ',' : '\n';
        }
    write_atomically(file, out);
}

}  // namespace strake
