#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/text/raw_number.hpp"
#include "core/text/text_scanner.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

/// Cart3D .tri: counts, vertices, triangles (counted from 1), and a component number per triangle or none. Text in
/// Fortran's style (free line breaks, exponents with D), or unformatted records of either byte order. Skips columns
/// after x, y, z if each vertex has its own line.
namespace strake::formats {
namespace {

constexpr TextScanner::Syntax tri_syntax{.comment = '#', .continuation = false, .fortran = true};

struct Counts {
    std::int64_t vertices = 0, triangles = 0;
};

Counts read_counts(TextScanner& in) {
    if (!in.next_line()) in.unexpected({}, "the numbers of vertices and triangles");
    Counts n;
    n.vertices = in.integer(in.any_word(), "number of vertices");
    n.triangles = in.integer(in.any_word(), "number of triangles");
    // Annotated files continue with the number of scalars; component files with the number of components.
    if (const auto more = in.word(); !more.empty()) in.integer(more, "number of scalars or components");
    if (const auto more = in.word(); !more.empty()) in.unexpected(more, "the end of the line");
    in.check_room(n.vertices, 6, "vertices");
    in.check_room(n.triangles, 6, "triangles");
    return n;
}

struct Layout {
    std::int64_t columns = 3;  ///< numbers a vertex
    bool components = false;
};

/// Infers the contents from the number of words, in total and on the vertices' lines.
Layout find_layout(TextScanner in, const Counts& n) {
    std::int64_t words = 0, lines = 0, columns = 0;
    bool regular = true;  // the vertices have a line each, all of the same length
    while (in.next_line()) {
        std::int64_t on_line = 0;
        while (!in.word().empty()) ++on_line;
        if (lines == 0) columns = on_line;
        if (lines++ < n.vertices && on_line != columns) regular = false;
        words += on_line;
    }
    regular = regular && lines >= n.vertices && columns >= 3;
    for (const std::int64_t c : {regular ? columns : 3, std::int64_t{3}}) {
        if (words == c * n.vertices + 3 * n.triangles) return {c, false};
        if (words == c * n.vertices + 4 * n.triangles) return {c, true};
    }
    const std::int64_t c = regular ? columns : 3;
    in.fail(text(n.vertices, " vertices of ", c, " numbers and ", n.triangles, " triangles need ",
                 c * n.vertices + 3 * n.triangles, " numbers, or ", c * n.vertices + 4 * n.triangles,
                 " with component numbers; the file has ", words, " after the header"));
}

int corner(std::int64_t v, std::int64_t num_vertices, const auto& fail) {
    if (v < 1 || v > num_vertices) fail(text("corner ", v, " of a triangle, limits 1 and ", num_vertices));
    return static_cast<int>(v - 1);
}

SurfaceFile read_text(std::string_view bytes, const std::string& name) {
    TextScanner in(bytes, name, tri_syntax);
    const Counts n = read_counts(in);
    const Layout layout = find_layout(in, n);
    const auto fail = [&](const std::string& what) { in.fail(what); };
    SurfaceBuilder builder;
    builder.coordinates.reserve(3 * static_cast<std::size_t>(n.vertices));
    for (std::int64_t v = 0; v < n.vertices; ++v)
        for (std::int64_t k = 0; k < layout.columns; ++k) {
            const double value = in.number(in.any_word(), "coordinate of a vertex");
            if (k < 3) builder.coordinates.push_back(value);
        }
    builder.corners.reserve(3 * static_cast<std::size_t>(n.triangles));
    for (std::int64_t i = 0; i < 3 * n.triangles; ++i)
        builder.corners.push_back(corner(in.integer(in.any_word(), "corner of a triangle"), n.vertices, fail));
    for (std::int64_t t = 0; t < n.triangles && layout.components; ++t)
        builder.group.push_back(builder.group_number(std::to_string(in.integer(in.any_word(), "component number"))));
    return builder.finish(name, SurfaceFormat::tri);
}

/// Unformatted Fortran records: a length in bytes before and after each.
class Records {
public:
    Records(std::string_view bytes, const std::string& name, bool swap) : bytes_(bytes), name_(name), swap_(swap) {}

