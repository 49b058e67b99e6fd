#include "core/mesh/vtp_reader.hpp"

#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/mesh/formats.hpp"
#include "core/mesh/vtp_arrays.hpp"
#include "core/mesh/xml_scanner.hpp"

#include <charconv>
#include <cmath>

namespace strake {
namespace {

using vtk::Array;

/// Everything between the tags, before any array is decoded.
struct Document {
    vtk::Coding coding;
    std::vector<Array> arrays;
    std::vector<std::pair<std::size_t, std::string>> offsets;  ///< of appended arrays: number, offset
    int pieces = 0;
};

std::uint64_t whole(const std::string& word, const XmlScanner& in, const char* what) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
        in.fail(text(what, " '", printable(word, 60), "' is not a whole number"));
    return value;
}

void read_head(const XmlScanner::Tag& tag, const XmlScanner& in, vtk::Coding& coding) {
    if (tag.value("type") != "PolyData")
        in.fail(text("holds '", printable(tag.value("type"), 60), "', must be PolyData (ParaView: Extract Surface)"));
    coding.is_swapped = tag.value("byte_order") == "BigEndian";
    coding.header_bytes = tag.value("header_type", "UInt32") == "UInt64" ? 8 : 4;
    const std::string compressor = tag.value("compressor");
    coding.is_compressed = compressor == "vtkZLibDataCompressor";
    if (!compressor.empty() && !coding.is_compressed)
        in.fail(text("compressed by '", printable(compressor, 60), "', known is vtkZLibDataCompressor"));
}

void add_array(const XmlScanner::Tag& tag, const std::string& section, XmlScanner& in, Document& out) {
    Array array;
    array.section = section;
    array.name = tag.value("Name");
    array.type = tag.value("type");
    array.components = whole(tag.value("NumberOfComponents", "1"), in, "NumberOfComponents");
    if (array.components == 0) array.components = 1;
    const std::string format = tag.value("format", "ascii");
    array.is_text = format == "ascii";
    array.is_base64 = true;
    if (format == "appended")
        out.offsets.emplace_back(out.arrays.size(), tag.value("offset", "0"));
    else if (!tag.is_empty)
        array.inside = in.text_here();
    out.arrays.push_back(std::move(array));
}

/// `in` stands behind <AppendedData>.
void append_data(const XmlScanner::Tag& tag, const XmlScanner& in, Document& out) {
    const std::string_view rest = in.rest();
    const std::size_t mark = rest.find('_');
    if (mark == std::string_view::npos) in.fail("appended data without the '_' that they begin with");
    const std::string_view data = rest.substr(mark + 1);
    for (const auto& [number, word] : out.offsets) {
        const std::uint64_t offset = whole(word, in, "offset");
        if (offset > data.size()) in.fail(text("offset ", offset, " is behind the end of the appended data"));
        out.arrays[number].inside = data.substr(offset);
        out.arrays[number].is_base64 = tag.value("encoding", "base64") == "base64";
    }
    out.offsets.clear();
}

Document scan(XmlScanner& in) {
    Document out;
    std::string section;
    bool is_vtk = false;
    for (XmlScanner::Tag tag = in.next(); !tag.name.empty(); tag = in.next()) {
        if (tag.name == "VTKFile") is_vtk = true, read_head(tag, in, out.coding);
        if (!is_vtk) in.fail("no VTK file: it does not begin with <VTKFile>");
        if (tag.name == "Piece") ++out.pieces;
        if (tag.name == "DataArray") add_array(tag, section, in, out);
        for (const char* name : {"PointData", "CellData", "Points", "Verts", "Lines", "Strips", "Polys", "FieldData"})
            if (tag.name == name) section = name;
        if (tag.name == "AppendedData") {
            append_data(tag, in, out);
            break;  // bytes follow
        }
    }
    if (!is_vtk) in.fail("no VTK file");
    if (!out.offsets.empty()) in.fail("arrays are appended, but there is no <AppendedData>");
    if (out.pieces != 1) in.fail(text(out.pieces, " pieces, must be one"));
    return out;
}

std::vector<double> decoded(const Array& array, const Document& document, const XmlScanner& in) {
    try {
        std::vector<double> numbers = vtk::numbers(array, document.coding);
        if (numbers.size() % array.components != 0)
            throw std::runtime_error(text(numbers.size(), " numbers in rows of ", array.components));
        return numbers;
    } catch (const std::runtime_error& error) {
        in.fail(text(array.section, " array '", printable(array.name, 60), "': ", error.what()));
    }
}

const Array* find(const Document& document, const std::string& section, const std::string& name) {
    for (const Array& array : document.arrays)
        if (array.section == section && (name.empty() || array.name == name)) return &array;
    return nullptr;
}

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

void add_cells(const Document& document, const XmlScanner& in, formats::SurfaceBuilder& builder) {
    for (const std::vector<int>& polygon : cells(document, "Polys", builder.num_vertices(), in))
        if (polygon.size() >= 3) builder.add_polygon(polygon);
    for (const std::vector<int>& strip : cells(document, "Strips", builder.num_vertices(), in))
        for (std::size_t k = 2; k < strip.size(); ++k)  // every other triangle of a strip is turned
            builder.corners.insert(builder.corners.end(),
                                   {strip[k - 2], strip[k % 2 == 0 ? k - 1 : k], strip[k % 2 == 0 ? k : k - 1]});
}

}  // namespace

VtpFile parse_vtp(std::string_view bytes, const std::string& name) {
    XmlScanner in(bytes, name);
    const Document document = scan(in);
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
