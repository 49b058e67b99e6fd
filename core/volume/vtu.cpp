#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/vtk_document.hpp"
#include "core/text/base64.hpp"
#include "core/volume/cell_check.hpp"
#include "core/volume/volume_file.hpp"

#include <zlib.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

/// VTK's XML file of an unstructured grid.
namespace strake::volume_formats {
namespace {

using vtk::Array;
using vtk::Document;

constexpr int polyhedron = 42;

std::vector<int> whole_numbers(const Document& document, const char* name, const XmlScanner& in, bool is_needed) {
    const Array* array = vtk::find(document, "Cells", name);
    if (!array && is_needed) in.fail(text("no array '", name, "' of the cells"));
    std::vector<int> out;
    if (!array) return out;
    for (const double value : vtk::decoded(*array, document, in)) {
        if (!(value >= -1) || value > std::numeric_limits<int>::max() / 3 || value != std::floor(value))
            in.fail(text("cells: ", name, " holds ", value, ", which is no index"));
        out.push_back(static_cast<int>(value));
    }
    return out;
}

/// [number of faces, (number of points, points...)...] up to `end`; orients faces away from the mean of the cell's
/// points, since not every program does.
void add_polyhedron(VolumeMesh& mesh, const std::vector<int>& faces, std::size_t begin, std::size_t end,
                    const XmlScanner& in) {
    const auto next = [&]() -> int {
        if (begin >= end) in.fail("cells: a polyhedron's faces end too early");
        return faces[begin++];
    };
    std::vector<std::vector<int>> polygons(
        static_cast<std::size_t>(std::clamp(next(), 0, static_cast<int>(end - begin))));
    std::set<int> corners;
    for (std::vector<int>& polygon : polygons) {
        for (int n = next(); n > 0; --n) polygon.push_back(next());
        corners.insert(polygon.begin(), polygon.end());
    }
    for (const int v : corners)
        if (v < 0 || v >= mesh.num_points()) in.fail(text("cells: a polyhedron has point ", v));
    Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
    for (const int v : corners) middle += mesh.points.row(v) / static_cast<double>(corners.size());
    for (std::vector<int>& polygon : polygons) {
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < polygon.size(); ++k) {
            const Eigen::Vector3d a = mesh.points.row(polygon[k]) - middle;
            const Eigen::Vector3d b = mesh.points.row(polygon[(k + 1) % polygon.size()]) - middle;
            normal += a.cross(b);
        }
        if (!polygon.empty() && normal.dot((mesh.points.row(polygon[0]) - middle).transpose()) < 0)
            std::reverse(polygon.begin(), polygon.end());
        if (polygon.size() < 3) continue;
        mesh.faces.add(polygon);
        mesh.owner.push_back(mesh.num_cells);
        mesh.neighbour.push_back(-1);
    }
    ++mesh.num_cells;
}

void read_cells(VolumeMesh& mesh, const Document& document, const XmlScanner& in) {
    const std::vector<int> corners = whole_numbers(document, "connectivity", in, true),
                           ends = whole_numbers(document, "offsets", in, true),
                           types = whole_numbers(document, "types", in, true),
                           faces = whole_numbers(document, "faces", in, false),
                           faces_end = whole_numbers(document, "faceoffsets", in, false);
    if (types.size() != ends.size()) in.fail(text(types.size(), " types of ", ends.size(), " cells"));
    for (const int v : corners)
        if (v < 0 || v >= mesh.num_points())
            in.fail(text("cells: point ", v, ", limits 0 and ", mesh.num_points() - 1));
    std::vector<int> kinds;
    std::vector<std::size_t> polyhedra;
    int begin = 0, faces_begin = 0;
    for (std::size_t c = 0; c < ends.size(); ++c) {
        if (ends[c] < begin || static_cast<std::size_t>(ends[c]) > corners.size())
            in.fail(text("cell ", c, " ends at corner ", ends[c], ", limits ", begin, " and ", corners.size()));
        if (types[c] == polyhedron)
            polyhedra.push_back(c);
        else
            add_cell(mesh, types[c], {corners.data() + begin, static_cast<std::size_t>(ends[c] - begin)}, kinds);
        begin = ends[c];
    }
    orient_by_majority(mesh, kinds);
    if (faces_end.size() != ends.size()) {
        mesh.num_unchecked += static_cast<int>(polyhedra.size());
        return;
    }
    for (std::size_t c = 0; c < ends.size(); ++c) {
        if (faces_end[c] < 0) continue;  // of another kind
        if (faces_end[c] < faces_begin || static_cast<std::size_t>(faces_end[c]) > faces.size())
            in.fail(text("the faces of cell ", c, " end at ", faces_end[c], ", limits ", faces_begin, " and ",
                         faces.size()));
        if (types[c] == polyhedron)
            add_polyhedron(mesh, faces, static_cast<std::size_t>(faces_begin), static_cast<std::size_t>(faces_end[c]),
                           in);
        faces_begin = faces_end[c];
    }
}

template <class Number>
void append_raw(std::string& out, Number value, bool swap) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (swap) std::reverse(raw, raw + sizeof value);
    out.append(raw, sizeof value);
}

