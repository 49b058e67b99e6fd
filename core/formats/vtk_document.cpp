#include "core/formats/vtk_document.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"

#include <charconv>

namespace strake::vtk {
namespace {

std::uint64_t whole(const std::string& word, const XmlScanner& in, const char* what) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
        in.fail(text(what, " '", printable(word, 60), "' is not a whole number"));
    return value;
}

void read_head(const XmlScanner::Tag& tag, const XmlScanner& in, const std::string& kind, Coding& coding) {
    if (tag.value("type") != kind)
        in.fail(text("holds '", printable(tag.value("type"), 60), "', must be ", kind,
                     kind == "PolyData" ? " (ParaView: Extract Surface)" : ""));
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
    array.is_appended = format == "appended";
    array.element_begin = in.tag_begin();
    array.is_base64 = true;
    if (!tag.is_empty) array.inside = in.own_text(tag.name);
    array.element_end = in.position();
    array.offset = tag.value("offset", "0");
    if (format == "appended") out.offsets.emplace_back(out.arrays.size(), array.offset);
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

}  // namespace

Document scan(XmlScanner& in, const std::string& kind) {
    Document out;
    std::string section;
    bool is_vtk = false;
    for (XmlScanner::Tag tag = in.next(); !tag.name.empty(); tag = in.next()) {
        if (tag.name == "VTKFile") is_vtk = true, read_head(tag, in, kind, out.coding);
        if (!is_vtk) in.fail("no VTK file: it does not begin with <VTKFile>");
        if (tag.name == "Piece") ++out.pieces;
        if (tag.name == "DataArray") add_array(tag, section, in, out);
        for (const char* name :
             {"PointData", "CellData", "Points", "Verts", "Lines", "Strips", "Polys", "Cells", "FieldData"})
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

}  // namespace strake::vtk
