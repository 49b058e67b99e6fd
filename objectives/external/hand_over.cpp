#include "objectives/external/hand_over.hpp"

#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/io.hpp"

namespace strake {
namespace {

/// SU2 reads with C++ streams: point, coordinates, separated by blanks; no header.
std::string su2_rows(const Points& at, const std::vector<std::int64_t>& ids) {
    std::string out;
    for (Eigen::Index i = 0; i < at.rows(); ++i) {
        out += ids.empty() ? std::to_string(i) : std::to_string(ids[static_cast<std::size_t>(i)]);
        out += ' ';
        formats::append_row(out, "", at.data() + 3 * i);
    }
    return out;
}

}  // namespace

void check_hand_over_format(const std::string& format) {
    if (format == "su2-positions") return;
    try {
        format_named(format);
    } catch (const InvalidInput& error) {
        throw InvalidInput(std::string(error.what()) + " su2-positions");
    }
}

std::string handed_over_name(const std::string& format) {
    return format == "su2-positions" ? "surface_positions.dat" : "surface" + extension_of(format_named(format));
}

std::string points_name(const ProgramPoints& points) { return points.as_npy ? "points.npy" : "points.csv"; }

std::string handed_over_bytes(const TriMesh& surface, const std::string& format, const ProgramPoints* points) {
    const std::string name = handed_over_name(format);
    if (format != "su2-positions") return surface_bytes(surface, format_named(format), name);
    if (points) return su2_rows(points->map.moved(surface.vertices), points->rest.ids);
    return su2_rows(surface.vertices, {});
}

}  // namespace strake