std::string raw_numbers(const Points& points, bool swap) {
    std::string out;
    out.reserve(8 * static_cast<std::size_t>(points.size()));
    for (Eigen::Index i = 0; i < points.size(); ++i) append_raw(out, points.data()[i], swap);
    return out;
}

/// Lengths in the file's format, then the numbers; a file with a compressor expects one block of zlib.
std::string encoded(const VtuPlace& place, const Points& points) {
    std::string data = raw_numbers(points, place.is_swapped), head;
    const auto length = [&](std::uint64_t value) {
        if (place.header_bytes == 8) return append_raw(head, value, place.is_swapped);
        if (value > std::numeric_limits<std::uint32_t>::max())
            throw OutputError("more than 4 GB of points, and the file's header_type is UInt32");
        append_raw(head, static_cast<std::uint32_t>(value), place.is_swapped);
    };
    if (!place.is_compressed) {
        length(data.size());
        return base64(head + data);
    }
    uLongf packed = compressBound(data.size());
    std::string block(packed, '\0');
    if (compress(reinterpret_cast<Bytef*>(block.data()), &packed, reinterpret_cast<const Bytef*>(data.data()),
                 data.size()) != Z_OK)
        throw OutputError("the points could not be compressed");
    length(1);
    length(data.size());
    length(0);
    length(packed);
    return base64(head) + base64(std::string_view(block).substr(0, packed));
}

}  // namespace

VolumeFile read_vtu(std::string bytes, const std::string& name) {
    VolumeFile out;
    out.format = VolumeFormat::vtu;
    out.bytes = std::move(bytes);
    out.name = name;
    XmlScanner in(out.bytes, name);
    const Document document = vtk::scan(in, "UnstructuredGrid");
    const Array* points = vtk::find(document, "Points", "");
    if (!points || points->components != 3) in.fail("no <Points> of three coordinates");
    const std::vector<double> at = vtk::decoded(*points, document, in);
    for (std::size_t i = 0; i < at.size(); ++i)
        if (!std::isfinite(at[i])) in.fail(text("point ", i / 3, " is not finite (", at[i], ")"));
    out.mesh.points = Eigen::Map<const Points>(at.data(), static_cast<Eigen::Index>(at.size() / 3), 3);
    const vtk::Coding& coding = document.coding;
    out.array = {points->element_begin, points->element_end, 0, points->offset, points->is_text, coding.is_swapped,
                 coding.is_compressed,  coding.header_bytes};
    if (points->is_appended && !points->is_base64 && !coding.is_compressed && points->type == "Float64")
        out.array.raw = static_cast<std::size_t>(points->inside.data() - out.bytes.data()) + coding.header_bytes;
    read_cells(out.mesh, document, in);
    return out;
}

std::string vtu_with_points(const VolumeFile& file, const Points& points) {
    const VtuPlace& place = file.array;
    std::string out = file.bytes;
    std::string element = "<DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"";
    if (place.raw > 0) {  // without the ranges that some programs store in the element
        const std::string numbers = raw_numbers(points, place.is_swapped);
        out.replace(place.raw, numbers.size(), numbers);
        return out.replace(place.begin, place.end - place.begin,
                           element + "appended\" offset=\"" + place.offset + "\"/>");
    }
    element += place.is_text ? "ascii\">\n" : "binary\">\n";
    if (place.is_text)
        for (Eigen::Index i = 0; i < points.rows(); ++i) formats::append_row(element, "", points.data() + 3 * i);
    else
        element += encoded(place, points) + "\n";
    return out.replace(place.begin, place.end - place.begin, element + "</DataArray>");
}

}  // namespace strake::volume_formats
