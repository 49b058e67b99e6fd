#include "objectives/external/gradient.hpp"

#include "core/error.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/log.hpp"
#include "objectives/external/refused.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

namespace strake {
namespace {

/// Vertices sorted by the cell of a grid of twice the tolerance: whatever is near is in one of 27 cells.
class NearestVertex {
public:
    NearestVertex(const Points& vertices, double tolerance) : vertices_(vertices), tolerance_(tolerance) {
        cells_.reserve(vertices.rows());
        for (int k = 0; k < static_cast<int>(vertices.rows()); ++k) cells_.push_back({cell_of(vertices.row(k)), k});
        std::sort(cells_.begin(), cells_.end());
    }
    /// -1 when there is none within the tolerance; the smaller number where two are equally near.
    int find(const Eigen::RowVector3d& x) const {
        const Cell centre = cell_of(x);
        int best = -1;
        double distance = tolerance_;
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                for (int k = -1; k <= 1; ++k) {
                    const Cell cell{centre[0] + i, centre[1] + j, centre[2] + k};
                    for (auto at = std::lower_bound(cells_.begin(), cells_.end(), Entry{cell, -1});
                         at != cells_.end() && at->first == cell; ++at) {
                        const double d = (vertices_.row(at->second) - x).norm();
                        if (d < distance || (d == distance && (best < 0 || at->second < best))) {
                            best = at->second;
                            distance = d;
                        }
                    }
                }
        return best;
    }

private:
    using Cell = std::array<std::int64_t, 3>;
    using Entry = std::pair<Cell, int>;
    Cell cell_of(const Eigen::RowVector3d& x) const {
        Cell cell{};
        for (int c = 0; c < 3; ++c)  // clamped: coordinates of a foreign file may be anything
            cell[c] = static_cast<std::int64_t>(std::clamp(std::floor(x[c] / (2 * tolerance_)), -4e18, 4e18));
        return cell;
    }
    const Points& vertices_;
    double tolerance_;
    std::vector<Entry> cells_;
};

/// Rows of the file one by one, each with its place for messages.
class GradientParser {
public:
    GradientParser(const std::string& name, const TriMesh& surface, double tolerance)
        : name_(printable(name)),
          surface_(surface),
          tolerance_(tolerance),
          dJ_dv_(Points::Zero(surface.num_vertices(), 3)),
          line_of_(surface.num_vertices(), 0) {}

    Points parse(std::string_view bytes) {
        while (!bytes.empty()) {
            const std::size_t end = bytes.find('\n');
            ++line_;
            take(bytes.substr(0, end));
            bytes = end == std::string_view::npos ? std::string_view() : bytes.substr(end + 1);
        }
        if (rows_ != surface_.num_vertices())
            throw Refused{{"wrong_count", text(name_, ": ", rows_, " rows, the surface has ", surface_.num_vertices(),
                                               " vertices; want one row each", first_without())}};
        return dJ_dv_;
    }

private:
    [[noreturn]] void refuse(const char* kind, const std::string& what) const {
        throw Refused{{kind, text(name_, ":", line_, ": ", what)}};
    }

    std::string first_without() const {
        const auto missing = std::find(line_of_.begin(), line_of_.end(), 0);
        return missing == line_of_.end() ? "" : text("; first without: ", missing - line_of_.begin());
    }

    void take(std::string_view line) {
        const std::size_t first = line.find_first_not_of(" \t\r");
        if (first == std::string_view::npos || line[first] == '#') return;
        std::array<std::string_view, 7> fields;
        std::size_t count = 0;
        for (std::size_t begin = 0; begin <= line.size() && count < fields.size();) {
            const std::size_t comma = std::min(line.find(',', begin), line.size());
            fields[count++] = line.substr(begin, comma - begin);
            begin = comma + 1;
        }
        double unused = 0;
        if (!header_seen_ && rows_ == 0 && parse_number(fields.front(), unused) == NumberIs::not_a_number) {
            header_seen_ = true;
            return;
        }
        if (columns_ == 0) columns_ = count;
        if ((count != 4 && count != 6) || count != columns_)
            refuse("unreadable", text(count > 6 ? "more than 6" : text(count), " columns, expected ",
                                      columns_ == 4   ? "4 as before: index,dJ/dx,dJ/dy,dJ/dz"
                                      : columns_ == 6 ? "6 as before: x,y,z,dJ/dx,dJ/dy,dJ/dz"
                                                      : "index,dJ/dx,dJ/dy,dJ/dz or x,y,z,dJ/dx,dJ/dy,dJ/dz"));
        std::array<double, 6> numbers{};
        for (std::size_t k = 0; k < count; ++k) numbers[k] = number(fields[k], k);
        put(count == 4 ? by_index(numbers[0]) : by_place(numbers),
            {numbers[columns_ - 3], numbers[columns_ - 2], numbers[columns_ - 1]});
    }

    double number(std::string_view field, std::size_t column) const {
        double value = 0;
        const NumberIs is = parse_number(field, value);
        if (is == NumberIs::finite) return value;
        refuse(is == NumberIs::not_finite ? "not_finite" : "unreadable",
               text("column ", column + 1, ": '", printable(field),
                    is == NumberIs::not_finite ? "' is not finite" : "' is not a number"));
    }

    int by_index(double index) const {
        const int n = surface_.num_vertices();
        if (index != std::floor(index)) refuse("unreadable", text("vertex index ", index, " is not a whole number"));
        if (index < 0 || index >= n) refuse("wrong_count", text("vertex index ", index, " must be in 0..", n - 1));
        return static_cast<int>(index);
    }

    int by_place(const std::array<double, 6>& row) {
        if (!nearest_) nearest_ = std::make_unique<NearestVertex>(surface_.vertices, tolerance_);
        const int v = nearest_->find({row[0], row[1], row[2]});
        if (v < 0)
            refuse("wrong_count", text("no vertex within 1e-5 of the diagonal = ", tolerance_, " of (", row[0], ", ",
                                       row[1], ", ", row[2], ")"));
        return v;
    }

    void put(int v, const Eigen::RowVector3d& row) {
        if (line_of_[v] > 0)
            refuse("wrong_count", text("vertex ", v, " for the second time, first in line ", line_of_[v],
                                       "; want each vertex exactly once"));
        line_of_[v] = line_;
        dJ_dv_.row(v) = row;
        ++rows_;
    }

    std::string name_;
    const TriMesh& surface_;
    double tolerance_;
    Points dJ_dv_;
    std::vector<int> line_of_;  ///< line that gave each vertex, 0: none yet
    std::unique_ptr<NearestVertex> nearest_;
    std::size_t columns_ = 0;
    int line_ = 0, rows_ = 0;
    bool header_seen_ = false;
};

}  // namespace

Points parse_gradient(const std::string& bytes, const std::string& name, const TriMesh& surface, double tolerance) {
    return GradientParser(name, surface, tolerance).parse(bytes);
}

}  // namespace strake
