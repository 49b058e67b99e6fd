#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/text/file.hpp"
#include "core/text/text_scanner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

/// Legacy VTK files: POLYDATA (polygons and triangle strips) and the triangles, quadrilaterals and polygons of an
/// UNSTRUCTURED_GRID, text and binary (big-endian), in the layouts up to 4.2 and from 5.0. Ignores attributes after the
/// cells.
namespace strake::formats {
namespace {

struct Scalar {
    const char* name;
    std::size_t bytes;
    bool is_real;
};
constexpr Scalar scalars[] = {{"float", 4, true},         {"double", 8, true},        {"int", 4, false},
                              {"long", 8, false},         {"vtktypeint64", 8, false}, {"vtktypeint32", 4, false},
                              {"unsigned_int", 4, false}, {"short", 2, false},        {"vtkidtype", 4, false}};

std::string lower(std::string_view word) {
    std::string out(word);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return out;
}

/// Keyword lines, followed by numbers as text or bytes.
class VtkSource {
public:
    VtkSource(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

    void set_binary(bool binary) { binary_ = binary; }
    std::size_t position() const { return position_; }
    void go_back_to(std::size_t position) { position_ = position; }
    /// The next line that is not blank, trimmed; empty at the end.
    std::string_view line() {
        while (position_ < bytes_.size()) {
            begin_ = position_;
            const std::size_t end = std::min(bytes_.find('\n', position_), bytes_.size());
            position_ = std::min(end + 1, bytes_.size());
            std::string_view text = bytes_.substr(begin_, end - begin_);
            while (!text.empty() && std::strchr(" \t\r", text.back())) text.remove_suffix(1);
            while (!text.empty() && std::strchr(" \t", text.front())) text.remove_prefix(1);
            if (!text.empty()) return text;
        }
        begin_ = position_;
        return {};
    }
    void skip_to_blank_line() {
        while (position_ < bytes_.size()) {
            const std::size_t end = std::min(bytes_.find('\n', position_), bytes_.size());
            const bool is_blank = bytes_.substr(position_, end - position_).find_first_not_of(" \t\r") == bytes_.npos;
            position_ = std::min(end + 1, bytes_.size());
            if (is_blank) return;
        }
    }
    [[noreturn]] void fail(const std::string& what) const {
        const auto upto = bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(begin_, bytes_.size()));
        throw InputError(text(name_, ":", 1 + std::count(bytes_.begin(), upto, '\n'), ": ", what));
    }

    std::vector<double> reals(std::int64_t count, const Scalar& type, std::string_view what) {
        if (!type.is_real) fail(text(what, " are given as ", type.name, "; float or double is expected"));
        std::vector<double> values;
        read(
            count, type, what,
            [&](const char* raw) {
                values.push_back(type.bytes == 4 ? static_cast<double>(get<float>(raw)) : get<double>(raw));
            },
            [&](const TextScanner& in, std::string_view word) { values.push_back(in.number(word, what)); });
        for (std::size_t i = 0; i < values.size(); ++i)
            if (!std::isfinite(values[i]))
                fail(text("number ", i, " of the ", what, " is not finite (", values[i], ")"));
        return values;
    }
    std::vector<std::int64_t> integers(std::int64_t count, const Scalar& type, std::string_view what) {
        if (type.is_real) fail(text(what, " are given as ", type.name, "; whole numbers are expected"));
        std::vector<std::int64_t> values;
        read(
            count, type, what,
            [&](const char* raw) {
                values.push_back(type.bytes == 8   ? get<std::int64_t>(raw)
                                 : type.bytes == 4 ? std::int64_t{get<std::int32_t>(raw)}
                                                   : std::int64_t{get<std::int16_t>(raw)});
            },
            [&](const TextScanner& in, std::string_view word) { values.push_back(in.integer(word, what)); });
        return values;
    }

private:
    template <class T>
    static T get(const char* raw) {
        char native[sizeof(T)];
        std::reverse_copy(raw, raw + sizeof(T), native);
        T value;
        std::memcpy(&value, native, sizeof(T));
        return value;
    }
    template <class Bytes, class Word>
    void read(std::int64_t count, const Scalar& type, std::string_view what, const Bytes& bytes, const Word& word) {
        const std::size_t left = bytes_.size() - position_, each = binary_ ? type.bytes : 2;
        if (count < 0 || static_cast<std::uint64_t>(count) > (binary_ ? left : left + 1) / each)
            fail(text(count, " numbers (", what, ") are announced, ", left, " bytes follow"));
        if (binary_) {
            for (std::int64_t i = 0; i < count; ++i, position_ += type.bytes) bytes(bytes_.data() + position_);
            return;
        }
        const auto here = bytes_.begin() + static_cast<std::ptrdiff_t>(position_);
        TextScanner in(bytes_.substr(position_), name_, {}, 1 + std::count(bytes_.begin(), here, '\n'));
        for (std::int64_t i = 0; i < count; ++i) {
            const std::string_view w = in.any_word();
            if (w.empty()) in.unexpected({}, what);
            word(in, w);
            position_ = static_cast<std::size_t>(w.data() + w.size() - bytes_.data());
        }
    }

