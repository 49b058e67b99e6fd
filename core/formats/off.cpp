#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/text/text_scanner.hpp"

/// OFF (Geomview), text: one vertex or face a line, with optional normals, colours and texture coordinates, which are
/// skipped.
namespace strake::formats {
namespace {

/// Data per vertex besides its position, from the letters before "OFF".
struct OffHeader {
    bool colours = false;
    int others = 0;  ///< numbers of normals and texture coordinates
};

OffHeader parse_keyword(const TextScanner& in, std::string_view keyword) {
    OffHeader header;
    std::string_view letters = keyword.substr(0, keyword.size() - 3);
    if (letters.starts_with("ST")) {
        header.others += 2;
        letters.remove_prefix(2);
    }
    for (const char c : letters) {
        if (c == 'C')
            header.colours = true;
        else if (c == 'N')
            header.others += 3;
        else
            in.fail(text("'", keyword, "': only surfaces in three dimensions are read (OFF, COFF, NOFF, STOFF)"));
    }
    return header;
}

void read_vertex(TextScanner& in, SurfaceBuilder& builder, const OffHeader& header, std::int64_t v) {
    if (!in.next_line()) in.unexpected({}, text("vertex ", v));
    for (int k = 0; k < 3; ++k) builder.coordinates.push_back(in.number(in.word(), "coordinate of a vertex"));
    int more = 0;
    for (std::string_view w = in.word(); !w.empty(); w = in.word(), ++more)
        in.number_or_nan(w, "normal, colour or texture coordinate of a vertex");
    const int colours = more - header.others;
    if (colours != 3 && colours != 4 && (colours != 0 || header.colours))
        in.fail(text("vertex ", v, " has ", 3 + more, " numbers, expected ", 3 + header.others,
                     header.colours ? " and a colour of 3 or 4" : ""));
}

void read_face(TextScanner& in, SurfaceBuilder& builder, std::vector<int>& polygon, std::int64_t f) {
    if (!in.next_line()) in.unexpected({}, text("face ", f));
    const std::int64_t corners = in.integer(in.word(), "number of corners of a face");
    if (corners < 3) in.fail(text("face ", f, " has ", corners, " corners, at least 3 are needed"));
    in.check_room(corners, 2, "corners");
    polygon.clear();
    for (std::int64_t k = 0; k < corners; ++k) {
        const std::int64_t v = in.integer(in.word(), "corner of a face");
        if (v < 0 || v >= builder.num_vertices())
            in.fail(
                text("corner ", k, " of face ", f, " is vertex ", v, ", limits 0 and ", builder.num_vertices() - 1));
        polygon.push_back(static_cast<int>(v));
    }
    int colour = 0;
    for (std::string_view w = in.word(); !w.empty(); w = in.word(), ++colour) in.number(w, "colour of a face");
    if (colour == 2 || colour > 4) in.fail(text("face ", f, ": a colour has 1, 3 or 4 numbers, got ", colour));
    builder.add_polygon(polygon);
}

}  // namespace

SurfaceFile read_off(std::string_view bytes, const std::string& name) {
    TextScanner in(bytes, name, {.comment = '#'});
    if (!in.next_line()) in.unexpected({}, "the keyword OFF");
    OffHeader header;
    std::string_view word = in.word();
    if (word.ends_with("OFF")) {  // the keyword is optional in Geomview
        header = parse_keyword(in, word);
        word = in.any_word();
        if (word == "BINARY") in.fail("the binary form of OFF is not read; convert it to text");
    }
    const std::int64_t num_vertices = in.integer(word, "number of vertices, after the keyword OFF");
    const std::int64_t num_faces = in.integer(in.any_word(), "number of faces");
    if (const auto edges = in.word(); !edges.empty()) in.integer(edges, "number of edges");
    if (const auto more = in.word(); !more.empty()) in.unexpected(more, "the end of the line");
    in.check_room(num_vertices, 6, "vertices");
    in.check_room(num_faces, 8, "faces");
    SurfaceBuilder builder;
    builder.coordinates.reserve(3 * static_cast<std::size_t>(num_vertices));
    for (std::int64_t v = 0; v < num_vertices; ++v) read_vertex(in, builder, header, v);
    std::vector<int> polygon;
    for (std::int64_t f = 0; f < num_faces; ++f) read_face(in, builder, polygon, f);
    if (in.next_line()) in.unexpected(in.word(), text("the end of the file after ", num_faces, " faces"));
    return builder.finish(name, SurfaceFormat::off);
}

std::string off(const TriMesh& mesh) {
    std::string out = "OFF\n";
    append_counts(out, mesh);
    out.back() = ' ';
    out += "0\n";
    for (int v = 0; v < mesh.num_vertices(); ++v) append_row(out, "", mesh.vertices.data() + 3 * v);
    for (int t = 0; t < mesh.num_triangles(); ++t) append_row(out, "3 ", mesh.triangles.data() + 3 * t, 0);
    return out;
}

}  // namespace strake::formats