    bool at_end() const { return position_ == bytes_.size(); }
    std::size_t position() const { return position_; }
    /// The next record; `what` for messages.
    std::string_view next(std::string_view what) {
        if (bytes_.size() - position_ < 4) fail(text("the file ends before the ", what));
        const std::uint32_t length = get<std::uint32_t>(bytes_.data() + position_);
        if (bytes_.size() - position_ < 8 + std::uint64_t{length})
            fail(text("the record of the ", what, " has ", length, " bytes, the file ends after ",
                      bytes_.size() - position_ - 4));
        const std::string_view record = bytes_.substr(position_ + 4, length);
        if (get<std::uint32_t>(record.data() + length) != length)
            fail(text("the record of the ", what, " begins and ends with different lengths"));
        position_ += 8 + std::size_t{length};
        return record;
    }
    template <class T>
    T get(const char* at) const {
        return raw_number<T>(at, swap_);
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(text(name_, ": byte ", position_, ": ", what));
    }

private:
    std::string_view bytes_;
    const std::string& name_;
    bool swap_;
    std::size_t position_ = 0;
};

void read_vertices(Records& in, SurfaceBuilder& builder, std::int64_t count) {
    const std::string_view record = in.next("vertices");
    const bool doubles = record.size() == 24 * static_cast<std::uint64_t>(count);
    if (!doubles && record.size() != 12 * static_cast<std::uint64_t>(count))
        in.fail(
            text(count, " vertices need a record of ", 12 * count, " or ", 24 * count, " bytes, got ", record.size()));
    builder.coordinates.resize(3 * static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < builder.coordinates.size(); ++i) {
        double& x = builder.coordinates[i];
        x = doubles ? in.get<double>(record.data() + 8 * i) : static_cast<double>(in.get<float>(record.data() + 4 * i));
        if (!std::isfinite(x)) in.fail(text("vertex ", i / 3, " is not finite (", x, ")"));
    }
}

SurfaceFile read_records(std::string_view bytes, const std::string& name, bool swap) {
    Records in(bytes, name, swap);
    const auto fail = [&](const std::string& what) { in.fail(what); };
    const std::string_view header = in.next("counts");
    const Counts n{in.get<std::int32_t>(header.data()), in.get<std::int32_t>(header.data() + 4)};
    if (n.vertices < 0 || n.triangles < 0) in.fail(text("counts ", n.vertices, " and ", n.triangles, " are negative"));
    SurfaceBuilder builder;
    read_vertices(in, builder, n.vertices);
    const std::string_view corners = in.next("triangles");
    if (corners.size() != 12 * static_cast<std::uint64_t>(n.triangles))
        in.fail(text(n.triangles, " triangles need a record of ", 12 * n.triangles, " bytes, got ", corners.size()));
    for (std::size_t i = 0; i < corners.size() / 4; ++i)
        builder.corners.push_back(corner(in.get<std::int32_t>(corners.data() + 4 * i), n.vertices, fail));
    if (!in.at_end()) {
        const std::string_view ids = in.next("component numbers");
        if (ids.size() != 4 * static_cast<std::uint64_t>(n.triangles) || !in.at_end())
            in.fail(text(n.triangles, " component numbers need a last record of ", 4 * n.triangles, " bytes"));
        for (std::size_t t = 0; t < ids.size() / 4; ++t)
            builder.group.push_back(builder.group_number(std::to_string(in.get<std::int32_t>(ids.data() + 4 * t))));
    }
    return builder.finish(name, SurfaceFormat::tri);
}

}  // namespace

SurfaceFile read_tri(std::string_view bytes, const std::string& name) {
    // The first record of the binary form holds two integers (or three): its length is a small number.
    if (bytes.size() >= 4) {
        std::array<unsigned char, 4> b;
        std::memcpy(b.data(), bytes.data(), 4);
        const auto marker = [](int n) { return n == 8 || n == 12; };
        if (b[0] == 0 && b[1] == 0 && b[2] == 0 && marker(b[3])) return read_records(bytes, name, true);
        if (marker(b[0]) && b[1] == 0 && b[2] == 0 && b[3] == 0) return read_records(bytes, name, false);
    }
    return read_text(bytes, name);
}

std::string tri(const TriMesh& mesh) {
    std::string out;
    append_counts(out, mesh);
    for (int v = 0; v < mesh.num_vertices(); ++v) append_row(out, "", mesh.vertices.data() + 3 * v);
    for (int t = 0; t < mesh.num_triangles(); ++t) append_row(out, "", mesh.triangles.data() + 3 * t, 1);
    const std::vector<std::string> numbers = component_numbers(mesh);
    for (const int g : mesh.group) out += numbers[g] + "\n";
    return out;
}

}  // namespace strake::formats
