#include "core/formats/vtp.hpp"

#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"

#include <cmath>

namespace strake {
namespace {

std::string escaped(const std::string& name) {
    std::string out;
    for (const char c : formats::one_line(name)) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

/// XML followed by the arrays' bytes, each with its length.
struct Document {
    std::string xml, data;

    void array(const std::string& name, const char* type, int components, const void* values, std::size_t bytes) {
        xml +=
            text("<DataArray type=\"", type, "\" Name=\"", escaped(name), "\" NumberOfComponents=\"",
                 std::to_string(components), "\" format=\"appended\" offset=\"", std::to_string(data.size()), "\"/>\n");
        const std::uint64_t length = bytes;
        data.append(reinterpret_cast<const char*>(&length), sizeof length);
        data.append(static_cast<const char*>(values), bytes);
    }
    void points(const std::string& name, const Points& values) {
        array(name, "Float64", 3, values.data(), 8 * static_cast<std::size_t>(values.size()));
    }
    void labels(const std::string& name, const int* values, std::size_t count) {
        array(name, "Int32", 1, values, 4 * count);
    }
};

void check(const Field& field, Eigen::Index rows, bool finite, int expected, const char* where) {
    if (rows != expected)
        throw InvalidInput(
            text("write_vtp: field '", field.name, "' has ", rows, " values, the surface has ", expected, " ", where));
    if (!finite) throw InvalidInput(text("write_vtp: field '", field.name, "' holds a value that is not finite"));
}

void add_fields(Document& out, const char* tag, const std::vector<Field>& fields, int expected, const char* where) {
    out.xml += text("<", tag, ">\n");
    for (const Field& field : fields) {
        if (const auto* scalars = std::get_if<Eigen::VectorXd>(&field.values)) {
            check(field, scalars->size(), scalars->allFinite(), expected, where);
            out.array(field.name, "Float64", 1, scalars->data(), 8 * static_cast<std::size_t>(scalars->size()));
        } else if (const auto* vectors = std::get_if<Points>(&field.values)) {
            check(field, vectors->rows(), vectors->allFinite(), expected, where);
            out.points(field.name, *vectors);
        } else {
            const auto& labels = std::get<std::vector<int>>(field.values);
            check(field, static_cast<Eigen::Index>(labels.size()), true, expected, where);
            out.labels(field.name, labels.data(), labels.size());
        }
    }
    out.xml += text("</", tag, ">\n");
}

/// Texts in VTK's form: their bytes as numbers, each text zero-terminated.
std::string strings(const char* name, const std::vector<std::string>& texts) {
    std::string out = text("<FieldData>\n<DataArray type=\"String\" Name=\"", name, "\" NumberOfTuples=\"",
                           std::to_string(texts.size()), "\" format=\"ascii\">\n");
    for (const std::string& one : texts) {
        for (const unsigned char c : formats::one_line(one)) out += std::to_string(int{c}) + " ";
        out += "0\n";
    }
    return out + "</DataArray>\n</FieldData>\n";
}

/// @param names of the numbers in the cell field "part"; stored once per file
std::string document(const TriMesh& mesh, const std::vector<Field>& point_fields, const std::vector<Field>& cell_fields,
                     const std::vector<std::string>& names) {
    if (!mesh.vertices.allFinite()) throw InvalidInput("write_vtp: a vertex is not finite");
    Document out;
    out.xml = text(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<PolyData>\n",
        names.empty() ? "" : strings("part_names", names), "<Piece NumberOfPoints=\"",
        std::to_string(mesh.num_vertices()), "\" NumberOfPolys=\"", std::to_string(mesh.num_triangles()), "\">\n");
    add_fields(out, "PointData", point_fields, mesh.num_vertices(), "vertices");
    add_fields(out, "CellData", cell_fields, mesh.num_triangles(), "triangles");
    out.xml += "<Points>\n";
    out.points("Points", mesh.vertices);
    out.xml += "</Points>\n<Polys>\n";
    out.labels("connectivity", mesh.triangles.data(), static_cast<std::size_t>(mesh.triangles.size()));
    std::vector<int> offsets(static_cast<std::size_t>(mesh.num_triangles()));
    for (std::size_t t = 0; t < offsets.size(); ++t) offsets[t] = 3 * static_cast<int>(t + 1);
    out.labels("offsets", offsets.data(), offsets.size());
    out.xml += "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    return out.xml + out.data + "\n</AppendedData>\n</VTKFile>\n";
}

}  // namespace

std::string vtp_bytes(const TriMesh& mesh, const std::vector<Field>& point_fields,
                      const std::vector<Field>& cell_fields) {
    return document(mesh, point_fields, cell_fields, {});
}

std::string formats::vtp(const TriMesh& mesh) {
    if (mesh.group.empty()) return vtp_bytes(mesh);
    return document(mesh, {}, {{"part", mesh.group}}, mesh.group_names);
}

void write_vtp(const std::filesystem::path& file, const TriMesh& mesh, const std::vector<Field>& point_fields,
               const std::vector<Field>& cell_fields) {
    write_atomically(file, vtp_bytes(mesh, point_fields, cell_fields));
}

void write_pvd(const std::filesystem::path& file, const std::vector<std::pair<double, std::string>>& steps) {
    std::string out =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
        "<Collection>\n";
    for (const auto& [time, name] : steps) {
        if (!std::isfinite(time)) throw InvalidInput(text("write_pvd: time ", time, " of '", name, "' is not finite"));
        out += "<DataSet timestep=\"";
        formats::append(out, time);
        out += "\" part=\"0\" file=\"" + escaped(name) + "\"/>\n";
    }
    write_atomically(file, out + "</Collection>\n</VTKFile>\n");
}

}  // namespace strake
