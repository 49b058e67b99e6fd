#include "objectives/external/gradient.hpp"

#include "core/error.hpp"
#include "core/formats/npy.hpp"
#include "core/formats/vtp_reader.hpp"
#include "core/text/file.hpp"
#include "objectives/external/gradient_rows.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/refused.hpp"

#include <algorithm>
#include <cmath>

namespace strake {

GradientPlaces vertices_of(const TriMesh& surface, double tolerance) {
    GradientPlaces places;
    places.at = surface.vertices;
    places.tolerance = tolerance;
    return places;
}

GradientRows::GradientRows(const std::string& name, const GradientPlaces& places)
    : name_(printable(name)),
      places_(places),
      rows_of_(Points::Zero(places.at.rows(), 3)),
      row_of_(static_cast<std::size_t>(places.at.rows()), -1) {}

void GradientRows::refuse(const char* kind, const std::string& what) const {
    throw Refused{{kind, text(name_, is_line_ ? ":" : ": row ", row_, ": ", what)}};
}

int GradientRows::with_id(double id) {
    const auto n = static_cast<int>(places_.at.rows());
    if (id != std::floor(id)) refuse("unreadable", text(places_.one, " index ", id, " is not a whole number"));
    if (places_.ids.empty()) {
        if (id < 0 || id >= n) refuse("wrong_count", text(places_.one, " index ", id, " must be in 0..", n - 1));
        return static_cast<int>(id);
    }
    if (by_id_.empty()) {
        for (std::size_t i = 0; i < places_.ids.size(); ++i) by_id_.emplace_back(places_.ids[i], static_cast<int>(i));
        std::sort(by_id_.begin(), by_id_.end());
    }
    const auto wanted = static_cast<std::int64_t>(std::clamp(id, -9e18, 9e18));
    const auto at = std::lower_bound(by_id_.begin(), by_id_.end(), std::pair(wanted, 0));
    if (at == by_id_.end() || at->first != wanted)
        refuse("wrong_count", text("there is no ", places_.one, " with the number ", id));
    return at->second;
}

int GradientRows::near(const Eigen::RowVector3d& x) {
    // Rows in the order of the places need no search, and coinciding places stay distinct.
    const bool is_free = rows_ < places_.at.rows() && row_of_[static_cast<std::size_t>(rows_)] < 0;
    const double in_order = is_free ? (places_.at.row(rows_) - x).norm() : places_.tolerance;
    if (is_free && in_order == 0) return rows_;
    if (!tree_) tree_ = std::make_unique<PointTree>(places_.at);
    const auto [place, distance] = tree_->nearest(x);
    if (is_free && in_order <= std::min(distance, places_.tolerance)) return rows_;
    if (!(distance <= places_.tolerance))
        refuse("wrong_count", text("no ", places_.one, " within 1e-5 of the diagonal = ", places_.tolerance, " of (",
                                   x[0], ", ", x[1], ", ", x[2], ")"));
    return place;
}

void GradientRows::put(int place, const Eigen::RowVector3d& gradient) {
    if (!gradient.allFinite()) refuse("not_finite", text("the gradient ", gradient, " is not finite"));
    if (row_of_[place] >= 0)
        refuse("wrong_count", text(places_.one, " ", place, " appears twice, first in ", is_line_ ? "line " : "row ",
                                   row_of_[place], "; want each ", places_.one, " exactly once"));
    row_of_[place] = row_;
    rows_of_.row(place) = gradient;
    ++rows_;
}

Points GradientRows::finish() const {
    if (rows_ == places_.at.rows()) return rows_of_;
    const auto missing = std::find(row_of_.begin(), row_of_.end(), -1) - row_of_.begin();
    throw Refused{{"wrong_count", text(name_, ": ", rows_, " rows, ", places_.whole, " has ", places_.at.rows(), " ",
                                       places_.many, "; want one row each; first without: ", missing)}};
}

namespace {

Points from_npy(const std::string& bytes, const std::string& name, const GradientPlaces& places) {
    GradientRows rows(name, places);
    Points array;
    try {
        array = parse_npy(bytes);
    } catch (const NpyError& error) {
        throw Refused{{"unreadable", text(printable(name), ": ", error.what())}};
    }
    if (array.rows() != places.at.rows())
        throw Refused{{"wrong_count", text(printable(name), ": ", array.rows(), " rows, ", places.whole, " has ",
                                           places.at.rows(), " ", places.many, "; want one row each, in their order")}};
    for (int i = 0; i < static_cast<int>(array.rows()); ++i) {
        rows.next_row(i);
        rows.put(i, array.row(i));
    }
    return rows.finish();
}

const VtpField& vector_field(const VtpFile& file, const std::string& field, const std::string& name) {
    const VtpField* found = nullptr;
    std::string known;
    int vectors = 0;
    for (const VtpField& f : file.point_fields) {
        known += (known.empty() ? "" : ", ") + printable(f.name, 60);
        if (f.values.cols() != 3) continue;
        ++vectors;
        if (field.empty() || f.name == field) found = &f;
    }
    if (!found || (field.empty() && vectors > 1))
        throw Refused{{"missing_key", text(printable(name), ": ",
                                           field.empty() ? text(vectors,
                                                                " point fields of vectors, must be one (or name "
                                                                "it: {\"file\": …, \"field\": …})")
                                                         : text("no point field '", printable(field), "' of vectors"),
                                           "; it has: ", known.empty() ? "none" : known)}};
    return *found;
}

Points from_vtp(const std::string& bytes, const std::string& name, const GradientPlaces& places,
                const std::string& field) {
    VtpFile file;
    try {
        file = parse_vtp(bytes, printable(name));
    } catch (const InputError& error) {
        throw Refused{{"unreadable", error.what()}};
    }
    const VtpField& gradient = vector_field(file, field, name);
    GradientRows rows(name, places);
    const Points& at = file.surface.mesh.vertices;
    for (int i = 0; i < static_cast<int>(at.rows()); ++i) {
        rows.next_row(i);
        rows.put(rows.near(at.row(i)), gradient.values.row(i));
    }
    return rows.finish();
}

}  // namespace

Points parse_gradient(const std::string& bytes, const std::string& name, const GradientPlaces& places,
                      const std::string& field) {
    if (bytes.starts_with("\x93NUMPY")) return from_npy(bytes, name, places);
    const std::size_t first = bytes.find_first_not_of(" \t\r\n");
    if (first != std::string::npos && bytes[first] == '<') return from_vtp(bytes, name, places, field);
    require_text(bytes, name);
    GradientRows rows(name, places);
    rows.rows_are_lines();
    read_gradient_csv(bytes, field, rows);
    return rows.finish();
}

Points parse_gradient(const std::string& bytes, const std::string& name, const TriMesh& surface, double tolerance) {
    return parse_gradient(bytes, name, vertices_of(surface, tolerance));
}

}  // namespace strake
