#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/text/text_scanner.hpp"

#include <array>
#include <cctype>
#include <limits>
#include <optional>

/// SU2's native mesh: the triangles and quadrilaterals of all markers; drops points used only by volume cells.
namespace strake::formats {
namespace {

constexpr TextScanner::Syntax su2_syntax{.comment = '%', .continuation = false, .fortran = false};
constexpr int vtk_triangle = 5, vtk_quadrilateral = 9;  ///< VTK's numbers

/// A line `KEY= value`; none on a line of data.
struct Setting {
    std::string key, value;
};
std::optional<Setting> setting_of(std::string_view line) {
    const std::size_t sign = line.find('=');
    if (sign == line.npos) return {};
    const auto trimmed = [](std::string_view s) {
        while (!s.empty() && std::isspace(static_cast<unsigned char>(s.front()))) s.remove_prefix(1);
        while (!s.empty() && std::isspace(static_cast<unsigned char>(s.back()))) s.remove_suffix(1);
        return std::string(s);
    };
    return Setting{trimmed(line.substr(0, sign)), trimmed(line.substr(sign + 1, line.find('%', sign) - sign - 1))};
}

class Su2Reader {
public:
    Su2Reader(std::string_view bytes, const std::string& name) : in_(bytes, name, su2_syntax), name_(name) {}

    SurfaceFile read() {
        while (in_.next_line()) {
            const auto setting = setting_of(in_.rest());
            if (!setting) continue;  // data of a key that a surface does not need
            read_setting(*setting);
        }
        if (!points_read_) throw InputError(text(name_, ": no NPOIN=, so there are no points"));
        if (largest_ >= builder_.num_vertices())
            in_.fail_at(largest_line_,
                        text("point ", largest_, " of an element, limits 0 and ", builder_.num_vertices() - 1));
        SurfaceBuilder surface = builder_.with_used_vertices_only();
        return surface.finish(name_, SurfaceFormat::su2);
    }

private:
    void read_setting(const Setting& s) {
        if (s.key == "NDIME" && count(s) != 3)
            in_.fail(text("NDIME= ", s.value, ": a surface needs a mesh of 3 dimensions"));
        if (s.key == "NELEM")
            for (std::int64_t i = count(s); i > 0; --i) line("volume element");
        if (s.key == "NPOIN") read_points(count(s));
        if (s.key == "MARKER_TAG") marker_ = builder_.group_number(s.value);
        if (s.key == "MARKER_ELEMS") read_marker(count(s));
    }
    std::int64_t count(const Setting& s) {
        const std::int64_t n = in_.integer(std::string_view(s.value).substr(0, s.value.find_first_of(" \t")), s.key);
        in_.check_room(n, 2, s.key);
        return n;
    }
    void line(std::string_view what) {
        if (!in_.next_line()) in_.unexpected({}, what);
    }
    void read_points(std::int64_t n) {
        if (points_read_) in_.fail("a second NPOIN=");
        points_read_ = true;
        builder_.coordinates.reserve(3 * static_cast<std::size_t>(n));
        for (std::int64_t v = 0; v < n; ++v) {
            line("point");
            for (int k = 0; k < 3; ++k) builder_.coordinates.push_back(in_.number(in_.word(), "coordinate of a point"));
        }
    }
    void read_marker(std::int64_t n) {
        if (marker_ < 0) in_.fail("MARKER_ELEMS= without a MARKER_TAG= before it");
        for (std::int64_t i = 0; i < n; ++i) {
            line("element of a marker");
            const std::int64_t type = in_.integer(in_.word(), "type of an element");
            if (type != vtk_triangle && type != vtk_quadrilateral)
                in_.fail(
                    text("type ", type, " of a marker's element; a surface has 5 (triangle) and 9 (quadrilateral)"));
            const int corners = type == vtk_triangle ? 3 : 4;
            std::array<int, 4> polygon{};
            for (int k = 0; k < corners; ++k) {
                const std::int64_t v = in_.integer(in_.word(), "point of an element");
                if (v < 0 || v > std::numeric_limits<int>::max())
                    in_.fail(text("point ", v, " of an element, limits 0 and 2147483647"));
                if (v > largest_) {  // the points may follow the markers
                    largest_ = v;
                    largest_line_ = in_.line();
                }
                polygon[static_cast<std::size_t>(k)] = static_cast<int>(v);
            }
            builder_.add_polygon({polygon.data(), static_cast<std::size_t>(corners)}, marker_);
        }
    }

    TextScanner in_;
    const std::string& name_;
    SurfaceBuilder builder_;
    int marker_ = -1;
    std::int64_t largest_ = -1;  ///< point that an element names, and where
    long largest_line_ = 0;
    bool points_read_ = false;
};

}  // namespace

SurfaceFile read_su2(std::string_view bytes, const std::string& name) { return Su2Reader(bytes, name).read(); }

std::string su2(const TriMesh& mesh) {
    std::string out = "NDIME= 3\nNELEM= 0\nNPOIN= " + std::to_string(mesh.num_vertices()) + "\n";
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        append_row(out, "", mesh.vertices.data() + 3 * v);
        out.back() = ' ';
        append(out, v);
        out += '\n';
    }
    const std::vector<std::vector<int>> parts = triangles_by_group(mesh);
    out += "NMARK= " + std::to_string(parts.size()) + "\n";
    for (std::size_t g = 0; g < parts.size(); ++g) {
        out += "MARKER_TAG= " + (mesh.group.empty() ? "surface" : one_word(mesh.group_names[g]));
        out += "\nMARKER_ELEMS= " + std::to_string(parts[g].size()) + "\n";
        for (const int t : parts[g]) append_row(out, "5 ", mesh.triangles.data() + 3 * t, 0);
    }
    return out;
}

}  // namespace strake::formats
