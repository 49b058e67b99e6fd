#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/ply_header.hpp"
#include "core/text/text_scanner.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

/// PLY, text and both binary orders. Skips elements and properties that a surface does not need.
namespace strake::formats {
namespace {

/// Use of a property's values.
enum class Use { none, x, y, z, corners };

Use use_of(const PlyElement& element, const PlyProperty& property) {
    if (element.name == "vertex" && !property.is_list) {
        if (property.name == "x") return Use::x;
        if (property.name == "y") return Use::y;
        if (property.name == "z") return Use::z;
    }
    const bool corners = property.name == "vertex_indices" || property.name == "vertex_index";
    return element.name == "face" && property.is_list && corners ? Use::corners : Use::none;
}

/// Words of one line as the values of one element.
class TextSource {
public:
    TextSource(std::string_view bytes, const std::string& name, const PlyHeader& header)
        : in_(bytes.substr(header.bytes), name, {}, header.lines + 1) {}
    void begin(const PlyElement& element, std::int64_t i) {
        if (!in_.next_line()) in_.unexpected({}, text(element.name, " ", i, " of ", element.count));
    }
    double number(const PlyProperty& p, bool used) {
        return used ? in_.number(in_.word(), p.name) : in_.number_or_nan(in_.word(), p.name);
    }
    std::int64_t integer(PlyType, const PlyProperty& p) { return in_.integer(in_.word(), p.name); }
    void skip(const PlyProperty& p, std::int64_t count) {
        for (std::int64_t k = 0; k < count; ++k) in_.number_or_nan(in_.word(), p.name);
    }
    void end() {
        if (const auto w = in_.word(); !w.empty()) in_.unexpected(w, "the end of the line");
    }
    void end_of_file() {
        if (in_.next_line()) in_.unexpected(in_.word(), "the end of the file after the last element");
    }
    std::size_t bytes_left() const { return in_.bytes_left() + 1; }
    std::size_t min_bytes(PlyType) const { return 2; }
    [[noreturn]] void fail(const std::string& what) const { in_.fail(what); }

private:
    TextScanner in_;
};

/// Bytes in either order.
class BinarySource {
public:
    BinarySource(std::string_view bytes, const std::string& name, const PlyHeader& header)
        : bytes_(bytes), name_(name), swap_(header.encoding == PlyEncoding::big_endian), position_(header.bytes) {}
    void begin(const PlyElement& element, std::int64_t i) {
        element_ = &element;
        index_ = i;
    }
    double number(const PlyProperty& p, bool used) {
        const double value = scalar(p.type);
        if (used && !std::isfinite(value)) fail(text(p.name, " is not finite (", value, ")"));
        return value;
    }
    std::int64_t integer(PlyType type, const PlyProperty&) { return static_cast<std::int64_t>(scalar(type)); }
    void skip(const PlyProperty& p, std::int64_t count) {
        position_ += static_cast<std::size_t>(count) * size_of(p.type);
    }
    void end() {}
    void end_of_file() {
        const std::string_view rest = bytes_.substr(std::min(position_, bytes_.size()));
        if (rest.empty() || rest == "\n" || rest == "\r\n") return;
        throw InputError(text(name_, ": byte ", position_, ": ", rest.size(), " bytes follow the last element"));
    }
    std::size_t bytes_left() const { return bytes_.size() - std::min(position_, bytes_.size()); }
    std::size_t min_bytes(PlyType type) const { return size_of(type); }
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(
            text(name_, ": byte ", position_, " (", element_ ? element_->name : "element", " ", index_, "): ", what));
    }

private:
    template <class T>
    double take() {
        char raw[sizeof(T)];
        std::memcpy(raw, bytes_.data() + position_, sizeof(T));
        if (swap_) std::reverse(raw, raw + sizeof(T));
        position_ += sizeof(T);
        T value;
        std::memcpy(&value, raw, sizeof(T));
        return static_cast<double>(value);
    }
    /// Every type of PLY fits into a double.
    double scalar(PlyType type) {
        if (bytes_left() < size_of(type)) fail(text("the file ends here, ", element_->count, " elements announced"));
        switch (type) {
            case PlyType::int8:
                return take<std::int8_t>();
            case PlyType::uint8:
                return take<std::uint8_t>();
            case PlyType::int16:
                return take<std::int16_t>();
            case PlyType::uint16:
                return take<std::uint16_t>();
            case PlyType::int32:
                return take<std::int32_t>();
            case PlyType::uint32:
                return take<std::uint32_t>();
            case PlyType::float32:
                return take<float>();
            case PlyType::float64:
                return take<double>();
        }
        return 0;
    }
    std::string_view bytes_;
    std::string name_;
    bool swap_;
    std::size_t position_;
    const PlyElement* element_ = nullptr;
    std::int64_t index_ = 0;
};

template <class Source>
class PlyReader {
public:
    PlyReader(Source source, const PlyHeader& header) : in_(std::move(source)), header_(header) {
        for (const auto& element : header.elements)
            if (element.name == "vertex") num_vertices_ = element.count;
    }

