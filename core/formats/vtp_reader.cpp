#include "core/formats/vtp_reader.hpp"

#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/vtk_document.hpp"
#include "core/text/file.hpp"

#include <cmath>
#include <utility>

namespace strake {
namespace {

using vtk::Array;
using vtk::decoded;
using vtk::Document;
using vtk::find;

/// Corner lists of <Polys> or <Strips>.
std::vector<std::vector<int>> cells(const Document& document, const std::string& section, int num_points,
                                    const XmlScanner& in) {
    const Array *corners = find(document, section, "connectivity"), *ends = find(document, section, "offsets");
    if (!corners || !ends) return {};
    const std::vector<double> corner = decoded(*corners, document, in), end = decoded(*ends, document, in);
    std::vector<std::vector<int>> out;
    double begin = 0;
    for (std::size_t c = 0; c < end.size(); ++c) {
        if (!(end[c] >= begin) || end[c] > static_cast<double>(corner.size()) || end[c] != std::floor(end[c]))
            in.fail(text(section, " ", c, " ends at corner ", end[c], ", limits ", begin, " and ", corner.size()));
        std::vector<int>& cell = out.emplace_back();
        for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end[c]); ++k) {
            if (!(corner[k] >= 0) || corner[k] >= num_points || corner[k] != std::floor(corner[k]))
                in.fail(text(section, " ", c, " has point ", corner[k], ", limits 0 and ", num_points - 1));
            cell.push_back(static_cast<int>(corner[k]));
        }
        begin = end[c];
    }
    return out;
}

void add_points(const Document& document, const XmlScanner& in, formats::SurfaceBuilder& builder) {
    const Array* points = find(document, "Points", "");
    if (!points || points->components != 3) in.fail("no <Points> of three coordinates");
    builder.coordinates = decoded(*points, document, in);
    if (builder.coordinates.size() / 3 > static_cast<std::size_t>(std::numeric_limits<int>::max() / 3))
        in.fail(text(builder.coordinates.size() / 3, " points, at most 715827882 are possible"));
    for (std::size_t i = 0; i < builder.coordinates.size(); ++i)
        if (!std::isfinite(builder.coordinates[i]))
            in.fail(text("point ", i / 3, " is not finite (", builder.coordinates[i], ")"));
}

/// The field "part_names"; empty: parts are named by their numbers.
std::vector<std::string> part_names(const Document& document, const XmlScanner& in) {
    std::vector<std::string> names;
    const Array* bytes = find(document, "FieldData", "part_names");
    if (!bytes || bytes->type != "String" || !bytes->is_text) return names;
    std::string name;
    for (const double byte : decoded(*bytes, document, in)) {
        if (byte == 0) names.push_back(std::exchange(name, {}));
        if (!(byte > 0 && byte < 256)) continue;
        name += static_cast<char>(static_cast<unsigned char>(byte));
    }
    return names;
}

/// Parts of the polygons by name: whole numbers in the cell field "part", if the file has only polygons.
std::vector<std::string> parts_of(const Document& document, const XmlScanner& in, std::size_t num_polygons) {
    const Array* field = find(document, "CellData", "part");
    if (!field || field->components != 1 || field->type.find("Int") == std::string::npos) return {};
    const std::vector<double> number = decoded(*field, document, in);
    if (number.size() != num_polygons) return {};
    const std::vector<std::string> names = part_names(document, in);
    std::vector<std::string> parts;
    for (const double part : number)
        parts.push_back(part >= 0 && part < static_cast<double>(names.size()) ? names[static_cast<std::size_t>(part)]
                                                                              : text(part));
    return parts;
}

void add_cells(const Document& document, const XmlScanner& in, formats::SurfaceBuilder& builder) {
    const std::vector<std::vector<int>> polygons = cells(document, "Polys", builder.num_vertices(), in);
    const std::vector<std::string> parts = parts_of(document, in, polygons.size());
    for (std::size_t p = 0; p < polygons.size(); ++p)
        if (polygons[p].size() >= 3)
            builder.add_polygon(polygons[p], parts.empty() ? -1 : builder.group_number(parts[p]));
    for (const std::vector<int>& strip : cells(document, "Strips", builder.num_vertices(), in))
        for (std::size_t k = 2; k < strip.size(); ++k)  // every other triangle of a strip is reversed
            builder.corners.insert(builder.corners.end(),
                                   {strip[k - 2], strip[k % 2 == 0 ? k - 1 : k], strip[k % 2 == 0 ? k : k - 1]});
}

}  // namespace

VtpFile parse_vtp(std::string_view bytes, const std::string& name) {
    XmlScanner in(bytes, name);
    const Document document = vtk::scan(in, "PolyData");
    formats::SurfaceBuilder builder;
    add_points(document, in, builder);
    const auto count = static_cast<std::size_t>(builder.num_vertices());
    VtpFile file;
    for (const Array& array : document.arrays) {
        if (array.section != "PointData" || !vtk::is_numeric(array.type)) continue;
        const std::vector<double> numbers = decoded(array, document, in);
        if (numbers.size() != count * array.components)
            in.fail(text("point field '", printable(array.name, 60), "' has ", numbers.size() / array.components,
                         " rows for ", count, " points"));
        VtpField& field = file.point_fields.emplace_back();
        field.name = array.name;
        field.values.resize(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(array.components));
        std::copy(numbers.begin(), numbers.end(), field.values.data());
    }
    add_cells(document, in, builder);
    if (!builder.corners.empty()) {
        file.surface = builder.finish(name, SurfaceFormat::vtp);
        return file;
    }
    file.surface.format = SurfaceFormat::vtp;
    file.surface.file_vertices = builder.num_vertices();
    file.surface.mesh.vertices = Eigen::Map<const Points>(builder.coordinates.data(), builder.num_vertices(), 3);
    return file;
}

SurfaceFile formats::read_vtp(std::string_view bytes, const std::string& name) {
    SurfaceFile surface = parse_vtp(bytes, name).surface;
    if (surface.mesh.num_triangles() == 0)
        throw InputError(text(name, ": holds no triangles (", surface.file_vertices, " vertices)"));
    return surface;
}

}  // namespace strake