    std::string_view bytes_;
    const std::string& name_;
    std::size_t position_ = 0, begin_ = 0;
    bool binary_ = false;
};

class VtkReader {
public:
    VtkReader(std::string_view bytes, const std::string& name) : in_(bytes, name), name_(name) {}

    SurfaceFile read() {
        read_head();
        for (std::string_view line = in_.line(); !line.empty(); line = in_.line()) {
            words_ = TextScanner(line, name_, {});
            words_->next_line();
            const std::string key = lower(words_->word());
            if (key == "points")
                read_points();
            else if (key == "polygons" || key == "triangle_strips")
                read_cells(key == "triangle_strips");
            else if (key == "vertices" || key == "lines")
                read_list();
            else if (key == "cells")
                cells_ = read_list();
            else if (key == "cell_types")
                read_types();
            else if (key == "metadata")
                skip_metadata();
            else if (key == "point_data" || key == "cell_data")
                break;
            else if (key == "field")
                in_.fail("FIELD before the cells is not supported; save the surface without it");
            else
                in_.fail(text("expected POINTS, POLYGONS or CELLS, got '", printable(line, 40), "'"));
        }
        SurfaceBuilder surface = is_grid_ ? builder_.with_used_vertices_only() : std::move(builder_);
        return surface.finish(name_, SurfaceFormat::vtk);
    }

private:
    using Cells = std::vector<std::vector<std::int64_t>>;

