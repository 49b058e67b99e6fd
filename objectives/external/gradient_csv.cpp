#include "core/error.hpp"
#include "core/text/csv_columns.hpp"
#include "core/text/file.hpp"
#include "objectives/external/gradient_rows.hpp"
#include "objectives/external/handed_over.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace strake {
namespace {

using Fields = std::vector<std::string_view>;

constexpr int none = -1;

/// Columns of a row; without a header, their number decides.
struct Columns {
    std::size_t count = 0;
    int id = none;
    std::array<int, 3> place{none, none, none}, gradient{none, none, none};
    int normal = none;
};

class CsvGradient {
public:
    CsvGradient(const std::string& field, GradientRows& rows) : field_(field), rows_(rows) {}

    void read(std::string_view bytes) {
        for (long line = 1; !bytes.empty(); ++line) {
            const std::size_t end = bytes.find('\n');
            rows_.next_row(line);
            take(bytes.substr(0, end));
            bytes = end == std::string_view::npos ? std::string_view() : bytes.substr(end + 1);
        }
    }

private:
    void take(std::string_view line) {
        const std::size_t first = line.find_first_not_of(" \t\r");
        if (first == std::string_view::npos || line[first] == '#') return;
        split_csv(line, fields_);
        const Fields& fields = fields_;
        double unused = 0;
        if (!header_seen_ && !columns_ && parse_number(fields.front(), unused) == NumberIs::not_a_number) {
            header_seen_ = true;
            columns_ = named(fields);
            is_named_ = columns_.has_value();
            return;
        }
        if (!columns_) columns_ = counted(fields);
        if (fields.size() != columns_->count) refuse_columns(fields.size());
        put(fields);
    }

    /// Columns by the names of a header; empty if it names none of ours.
    std::optional<Columns> named(const Fields& header) {
        const auto column = [&](const std::string& name) { return column_named(header, name); };
        Columns c;
        c.count = header.size();
        const std::string stem = field_.empty() ? "sensitivity" : column_name(field_);
        const char* axes[] = {"x", "y", "z"};
        for (int k = 0; k < 3; ++k) {
            c.gradient[k] = column(stem + "_" + axes[k]);
            c.place[k] = column(axes[k]);
        }
        c.normal = column(field_.empty() ? "surface_sensitivity" : stem);
        const int found =
            static_cast<int>(std::count_if(c.gradient.begin(), c.gradient.end(), [](int k) { return k >= 0; }));
        if (found == 0 && c.normal == none) {
            if (!field_.empty())
                rows_.refuse("missing_key", text("no columns '", printable(field_), "_x', '_y', '_z' in the header"));
            return {};
        }
        if (found == 1 || found == 2)
            rows_.refuse("missing_key", text("the header has ", found, " of the columns ", stem, "_x, _y, _z"));
        c.id = column_of_number(header);
        const auto places = std::count(c.place.begin(), c.place.end(), none);
        if (places != 0) c.place = {none, none, none};
        if (places != 0 && c.id == none) rows_.refuse("missing_key", "the header has neither x, y and z nor PointID");
        if (found == 3) c.normal = none;
        if (c.normal != none && rows_.places().normals.rows() == 0)
            rows_.refuse("missing_key", text("the header has no ", stem, "_x, _y, _z"));
        return c;
    }

    Columns counted(const Fields& fields) {
        Columns c;
        c.count = fields.size();
        if (c.count == 4) {
            c.id = 0;
            c.gradient = {1, 2, 3};
        } else {
            c.place = {0, 1, 2};
            c.gradient = {3, 4, 5};
        }
        if (c.count != 4 && c.count != 6) refuse_columns(c.count);
        return c;
    }

    [[noreturn]] void refuse_columns(std::size_t have) {
        const std::size_t want = columns_ ? columns_->count : 0;
        rows_.refuse("unreadable", text(have, " columns, expected ",
                                        want == 4 && !is_named_   ? "4 as before: index,dJ/dx,dJ/dy,dJ/dz"
                                        : want == 6 && !is_named_ ? "6 as before: x,y,z,dJ/dx,dJ/dy,dJ/dz"
                                        : want > 0                ? text(want, " as in the header")
                                                   : "index,dJ/dx,dJ/dy,dJ/dz or x,y,z,dJ/dx,dJ/dy,dJ/dz"));
    }

    double number(const Fields& fields, int column) const {
        double value = 0;
        const std::string_view field = fields[static_cast<std::size_t>(column)];
        const NumberIs is = parse_number(field, value);
        if (is == NumberIs::finite) return value;
        rows_.refuse(is == NumberIs::not_finite ? "not_finite" : "unreadable",
                     text("column ", column + 1, ": '", printable(field, 60),
                          is == NumberIs::not_finite ? "' is not finite" : "' is not a number"));
    }

    /// By the place's own number if there are such, else by coordinates, else counted from 0.
    int place_of(const Fields& fields) {
        const bool has_place = columns_->place[0] != none;
        if (!has_place || (columns_->id != none && !rows_.places().ids.empty())) {
            const int place = rows_.with_id(number(fields, columns_->id));
            if (has_place) check_place(place, fields);
            return place;
        }
        return rows_.near(coordinates(fields));
    }

    Eigen::RowVector3d coordinates(const Fields& fields) const {
        return {number(fields, columns_->place[0]), number(fields, columns_->place[1]),
                number(fields, columns_->place[2])};
    }

    void check_place(int place, const Fields& fields) const {
        const double off = (rows_.places().at.row(place) - coordinates(fields)).norm();
        if (!(off <= rows_.places().tolerance))
            rows_.refuse("wrong_count", text(rows_.places().one, " ", number(fields, columns_->id), " is ", off,
                                             " from where it was handed over, limit 1e-5 of the diagonal = ",
                                             rows_.places().tolerance));
    }

    void put(const Fields& fields) {
        const int place = place_of(fields);
        if (columns_->normal != none) {
            rows_.put(place, -number(fields, columns_->normal) * rows_.places().normals.row(place));
            return;
        }
        rows_.put(place, {number(fields, columns_->gradient[0]), number(fields, columns_->gradient[1]),
                          number(fields, columns_->gradient[2])});
    }

    const std::string& field_;
    GradientRows& rows_;
    Fields fields_;  // of the line
    std::optional<Columns> columns_;
    bool header_seen_ = false, is_named_ = false;
};

}  // namespace

void read_gradient_csv(std::string_view bytes, const std::string& field, GradientRows& rows) {
    CsvGradient(field, rows).read(bytes);
}

}  // namespace strake
