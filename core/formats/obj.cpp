#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/obj_skipped.hpp"
#include "core/text/text_scanner.hpp"

#include <algorithm>
#include <array>
#include <limits>

/// Wavefront OBJ: vertices, faces, groups. Indices of texture coordinates and normals must be whole numbers; materials
/// and textures are never opened.
namespace strake::formats {
namespace {

constexpr std::array<std::string_view, 16> ignored = {
    "vt", "vn", "s",   "usemtl", "mtllib",   "usemap",   "maplib",     "l",
    "p",  "mg", "lod", "bevel",  "c_interp", "d_interp", "shadow_obj", "trace_obj"};
/// Curves and surfaces without triangles (the free-form part of the format, version 3.0, and what it had before), and
/// commands to the program that reads the file.
constexpr std::array<std::string_view, 26> free_form = {
    "vp",  "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim",  "hole",  "scrv", "sp",
    "end", "con",    "bsp", "bzp",  "cdc",  "cdp",  "res",   "call", "csh",  "ctech", "stech", "bzs",  "bss"};

template <std::size_t n>
bool is_one_of(const std::array<std::string_view, n>& words, std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

std::string skipped_words(int lines, long first) {
    return text(lines, lines > 1 ? " lines" : " line", " of free-form curves and surfaces (first: line ", first, ")");
}

void read_vertex(TextScanner& in, SurfaceBuilder& builder) {
    for (int k = 0; k < 3; ++k) builder.coordinates.push_back(in.number(in.word(), "coordinate of a vertex"));
    // A weight, a colour, or both may follow.
    int more = 0;
    for (std::string_view w = in.word(); !w.empty(); w = in.word(), ++more)
        in.number(w, "weight or colour of a vertex");
    if (more > 4) in.fail(text("a vertex has 3 coordinates and at most 4 more numbers, got ", 3 + more, " numbers"));
}

/// The vertex of a corner "v", "v/vt", "v//vn" or "v/vt/vn", counted from 0. Positive numbers may refer to later
/// vertices and are checked at the end.
int corner_vertex(const TextScanner& in, std::string_view corner, int num_vertices) {
    std::array<std::int64_t, 3> index{};
    std::string_view left = corner;
    if (left.starts_with('/')) in.unexpected(corner, "a corner like 1, 1/2, 1//3 or 1/2/3");
    for (int part = 0; part < 3; ++part) {
        const std::size_t slash = left.find('/');
        const std::string_view digits = left.substr(0, slash);
        if (part == 0 || !digits.empty()) {
            index[part] = in.integer(digits, "vertex number of a face");
            if (index[part] == 0) in.fail("a face has the vertex number 0; OBJ counts from 1");
        }
        if (slash == left.npos) break;
        left = left.substr(slash + 1);
        if (part == 2) in.unexpected(corner, "a corner like 1, 1/2, 1//3 or 1/2/3");
    }
    const std::int64_t v = index[0] > 0 ? index[0] - 1 : num_vertices + index[0];
    if (v < 0) in.fail(text("vertex number ", index[0], " of a face: only ", num_vertices, " vertices precede it"));
    if (v >= std::numeric_limits<int>::max()) in.fail(text("vertex number ", index[0], " of a face is too large"));
    return static_cast<int>(v);
}

struct ObjReader {
    TextScanner in;
    const std::string& name;
    SurfaceBuilder builder{};
    int group = -1;
    int largest = -1;  ///< vertex that a face names, and where
    long largest_line = 0;
    std::vector<int> polygon{};
    int free_form_lines = 0;
    long first_free_form = 0;

    void read_face() {
        polygon.clear();
        for (std::string_view w = in.word(); !w.empty(); w = in.word())
            polygon.push_back(corner_vertex(in, w, builder.num_vertices()));
        if (polygon.size() < 3) in.fail(text("a face has at least 3 corners, got ", polygon.size()));
        const int top = *std::max_element(polygon.begin(), polygon.end());
        if (top > largest) {
            largest = top;
            largest_line = in.line();
        }
        builder.add_polygon(polygon, group);
    }

    /// Triangles before the first group belong to "default", the format's name for them.
    void start_group() {
        std::string title(in.rest());
        if (title.empty()) title = "default";
        if (group < 0 && !builder.corners.empty())
            builder.group.assign(builder.corners.size() / 3, builder.group_number("default"));
        group = builder.group_number(title);
    }

    void read_line() {
        const std::string_view keyword = in.word();
        if (keyword == "v") {
            read_vertex(in, builder);
        } else if (keyword == "f" || keyword == "fo") {
            read_face();
        } else if (keyword == "g" || keyword == "o") {
            start_group();
        } else if (is_one_of(free_form, keyword)) {
            if (free_form_lines++ == 0) first_free_form = in.line();
        } else if (!is_one_of(ignored, keyword)) {
            in.unexpected(keyword, "an OBJ keyword such as v, vt, vn, f, g, o, s or usemtl");
        }
    }
};

/// A '#' would begin a comment; a backslash at the end would continue the line.
std::string group_title(const std::string& name) {
    std::string title = one_line(name);
    std::replace(title.begin(), title.end(), '#', '_');
    if (title.ends_with('\\')) title.back() = '_';
    return title;
}

}  // namespace

SurfaceFile read_obj(std::string_view bytes, const std::string& name) {
    ObjReader reader{TextScanner(bytes, name, {.comment = '#', .continuation = true}), name};
    while (reader.in.next_line()) reader.read_line();
    if (reader.largest >= reader.builder.num_vertices())
        throw InputError(text(name, ":", reader.largest_line, ": vertex number ", reader.largest + 1,
                              " of a face: the file has ", reader.builder.num_vertices(), " vertices"));
    if (reader.builder.group.empty()) reader.builder.group_names.clear();
    if (reader.free_form_lines > 0 && reader.builder.corners.empty())
        throw InputError(text(name, ": no faces, only ", skipped_words(reader.free_form_lines, reader.first_free_form),
                              "; export triangles"));
    return reader.builder.finish(name, SurfaceFormat::obj);
}

std::string skipped_in_obj(std::string_view bytes) {
    TextScanner in(bytes, "", {.comment = '#', .continuation = true});
    int count = 0;
    long first = 0;
    while (in.next_line())
        if (is_one_of(free_form, in.word()) && count++ == 0) first = in.line();
    return count > 0 ? skipped_words(count, first) : "";
}

std::string obj(const TriMesh& mesh) {
    std::string out;
    for (int v = 0; v < mesh.num_vertices(); ++v) append_row(out, "v ", mesh.vertices.data() + 3 * v);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.group.empty() && (t == 0 || mesh.group[t] != mesh.group[t - 1]))
            out += "g " + group_title(mesh.group_names[mesh.group[t]]) + "\n";
        append_row(out, "f ", mesh.triangles.data() + 3 * t, 1);
    }
    return out;
}

}  // namespace strake::formats
