#include "objectives/external/point_list.hpp"

#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/io.hpp"
#include "core/formats/npy.hpp"
#include "core/text/csv_columns.hpp"
#include "core/text/file.hpp"
#include "core/text/number_table.hpp"
#include "objectives/external/handed_over.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

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

constexpr std::size_t max_columns = 100000;

/// Rows under a header that names x, y and z.
class NamedColumns {
public:
    NamedColumns(const std::string& name, std::string_view header_line) : name_(name) {
        const auto header = csv_fields(header_line, max_columns);
        count_ = header.size();
        id_ = column_of_number(header);
        text_.header = header_line;
        for (int c = 0; c < 3; ++c)
            text_.xyz[static_cast<std::size_t>(c)] = column_named(header, std::string(1, "xyz"[c]));
    }
    bool has_all() const { return std::count(text_.xyz.begin(), text_.xyz.end(), -1) == 0; }

    void add(std::string_view line, long number) {
        line_ = number;
        const auto fields = csv_fields(line, max_columns);
        if (fields.size() != count_) fail(text(fields.size(), " columns, ", count_, " in the header"));
        text_.rows.emplace_back(line);
        for (const int column : text_.xyz) coordinates_.push_back(value(fields, column));
        if (id_ < 0) return;
        const double id = value(fields, id_);
        if (id != std::floor(id) || std::abs(id) > 9e15)
            fail(text("the point's number ", id, " is not a whole number"));
        ids_.push_back(static_cast<std::int64_t>(id));
    }

    NumberedPoints finish() const {
        std::vector<std::int64_t> sorted = ids_;
        std::sort(sorted.begin(), sorted.end());
        const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
        if (twice != sorted.end()) throw InputError(text(name_, ": two points have the number ", *twice));
        return {Eigen::Map<const Points>(coordinates_.data(), static_cast<Eigen::Index>(coordinates_.size() / 3), 3),
                ids_, text_};
    }

private:
    [[noreturn]] void fail(const std::string& what) const { throw InputError(text(name_, ":", line_, ": ", what)); }
    double value(const std::vector<std::string_view>& fields, int column) const {
        double number = 0;
        const std::string_view field = fields[static_cast<std::size_t>(column)];
        if (parse_number(field, number) != NumberIs::finite)
            fail(text("column ", column + 1, ": '", printable(field, 60), "' is not a finite number"));
        return number;
    }
    std::string name_;
    std::size_t count_ = 0;
    int id_ = -1;
    NamedText text_;
    std::vector<double> coordinates_;
    std::vector<std::int64_t> ids_;
    long line_ = 0;
};

NumberedPoints read_text(const std::filesystem::path& file) {
    const std::string bytes = read_bytes(file);
    std::string_view rest = bytes;
    const std::size_t first_end = rest.find('\n');
    NamedColumns columns(printable(file.native()), rest.substr(0, first_end));
    if (columns.has_all() && first_end != std::string_view::npos) {
        rest.remove_prefix(first_end + 1);
        for (long line = 2; !rest.empty(); ++line) {
            const std::size_t end = std::min(rest.find('\n'), rest.size());
            const std::string_view row = rest.substr(0, end);
            if (row.find_first_not_of(" \t\r") != std::string_view::npos) columns.add(row, line);
            rest.remove_prefix(std::min(end + 1, rest.size()));
        }
        NumberedPoints points = columns.finish();
        if (points.at.rows() == 0) throw InputError(text(printable(file.native()), ": no rows below the header"));
        return points;
    }
    const std::vector<TableRow> rows = read_table(file, {"x", "y", "z"}, 3);
    NumberedPoints points{Points(static_cast<Eigen::Index>(rows.size()), 3)};
    for (std::size_t i = 0; i < rows.size(); ++i)
        points.at.row(static_cast<Eigen::Index>(i)) << rows[i].values[0], rows[i].values[1], rows[i].values[2];
    return points;
}

/// The original text with other coordinates.
std::string text_with(const NamedText& old, const Points& at) {
    std::string out = old.header + '\n';
    std::vector<std::string_view> fields;
    for (Eigen::Index i = 0; i < at.rows(); ++i) {
        split_csv(old.rows[static_cast<std::size_t>(i)], fields, max_columns);
        for (std::size_t k = 0; k < fields.size(); ++k) {
            if (k > 0) out += ',';
            const auto axis = std::find(old.xyz.begin(), old.xyz.end(), static_cast<int>(k));
            if (axis == old.xyz.end()) {
                out += fields[k];
                continue;
            }
            formats::append(out, at(i, axis - old.xyz.begin()));
            if (fields[k].ends_with('\r')) out += '\r';
        }
        out += '\n';
    }
    return out;
}

}  // namespace

std::vector<std::string> other_columns(const NumberedPoints& points) {
    std::vector<std::string> names;
    if (points.text.rows.empty()) return names;
    const auto header = csv_fields(points.text.header, max_columns);
    const int id = column_of_number(header);
    for (int k = 0; k < static_cast<int>(header.size()); ++k)
        if (k != id && std::count(points.text.xyz.begin(), points.text.xyz.end(), k) == 0)
            names.push_back(std::string(header[static_cast<std::size_t>(k)]));
    return names;
}

bool is_point_list(const std::filesystem::path& file) { return list_kind(file) != ListKind::none; }
bool is_npy(const std::filesystem::path& file) { return list_kind(file) == ListKind::npy; }

NumberedPoints read_points(const std::filesystem::path& file) {
    switch (list_kind(file)) {
        case ListKind::npy:
            return {read_array(file)};
        case ListKind::text:
            return read_text(file);
        case ListKind::none:
            break;
    }
    return {read_surface(file).mesh.vertices};
}

void write_points(const std::filesystem::path& file, const NumberedPoints& points) {
    const ListKind kind = list_kind(file);
    if (kind == ListKind::none)
        throw InvalidInput(text(printable(file.native()), ": points are written as .npy, .csv, .txt or .xyz"));
    if (kind == ListKind::npy) return write_atomically(file, npy_bytes(points.at));
    if (static_cast<Eigen::Index>(points.text.rows.size()) == points.at.rows() && points.at.rows() > 0)
        return write_atomically(file, text_with(points.text, points.at));
    std::string out = points.ids.empty() ? "x,y,z\n" : "PointID,x,y,z\n";
    for (Eigen::Index i = 0; i < points.at.rows(); ++i) {
        if (!points.ids.empty()) out += std::to_string(points.ids[static_cast<std::size_t>(i)]) + ",";
        for (int c = 0; c < 3; ++c) {
            formats::append(out, points.at(i, c));
            out += c < 2 ? ',' : '\n';
        }
    }
    write_atomically(file, out);
}

}  // namespace strake