    SurfaceFile read(const std::string& name, SurfaceFormat format) {
        for (const auto& element : header_.elements) read_element(element);
        in_.end_of_file();
        return builder_.finish(name, format);
    }

private:
    void read_element(const PlyElement& element) {
        std::size_t least = 0;
        for (const auto& p : element.properties) least += in_.min_bytes(p.is_list ? p.count_type : p.type);
        if (least == 0) return;  // no data, for any count
        if (static_cast<std::uint64_t>(element.count) > in_.bytes_left() / least)
            in_.fail(text("the header announces ", element.count, " elements '", element.name, "', the ",
                          in_.bytes_left(), " bytes that follow have room for at most ", in_.bytes_left() / least));
        std::vector<Use> uses;
        for (const auto& p : element.properties) uses.push_back(use_of(element, p));
        if (element.name == "vertex") builder_.coordinates.reserve(3 * static_cast<std::size_t>(element.count));
        for (std::int64_t i = 0; i < element.count; ++i) {
            in_.begin(element, i);
            for (std::size_t p = 0; p < uses.size(); ++p) read_property(element.properties[p], uses[p]);
            if (element.name == "vertex") builder_.coordinates.insert(builder_.coordinates.end(), xyz_, xyz_ + 3);
            in_.end();
        }
    }

    void read_property(const PlyProperty& p, Use use) {
        if (!p.is_list) {
            const double value = in_.number(p, use != Use::none);
            if (use != Use::none) xyz_[static_cast<int>(use) - static_cast<int>(Use::x)] = value;
            return;
        }
        const std::int64_t count = in_.integer(p.count_type, p);
        if (count < 0 || static_cast<std::uint64_t>(count) > in_.bytes_left() / in_.min_bytes(p.type))
            in_.fail(text("list '", p.name, "' of ", count, " values, the ", in_.bytes_left(),
                          " bytes that follow have no room for it"));
        if (use == Use::corners)
            read_face(p, count);
        else
            in_.skip(p, count);
    }

    void read_face(const PlyProperty& p, std::int64_t count) {
        if (count < 3) in_.fail(text("a face of ", count, " corners, at least 3 are needed"));
        polygon_.clear();
        for (std::int64_t k = 0; k < count; ++k) {
            const std::int64_t v = in_.integer(p.type, p);
            if (v < 0 || v >= num_vertices_)
                in_.fail(text("a corner of a face is vertex ", v, ", limits 0 and ", num_vertices_ - 1));
            polygon_.push_back(static_cast<int>(v));
        }
        builder_.add_polygon(polygon_);
    }

    Source in_;
    const PlyHeader& header_;
    SurfaceBuilder builder_;
    std::int64_t num_vertices_ = 0;
    double xyz_[3] = {0, 0, 0};
    std::vector<int> polygon_;
};

/// The header must describe a surface: positions and corners.
void check_surface(const PlyHeader& header, const std::string& name) {
    int positions = 0, corners = 0;
    for (const auto& element : header.elements)
        for (const auto& p : element.properties) {
            const Use use = use_of(element, p);
            positions += use == Use::x || use == Use::y || use == Use::z;
            corners += use == Use::corners;
            if (use == Use::corners && (p.type == PlyType::float32 || p.type == PlyType::float64))
                throw InputError(text(name, ":", p.line, ": vertex numbers of faces must be of a whole-number type"));
        }
    if (positions != 3)
        throw InputError(text(name, ":", header.lines, ": element 'vertex' with properties x, y and z expected"));
    if (corners != 1)
        throw InputError(text(name, ":", header.lines,
                              ": element 'face' with a list property 'vertex_indices' "
                              "expected",
                              header.has("tristrips") ? "; triangle strips are not read" : ""));
}

}  // namespace

SurfaceFile read_ply(std::string_view bytes, const std::string& name) {
    const PlyHeader header = read_ply_header(bytes, name);
    check_surface(header, name);
    if (header.encoding == PlyEncoding::ascii)
        return PlyReader<TextSource>(TextSource(bytes, name, header), header).read(name, SurfaceFormat::ply_ascii);
    return PlyReader<BinarySource>(BinarySource(bytes, name, header), header).read(name, SurfaceFormat::ply_binary);
}

std::string ply(const TriMesh& mesh, bool binary) {
    std::string out = "ply\nformat ";
    out += binary ? "binary_little_endian" : "ascii";
    out += " 1.0\nelement vertex ";
    append(out, mesh.num_vertices());
    out += "\nproperty double x\nproperty double y\nproperty double z\nelement face ";
    append(out, mesh.num_triangles());
    out += "\nproperty list uchar int vertex_indices\nend_header\n";
    if (binary) out.append(reinterpret_cast<const char*>(mesh.vertices.data()), 8 * mesh.vertices.size());
    for (int v = 0; v < mesh.num_vertices() && !binary; ++v) append_row(out, "", mesh.vertices.data() + 3 * v);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const int* row = mesh.triangles.data() + 3 * t;
        if (binary)
            (out += '\3').append(reinterpret_cast<const char*>(row), 12);
        else
            append_row(out, "3 ", row, 0);
    }
    return out;
}

}  // namespace strake::formats
