#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/weld.hpp"
#include "core/text/file.hpp"
#include "core/text/text_scanner.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

/// STL. Coordinates of the text form are read in double precision; the binary form is little-endian and single.
static_assert(std::endian::native == std::endian::little, "binary formats are read and written in native order");

namespace strake::formats {
namespace {

constexpr std::size_t header_bytes = 84, facet_bytes = 50;

bool same_word(std::string_view word, std::string_view lower) {
    if (word.size() != lower.size()) return false;
    for (std::size_t i = 0; i < word.size(); ++i)
        if ((word[i] | 0x20) != lower[i]) return false;
    return true;
}

/// Binary files may begin with "solid" too: the size decides, then an early zero byte.
bool is_binary(std::string_view bytes) {
    const std::size_t begin = bytes.find_first_not_of(" \t\r\n\v\f");
    if (begin == bytes.npos || !same_word(bytes.substr(begin, 5), "solid")) return true;
    std::uint32_t count = 0;
    if (bytes.size() < header_bytes) return bytes.find('\0') != bytes.npos;
    std::memcpy(&count, bytes.data() + 80, 4);
    if (bytes.size() == header_bytes + facet_bytes * std::uint64_t{count}) return true;
    return bytes.substr(0, 512).find('\0') != bytes.npos;
}

/// Triangles of single corners become a surface with shared vertices.
SurfaceFile weld_corners(SurfaceBuilder& builder, const std::string& name, SurfaceFormat format) {
    builder.corners.resize(builder.coordinates.size() / 3);
    for (std::size_t i = 0; i < builder.corners.size(); ++i) builder.corners[i] = static_cast<int>(i);
    SurfaceFile surface = builder.finish(name, format);
    std::vector<double>().swap(builder.coordinates);
    surface.mesh = welded(surface.mesh);
    return surface;
}

constexpr std::size_t block = 64;  ///< triangles per batch of prefetched table slots

/// Numbers corners in the order of first appearance, equal ones (0 and -0 are) alike: equal_points() for single
/// precision, while the corners are read.
class CornerWeld {
public:
    /// @param coordinates gets those of the vertices, three each. A surface has half as many of them as triangles.
    CornerWeld(std::size_t num_triangles, std::vector<double>& coordinates) : coordinates_(coordinates) {
        table_.resize(std::bit_ceil(num_triangles + 16));
        coordinates.reserve(3 * (num_triangles / 2 + 16));
    }

    void numbers(const float* corners, std::size_t count, int* number) {
        if (2 * (num_vertices_ + count) > table_.size()) grow();
        std::array<std::uint32_t, 3 * block> hashes;
        for (std::size_t i = 0; i < count; ++i) {
            hashes[i] = hash(corners + 3 * i);
            __builtin_prefetch(&table_[hashes[i] & (table_.size() - 1)]);
        }
        for (std::size_t i = 0; i < count; ++i) number[i] = number_of(corners + 3 * i, hashes[i]);
    }

private:
    struct Slot {
        std::uint32_t hash;
        std::int32_t vertex_plus_one;  ///< 0: free
    };

    static std::uint32_t hash(const float* p) {
        std::uint64_t h = 0;
        for (int k = 0; k < 3; ++k)  // adding 0 turns -0 into 0
            h = (h ^ std::bit_cast<std::uint32_t>(p[k] + 0.0F)) * 0x9E3779B97F4A7C15ull;
        h ^= h >> 32;
        return static_cast<std::uint32_t>((h * 0xD6E8FEB86659FD93ull) >> 32);
    }
    int number_of(const float* p, std::uint32_t h) {
        const std::size_t mask = table_.size() - 1;
        for (std::size_t at = h & mask;; at = (at + 1) & mask) {
            Slot& slot = table_[at];
            if (slot.vertex_plus_one == 0) {
                for (int k = 0; k < 3; ++k) coordinates_.push_back(static_cast<double>(p[k]));
                slot = {h, static_cast<std::int32_t>(++num_vertices_)};
                return slot.vertex_plus_one - 1;
            }
            if (slot.hash != h) continue;
            const double* known = coordinates_.data() + 3 * (static_cast<std::size_t>(slot.vertex_plus_one) - 1);
            if (known[0] == p[0] && known[1] == p[1] && known[2] == p[2]) return slot.vertex_plus_one - 1;
        }
    }
    void grow() {
        std::vector<Slot> old(2 * table_.size());
        std::swap(old, table_);
        const std::size_t mask = table_.size() - 1;
        for (const Slot& slot : old) {
            if (slot.vertex_plus_one == 0) continue;
            std::size_t at = slot.hash & mask;
            while (table_[at].vertex_plus_one != 0) at = (at + 1) & mask;
            table_[at] = slot;
        }
    }