    void read_head() {
        if (!in_.line().starts_with("# vtk DataFile Version")) in_.fail("expected '# vtk DataFile Version ...'");
        std::string encoding = lower(in_.line());  // the title, which may be empty
        if (encoding != "ascii" && encoding != "binary") encoding = lower(in_.line());
        if (encoding != "ascii" && encoding != "binary")
            in_.fail(text("expected ASCII or BINARY, got '", printable(encoding, 40), "'"));
        const std::string set = lower(in_.line());
        is_grid_ = set.ends_with("unstructured_grid");
        if (!set.starts_with("dataset") || !(is_grid_ || set.ends_with("polydata")))
            in_.fail(text("expected DATASET POLYDATA or DATASET UNSTRUCTURED_GRID, got '", printable(set, 40), "'"));
        in_.set_binary(encoding == "binary");
    }
    std::int64_t count(std::string_view what) {
        const std::string_view word = words_->word();
        if (word.empty()) in_.fail(text("expected ", what, ", got the end of the line"));
        std::int64_t n = -1;
        try {
            n = words_->integer(word, what);
        } catch (const InputError&) {
        }
        if (n < 0) in_.fail(text("expected ", what, ", got '", printable(word, 40), "'"));
        return n;
    }
    const Scalar& type(std::string_view word) {
        const std::string wanted = lower(word);
        for (const Scalar& s : scalars)
            if (wanted == s.name) return s;
        in_.fail(
            text("the type '", printable(word, 40), "' is not known; float, double, int or vtktypeint64 is expected"));
    }
    void read_points() {
        const std::int64_t n = count("number of points");
        if (n > std::numeric_limits<int>::max()) in_.fail(text(n, " points, at most 2147483647 are possible"));
        builder_.coordinates = in_.reals(3 * n, type(words_->word()), "coordinates of the points");
    }
    /// Up to 4.2: length and points of each cell in one list; from 5.0 two lists, OFFSETS and CONNECTIVITY.
    Cells read_list() {
        const std::int64_t n = count("number of cells"), size = count("length of the list of cells");
        const Scalar legacy{"int", 4, false};
        Cells cells;
        const std::size_t here = in_.position();
        const std::string_view next = in_.line();
        if (!lower(next).starts_with("offsets")) {
            in_.go_back_to(here);
            const std::vector<std::int64_t> list = in_.integers(size, legacy, "corners of the cells");
            for (std::size_t at = 0; at < list.size();) {
                const std::int64_t corners = list[at];
                if (corners < 0 || static_cast<std::uint64_t>(corners) > list.size() - at - 1)
                    in_.fail(text("a cell of ", corners, " corners leaves the list of ", size, " numbers"));
                const auto begin = list.begin() + static_cast<std::ptrdiff_t>(at + 1);
                cells.emplace_back(begin, begin + corners);
                at += static_cast<std::size_t>(corners) + 1;
            }
            if (static_cast<std::int64_t>(cells.size()) != n)
                in_.fail(text(n, " cells are announced, the list has ", cells.size()));
            return cells;
        }
        const auto offsets = in_.integers(n, type(next.substr(std::min(next.size(), next.find_last_of(" \t") + 1))),
                                          "offsets of the cells");
        const std::string_view connectivity = in_.line();
        if (!lower(connectivity).starts_with("connectivity")) in_.fail("expected CONNECTIVITY behind OFFSETS");
        const auto list =
            in_.integers(size, type(connectivity.substr(connectivity.find_last_of(" \t") + 1)), "corners of the cells");
        for (std::size_t c = 0; c + 1 < offsets.size(); ++c) {
            if (offsets[c] < 0 || offsets[c] > offsets[c + 1] || offsets[c + 1] > size)
                in_.fail(
                    text("offset ", offsets[c + 1], " of cell ", c, " lies outside of ", offsets[c], " to ", size));
            cells.emplace_back(list.begin() + offsets[c], list.begin() + offsets[c + 1]);
        }
        return cells;
    }
    void add(const std::vector<std::int64_t>& cell, bool is_strip) {
        std::vector<int> polygon;
        for (const std::int64_t v : cell) {
            if (v < 0 || v >= builder_.num_vertices())
                in_.fail(text("point ", v, " of a cell, limits 0 and ", builder_.num_vertices() - 1));
            polygon.push_back(static_cast<int>(v));
        }
        if (polygon.size() < 3) in_.fail(text("a polygon has at least 3 corners, got ", polygon.size()));
        if (!is_strip) return builder_.add_polygon(polygon);
        for (std::size_t k = 0; k + 2 < polygon.size(); ++k) {
            const std::array<int, 3> triangle{polygon[k + k % 2], polygon[k + 1 - k % 2], polygon[k + 2]};
            builder_.add_polygon(triangle);
        }
    }
    void read_cells(bool are_strips) {
        for (const auto& cell : read_list()) add(cell, are_strips);
    }
    void read_types() {
        const std::int64_t n = count("number of cell types");
        const auto types = in_.integers(n, Scalar{"int", 4, false}, "types of the cells");
        if (types.size() != cells_.size()) in_.fail(text(n, " cell types for ", cells_.size(), " cells"));
        constexpr std::int64_t triangle = 5, strip = 6, pixel = 8, quadrilateral = 9;  // 7: polygon
        for (std::size_t c = 0; c < types.size(); ++c) {
            if (types[c] == pixel && cells_[c].size() == 4) std::swap(cells_[c][2], cells_[c][3]);
            if (types[c] >= triangle && types[c] <= quadrilateral) add(cells_[c], types[c] == strip);
        }
    }
    /// ParaView's notes on an array; they end with a blank line.
    void skip_metadata() { in_.skip_to_blank_line(); }

    VtkSource in_;
    const std::string& name_;
    std::optional<TextScanner> words_;
    SurfaceBuilder builder_;
    Cells cells_;
    bool is_grid_ = false;
};

void append_big_endian(std::string& out, const void* value, std::size_t bytes) {
    const char* raw = static_cast<const char*>(value);
    for (std::size_t k = bytes; k > 0; --k) out += raw[k - 1];
}

}  // namespace

SurfaceFile read_vtk(std::string_view bytes, const std::string& name) { return VtkReader(bytes, name).read(); }

std::string vtk(const TriMesh& mesh) {
    std::string out = "# vtk DataFile Version 3.0\nsurface\nBINARY\nDATASET POLYDATA\nPOINTS ";
    out += std::to_string(mesh.num_vertices()) + " double\n";
    for (Eigen::Index i = 0; i < mesh.vertices.size(); ++i)
        append_big_endian(out, mesh.vertices.data() + i, sizeof(double));
    out += "\nPOLYGONS " + std::to_string(mesh.num_triangles()) + " " + std::to_string(4 * mesh.num_triangles()) + "\n";
    const std::int32_t three = 3;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        append_big_endian(out, &three, sizeof three);
        for (int k = 0; k < 3; ++k) append_big_endian(out, &mesh.triangles(t, k), sizeof(std::int32_t));
    }
    return out + "\n";
}

}  // namespace strake::formats
