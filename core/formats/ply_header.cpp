#include "core/formats/ply_header.hpp"

#include "core/error.hpp"
#include "core/text/text_scanner.hpp"

#include <algorithm>

namespace strake::formats {
namespace {

struct TypeName {
    std::string_view name, sized_name;
    PlyType type;
    std::size_t bytes;
};
constexpr TypeName type_names[] = {
    {"char", "int8", PlyType::int8, 1},        {"uchar", "uint8", PlyType::uint8, 1},
    {"short", "int16", PlyType::int16, 2},     {"ushort", "uint16", PlyType::uint16, 2},
    {"int", "int32", PlyType::int32, 4},       {"uint", "uint32", PlyType::uint32, 4},
    {"float", "float32", PlyType::float32, 4}, {"double", "float64", PlyType::float64, 8},
};

PlyType parse_type(const TextScanner& in, std::string_view word) {
    for (const auto& t : type_names)
        if (word == t.name || word == t.sized_name) return t.type;
    in.unexpected(word, "a type (char, uchar, short, ushort, int, uint, float, double)");
}

/// All lines end like the first: after "end_header" of a binary file the next byte may look like a line end.
std::size_t header_size(std::string_view bytes, const TextScanner& in) {
    const std::size_t first = bytes.find_first_of("\r\n");
    if (first == bytes.npos) in.fail("the header has no line 'end_header'");
    const std::string_view line_end = bytes.substr(first, 2) == "\r\n" ? "\r\n" : bytes.substr(first, 1);
    std::size_t at = 0;
    while ((at = bytes.find("end_header", at)) != bytes.npos) {
        const bool starts_line = at > 0 && (bytes[at - 1] == '\n' || bytes[at - 1] == '\r');
        at += 10;
        const std::size_t end = bytes.find_first_not_of(" \t", at);
        if (starts_line && end != bytes.npos && bytes.substr(end).starts_with(line_end)) return end + line_end.size();
    }
    in.fail("the header has no line 'end_header'");
}

void parse_format(TextScanner& in, PlyHeader& header) {
    const std::string_view encoding = in.word();
    if (encoding == "ascii")
        header.encoding = PlyEncoding::ascii;
    else if (encoding == "binary_little_endian")
        header.encoding = PlyEncoding::little_endian;
    else if (encoding == "binary_big_endian")
        header.encoding = PlyEncoding::big_endian;
    else
        in.unexpected(encoding, "ascii, binary_little_endian or binary_big_endian");
    if (const auto version = in.word(); version != "1.0") in.unexpected(version, "version 1.0");
}

void parse_element(TextScanner& in, PlyHeader& header) {
    PlyElement element;
    element.name = in.word();
    if (element.name.empty()) in.unexpected({}, "the name of an element");
    if (header.has(element.name)) in.fail(text("element '", element.name, "' stands twice"));
    element.count = in.integer(in.word(), "count of an element");
    if (element.count < 0) in.fail(text(element.count, " elements '", element.name, "': a count cannot be negative"));
    if (element.count > 2147483647 && (element.name == "vertex" || element.name == "face"))
        in.fail(text(element.count, " elements '", element.name, "', at most 2147483647 are possible"));
    header.elements.push_back(std::move(element));
}

void parse_property(TextScanner& in, PlyHeader& header) {
    if (header.elements.empty()) in.fail("a property before the first element");
    PlyProperty property;
    property.line = in.line();
    std::string_view word = in.word();
    if (word == "list") {
        property.is_list = true;
        property.count_type = parse_type(in, in.word());
        if (property.count_type == PlyType::float32 || property.count_type == PlyType::float64)
            in.fail("the length of a list must be of a whole-number type");
        word = in.word();
    }
    property.type = parse_type(in, word);
    property.name = in.word();
    if (property.name.empty()) in.unexpected({}, "the name of a property");
    auto& properties = header.elements.back().properties;
    if (std::any_of(properties.begin(), properties.end(), [&](const auto& p) { return p.name == property.name; }))
        in.fail(text("property '", property.name, "' stands twice"));
    properties.push_back(std::move(property));
}

}  // namespace

std::size_t size_of(PlyType type) {
    for (const auto& t : type_names)
        if (t.type == type) return t.bytes;
    return 0;
}

bool PlyHeader::has(std::string_view element) const {
    return std::any_of(elements.begin(), elements.end(), [&](const auto& e) { return e.name == element; });
}

PlyHeader read_ply_header(std::string_view bytes, const std::string& name) {
    PlyHeader header;
    TextScanner in(bytes, name, {});
    if (!in.next_line() || in.word() != "ply" || !in.rest().empty()) in.fail("a PLY file begins with the line 'ply'");
    header.bytes = header_size(bytes, in);
    TextScanner lines(bytes.substr(0, header.bytes), name, {});
    lines.next_line();
    bool has_format = false;
    while (lines.next_line()) {
        const std::string_view keyword = lines.word();
        if (keyword == "comment" || keyword == "obj_info") {
            continue;
        } else if (keyword == "end_header") {
            break;
        } else if (keyword == "format" && !has_format) {
            parse_format(lines, header);
            has_format = true;
        } else if (keyword == "element") {
            parse_element(lines, header);
        } else if (keyword == "property") {
            parse_property(lines, header);
        } else {
            lines.unexpected(keyword, "format, comment, element, property or end_header");
        }
        if (const auto more = lines.word(); !more.empty()) lines.unexpected(more, "the end of the line");
    }
    header.lines = lines.line();
    if (!has_format) lines.fail("the header has no line 'format'");
    return header;
}

}  // namespace strake::formats
