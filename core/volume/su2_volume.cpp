#include "core/error.hpp"
#include "core/text/file.hpp"
#include "core/text/text_scanner.hpp"
#include "core/volume/cell_check.hpp"
#include "core/volume/volume_file.hpp"

#include <array>

/// SU2's native mesh with its volume elements. Scans the file and replaces only the coordinates.
namespace strake::volume_formats {
namespace {

constexpr TextScanner::Syntax syntax{.comment = '%', .continuation = false, .fortran = false};

std::string_view trimmed(std::string_view s) {
    const std::size_t begin = s.find_first_not_of(" \t\r"), end = s.find_last_not_of(" \t\r");
    return begin == s.npos ? std::string_view() : s.substr(begin, end - begin + 1);
}

class Reader {
public:
    Reader(VolumeFile& out) : out_(out), in_(out.bytes, out.name, syntax) {}

    void read() {
        while (in_.next_line()) {
            const std::string_view line = in_.rest();
            const std::size_t sign = line.find('=');
            if (sign == line.npos) continue;
            const std::string_view value = line.substr(sign + 1, line.find('%', sign) - sign - 1);
            read_setting(trimmed(line.substr(0, sign)), trimmed(value));
        }
        if (out_.places.empty()) throw InputError(text(out_.name, ": no NPOIN=, so there are no points"));
        out_.mesh.points = Eigen::Map<const Points>(at_.data(), static_cast<Eigen::Index>(out_.places.size()), 3);
        check_corners(out_.mesh, out_.name);
        orient_by_majority(out_.mesh, kinds_);
    }

private:
    void read_setting(std::string_view key, std::string_view value) {
        if (key == "NZONE" && count(value) != 1) in_.fail("NZONE= : a mesh of one zone is needed");
        if (key == "NDIME" && count(value) != 3) in_.fail("NDIME= : a mesh of 3 dimensions is needed");
        if (key == "NELEM") elements(count(value));
        if (key == "NPOIN") points(count(value));
        if (key == "MARKER_TAG") out_.mesh.boundary.push_back({std::string(value), {}});
        if (key == "MARKER_ELEMS") marker(count(value));
    }
    std::int64_t count(std::string_view value) {
        const std::int64_t n = in_.integer(value.substr(0, value.find_first_of(" \t")), "a count");
        in_.check_room(n, 2, "entries");
        return n;
    }
    void line(std::string_view what) {
        if (!in_.next_line()) in_.unexpected({}, what);
    }
    int label(std::string_view what) {
        const std::int64_t v = in_.integer(in_.word(), what);
        if (v < 0 || v > 1'000'000'000) in_.fail(text(what, " ", v, " is out of range"));
        return static_cast<int>(v);
    }
    void elements(std::int64_t n) {
        std::array<int, 27> corners{};
        for (std::int64_t i = 0; i < n; ++i) {
            line("volume element");
            const int kind = label("type of an element"), m = num_corners(kind);
            for (int k = 0; k < m; ++k) corners[static_cast<std::size_t>(k)] = label("point of an element");
            add_cell(out_.mesh, kind, {corners.data(), static_cast<std::size_t>(m)}, kinds_);
        }
    }
    void points(std::int64_t n) {
        if (!out_.places.empty()) in_.fail("a second NPOIN=");
        for (std::int64_t v = 0; v < n; ++v) {
            line("point");
            std::pair<std::size_t, std::size_t> place;
            for (int k = 0; k < 3; ++k) {
                const std::string_view word = in_.word();
                at_.push_back(in_.number(word, "coordinate of a point"));
                if (k == 0) place.first = static_cast<std::size_t>(word.data() - out_.bytes.data());
                place.second = static_cast<std::size_t>(word.data() - out_.bytes.data()) + word.size();
            }
            out_.places.push_back(place);
        }
    }
    void marker(std::int64_t n) {
        if (out_.mesh.boundary.empty()) in_.fail("MARKER_ELEMS= without a MARKER_TAG= before it");
        for (std::int64_t i = 0; i < n; ++i) {
            line("element of a marker");
            const int kind = label("type of an element"), m = kind == 5 ? 3 : kind == 9 ? 4 : 0;
            std::array<int, 4> corners{};
            for (int k = 0; k < m; ++k) corners[static_cast<std::size_t>(k)] = label("point of an element");
            if (m > 0) out_.mesh.boundary.back().faces.add({corners.data(), static_cast<std::size_t>(m)});
        }
    }

    VolumeFile& out_;
    TextScanner in_;
    std::vector<double> at_;
    std::vector<int> kinds_;
};

}  // namespace

VolumeFile read_su2(std::string bytes, const std::string& name) {
    VolumeFile out;
    out.format = VolumeFormat::su2;
    out.bytes = std::move(bytes);
    out.name = name;
    Reader(out).read();
    return out;
}

}  // namespace strake::volume_formats