    std::vector<double>& coordinates_;
    std::size_t num_vertices_ = 0;
    std::vector<Slot> table_;  ///< a power of two, never more than half full
};

SurfaceFile read_binary(std::string_view bytes, const std::string& name) {
    if (bytes.size() < header_bytes)
        throw InputError(text(name, ": byte ", bytes.size(), ": the file ends inside the header of ", header_bytes,
                              " bytes of a binary STL (and does not begin with 'solid')"));
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, 4);
    const std::uint64_t expected = header_bytes + facet_bytes * std::uint64_t{count};
    if (bytes.size() != expected)
        throw InputError(text(name, ": byte 80: the header announces ", count, " triangles, that is ", expected,
                              " bytes, the file has ", bytes.size()));
    if (count > static_cast<std::uint32_t>(std::numeric_limits<int>::max() / 3))
        throw InputError(text(name, ": byte 80: ", count, " triangles, at most 715827882 are possible"));
    SurfaceBuilder builder;
    CornerWeld weld(count, builder.coordinates);
    builder.corners.resize(3 * std::size_t{count});
    std::array<float, 3 * 3 * block> corners;
    for (std::size_t first = 0; first < count; first += block) {
        const std::size_t triangles = std::min<std::size_t>(block, count - first);
        for (std::size_t t = 0; t < triangles; ++t) {
            const std::size_t at = header_bytes + facet_bytes * (first + t) + 12;
            std::memcpy(corners.data() + 9 * t, bytes.data() + at, 36);
            for (std::size_t k = 0; k < 9; ++k)
                if (!std::isfinite(corners[9 * t + k]))
                    throw InputError(text(name, ": byte ", at + 4 * k, ": corner ", k / 3, " of triangle ", first + t,
                                          " is not finite (", corners[9 * t + k], ")"));
        }
        weld.numbers(corners.data(), 3 * triangles, builder.corners.data() + 3 * first);
    }
    SurfaceFile surface = builder.finish(name, SurfaceFormat::stl_binary);
    surface.file_vertices = static_cast<int>(3 * count);
    return surface;
}

void expect(TextScanner& in, std::string_view word) {
    const std::string_view found = in.any_word();
    if (!same_word(found, word)) in.unexpected(found, text("'", word, "'"));
}

void read_facet(TextScanner& in, SurfaceBuilder& builder) {
    expect(in, "normal");
    for (int k = 0; k < 3; ++k) in.number_or_nan(in.any_word(), "facet normal");
    expect(in, "outer");
    expect(in, "loop");
    for (int corner = 0; corner < 3; ++corner) {
        expect(in, "vertex");
        for (int k = 0; k < 3; ++k) builder.coordinates.push_back(in.number(in.any_word(), "coordinate of a vertex"));
    }
    expect(in, "endloop");
    expect(in, "endfacet");
}

/// Facets up to "endsolid".
void read_solid(TextScanner& in, SurfaceBuilder& builder, int group) {
    while (true) {
        const std::string_view word = in.any_word();
        if (same_word(word, "endsolid")) break;
        if (!same_word(word, "facet")) in.unexpected(word, "'facet' or 'endsolid'");
        read_facet(in, builder);
        builder.group.push_back(group);
    }
    in.rest();
}

SurfaceFile read_ascii(std::string_view bytes, const std::string& name) {
    TextScanner in(bytes, name, {});
    SurfaceBuilder builder;
    int solids = 0;
    bool named = false;
    for (std::string_view word = in.any_word(); !word.empty(); word = in.any_word()) {
        if (!same_word(word, "solid")) in.unexpected(word, "'solid'");
        std::string solid(in.rest());
        ++solids;
        named = named || !solid.empty();
        if (solid.empty()) solid = text("solid_", solids);
        read_solid(in, builder, builder.group_number(solid));
    }
    if (solids == 1 && !named) {
        builder.group.clear();
        builder.group_names.clear();
    }
    if (builder.coordinates.size() / 3 > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw InputError(
            text(name, ": ", builder.coordinates.size() / 9, " triangles, at most 715827882 are possible"));
    return weld_corners(builder, name, SurfaceFormat::stl_ascii);
}

Eigen::Vector3d unit_normal(const TriMesh& mesh, int t) {
    const Eigen::Vector3d s = area_vector(mesh, t);
    const double length = s.stableNorm();
    return length > 0 && std::isfinite(length) ? Eigen::Vector3d(s / length) : Eigen::Vector3d::Zero();
}

}  // namespace

SurfaceFile read_stl(std::string_view bytes, const std::string& name) {
    return is_binary(bytes) ? read_binary(bytes, name) : read_ascii(bytes, name);
}

std::string stl_binary(const TriMesh& mesh, const std::string& name) {
    std::string out = "binary STL";  // must not begin with "solid"
    out.resize(80, ' ');
    const auto count = static_cast<std::uint32_t>(mesh.num_triangles());
    out.reserve(header_bytes + facet_bytes * count);
    out.append(reinterpret_cast<const char*>(&count), 4);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        std::array<float, 12> facet;
        const Eigen::Vector3d n = unit_normal(mesh, t);
        for (int k = 0; k < 3; ++k) facet[k] = static_cast<float>(n[k]);
        for (int k = 0; k < 9; ++k) {
            const double x = mesh.vertices(mesh.triangles(t, k / 3), k % 3);
            if (std::abs(x) > std::numeric_limits<float>::max())
                throw OutputError(text(name, ": cannot write: vertex ", mesh.triangles(t, k / 3),
                                       " has the coordinate ", x, ", binary STL holds at most 3.4e38"));
            facet[3 + k] = static_cast<float>(x);
        }
        out.append(reinterpret_cast<const char*>(facet.data()), sizeof facet);
        out.append(2, '\0');
    }
    return out;
}

std::string stl_ascii(const TriMesh& mesh) {
    std::string out, solid;
    const auto bracket = [&](std::string_view keyword) {
        (out += keyword) += solid.empty() ? "" : " ";
        (out += solid) += '\n';
    };
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (t == 0 || (!mesh.group.empty() && mesh.group[t] != mesh.group[t - 1])) {
            if (t > 0) bracket("endsolid");
            solid = mesh.group.empty() ? std::string() : one_line(mesh.group_names[mesh.group[t]]);
            bracket("solid");
        }
        append_row(out, "facet normal ", unit_normal(mesh, t).data());
        out += "outer loop\n";
        for (int k = 0; k < 3; ++k) append_row(out, "vertex ", mesh.vertices.data() + 3 * mesh.triangles(t, k));
        out += "endloop\nendfacet\n";
    }
    if (mesh.num_triangles() == 0) bracket("solid");
    bracket("endsolid");
    return out;
}

}  // namespace strake::formats
