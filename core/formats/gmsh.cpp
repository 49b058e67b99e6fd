#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/text/raw_number.hpp"
#include "core/text/text_scanner.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <unordered_map>

/// Gmsh's .msh, versions 2.x and 4.1, text and binary: the elements of dimension 2 (of the second order: through all of
/// their nodes). Groups are physical names, else the numbers of physical groups or of surfaces.
namespace strake::formats {
namespace {

/// Meaning of Gmsh's element type numbers.
struct ElementType {
    int number, dimension, nodes;
    std::array<signed char, 12> triangles;  ///< corners, three each; -1: no more
};
constexpr int quadrilateral = 3;  ///< cut as the polygons of other formats
constexpr std::array<signed char, 12> nothing{-1};
constexpr ElementType element_types[] = {
    {1, 1, 2, nothing},   {2, 2, 3, {0, 1, 2, -1}}, {quadrilateral, 2, 4, nothing},
    {4, 3, 4, nothing},   {5, 3, 8, nothing},       {6, 3, 6, nothing},
    {7, 3, 5, nothing},   {8, 1, 3, nothing},       {9, 2, 6, {0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5}},
    {11, 3, 10, nothing}, {12, 3, 27, nothing},     {13, 3, 18, nothing},
    {14, 3, 14, nothing}, {15, 0, 1, nothing},      {17, 3, 20, nothing},
    {18, 3, 15, nothing}, {19, 3, 13, nothing},
};

/// Reads the numbers of a section in either encoding, text or bytes.
class GmshSource {
public:
    GmshSource(std::string_view bytes, const std::string& name, long first_line, bool binary, bool swap)
        : bytes_(bytes), name_(name), in_(bytes, name, {}, first_line), binary_(binary), swap_(swap) {}

    bool is_binary() const { return binary_; }
    std::int64_t integer(std::string_view what, std::size_t width) {
        if (!binary_) return in_.integer(in_.any_word(), what);
        return width == 4 ? get<std::int32_t>(what) : get<std::int64_t>(what);
    }
    double number(std::string_view what) {
        const double value = binary_ ? get<double>(what) : in_.number(in_.any_word(), what);
        if (!std::isfinite(value)) fail(text(what, " is not finite (", value, ")"));
        return value;
    }
    std::int64_t count(std::string_view what, std::size_t width, std::size_t bytes_each) {
        const std::int64_t n = integer(what, width);
        const std::size_t left = binary_ ? bytes_.size() - position_ : in_.bytes_left() + 1;
        if (n < 0 || n > std::numeric_limits<int>::max() || static_cast<std::uint64_t>(n) > left / bytes_each)
            fail(text(n, " as ", what, ": the ", left, " bytes that follow have no room for that"));
        return n;
    }
    void skip(std::int64_t numbers, std::size_t width, std::string_view what) {
        if (!binary_) {
            for (; numbers > 0; --numbers)
                if (in_.any_word().empty()) in_.unexpected({}, what);
        } else if (static_cast<std::uint64_t>(numbers) * width > bytes_.size() - position_) {
            fail(text("the section ends within ", what));
        } else {
            position_ += static_cast<std::size_t>(numbers) * width;
        }
    }
    [[noreturn]] void fail(const std::string& what) const {
        if (!binary_) in_.fail(what);
        throw InputError(text(name_, ": byte ", position_, " of the section: ", what));
    }

private:
    template <class T>
    T get(std::string_view what) {
        if (bytes_.size() - position_ < sizeof(T)) fail(text("the section ends before ", what));
        const T value = raw_number<T>(bytes_.data() + position_, swap_);
        position_ += sizeof(T);
        return value;
    }

    std::string_view bytes_;
    const std::string& name_;
    TextScanner in_;
    bool binary_, swap_;
    std::size_t position_ = 0;
};

const ElementType& type_of(std::int64_t number, const GmshSource& in) {
    for (const ElementType& type : element_types)
        if (type.number == number) return type;
    in.fail(
        text("element type ", number,
             " is unknown here; surfaces may have 2 (triangle), 3 (quadrilateral) and 9 (triangle of second order)"));
}

class GmshReader {
public:
    GmshReader(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

    SurfaceFile read() {
        while (next_section()) {
            if (section_ == "MeshFormat")
                read_format();
            else if (section_ == "PhysicalNames")
                read_names();
            else if (section_ == "Entities")
                read_entities(source());
            else if (section_ == "Nodes")
                version_ < 4 ? read_nodes_2(source()) : read_nodes_4(source());
            else if (section_ == "Elements")
                version_ < 4 ? read_elements_2(source()) : read_elements_4(source());
        }
        if (version_ == 0) throw InputError(text(name_, ": no $MeshFormat section"));
        SurfaceBuilder surface = builder_.with_used_vertices_only();
        return surface.finish(name_, SurfaceFormat::gmsh);
    }

private:
    long line_at(std::size_t position) const {
        return 1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(position), '\n');
    }
    [[noreturn]] void fail_at(std::size_t position, const std::string& what) const {
        throw InputError(text(name_, ":", line_at(position), ": ", what));
    }
    std::string_view line_from(std::size_t begin, std::size_t& next) const {
        const std::size_t end = std::min(bytes_.find('\n', begin), bytes_.size());
        next = std::min(end + 1, bytes_.size());
        std::string_view line = bytes_.substr(begin, end - begin);
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
        return line;
    }

    /// `$Name` ... `$EndName`; ignores text between sections.
    bool next_section() {
        while (position_ < bytes_.size()) {
            const std::size_t at = position_;
            const std::string_view line = line_from(at, position_);
            if (!line.starts_with('$')) continue;
            section_ = line.substr(1);
            begin_ = position_;
            const std::string end = "\n$End" + std::string(section_);
            const std::size_t found = bytes_.find(end, begin_ > 0 ? begin_ - 1 : 0);
            if (found == bytes_.npos) fail_at(at, text("$", printable_section(), " has no $End", printable_section()));
            content_ = bytes_.substr(begin_, found + 1 > begin_ ? found + 1 - begin_ : 0);
            position_ = found + end.size();
            return true;
        }
        return false;
    }
    std::string printable_section() const { return std::string(section_.substr(0, 40)); }
    GmshSource source() const {
        if (version_ == 0) fail_at(begin_, "the file does not begin with $MeshFormat");
        return GmshSource(content_, name_, line_at(begin_), binary_, swap_);
    }

    void read_format() {
        TextScanner in(content_, name_, {}, line_at(begin_));
        in.next_line();
        const double version = in.number(in.word(), "version");
        if (version != 4.1 && !(version >= 2 && version < 3))
            in.fail(text("version ", version, "; known are 2.x and 4.1 (gmsh -save -format msh41 writes it)"));
        version_ = version < 3 ? 2 : 4;
        const std::int64_t encoding = in.integer(in.word(), "0 (text) or 1 (binary)");
        if (encoding != 0 && encoding != 1) in.fail(text("encoding ", encoding, "; 0 is text, 1 is binary"));
        if (in.integer(in.word(), "size of a number") != 8) in.fail("numbers must have 8 bytes");
        binary_ = encoding == 1;
        if (!binary_) return;
        std::size_t next = 0;
        line_from(begin_, next);
        if (bytes_.size() - next < 4) in.fail("the file ends before the number that tells the order of its bytes");
        std::int32_t one = 0;
        std::memcpy(&one, bytes_.data() + next, 4);
        swap_ = one != 1;
        if (swap_ && one != 0x01000000) in.fail("the number that tells the order of the bytes is not 1");
    }

    void read_names() {
        TextScanner in(content_, name_, {}, line_at(begin_));
        for (std::int64_t n = in.integer(in.any_word(), "number of names"); n > 0; --n) {
            if (!in.next_line()) in.unexpected({}, "a physical name");
            const std::int64_t dimension = in.integer(in.word(), "dimension");
            const std::int64_t tag = in.integer(in.word(), "number of a physical group");
            std::string_view title = in.rest();
            if (title.size() < 2 || title.front() != '"' || title.back() != '"')
                in.fail("a name in quotes is expected");
            if (dimension == 2) physical_name_[tag] = title.substr(1, title.size() - 2);
        }
    }

    void read_entities(GmshSource in) {
        std::array<std::int64_t, 4> n{};
        for (auto& count : n) count = in.count("number of entities", 8, 4);
        for (int dimension = 0; dimension < 4; ++dimension)
            for (std::int64_t i = 0; i < n[static_cast<std::size_t>(dimension)]; ++i) {
                const std::int64_t tag = in.integer("number of an entity", 4);
                in.skip(dimension == 0 ? 3 : 6, 8, "the box of an entity");
                const std::int64_t physicals = in.count("number of physical groups", 8, 2);
                for (std::int64_t k = 0; k < physicals; ++k) {
                    const std::int64_t physical = in.integer("number of a physical group", 4);
                    if (dimension == 2 && k == 0) physical_of_surface_[tag] = std::abs(physical);
                }
                if (dimension > 0) in.skip(in.count("number of bounding entities", 8, 2), 4, "bounding entities");
            }
    }

    void add_node(std::int64_t tag, GmshSource& in) {
        if (!node_.emplace(tag, builder_.num_vertices()).second) in.fail(text("node ", tag, " stands there twice"));
        for (int k = 0; k < 3; ++k) builder_.coordinates.push_back(in.number("coordinate of a node"));
    }
    void read_nodes_2(GmshSource in) {
        // The count is text in binary files, too.
        std::size_t next = 0;
        const std::int64_t n = count_line(next);
        GmshSource nodes = in.is_binary() ? GmshSource(content_.substr(next), name_, 0, true, swap_) : in;
        if (!in.is_binary()) nodes.integer("number of nodes", 4);
        for (std::int64_t i = 0; i < n; ++i) {
            const std::int64_t tag = nodes.integer("number of a node", 4);
            add_node(tag, nodes);
        }
    }
    void read_nodes_4(GmshSource in) {
        const std::int64_t blocks = in.count("number of blocks", 8, 4);
        in.skip(3, 8, "the header of the nodes");
        std::vector<std::int64_t> tags;
        for (std::int64_t b = 0; b < blocks; ++b) {
            const std::int64_t dimension = in.integer("dimension", 4);
            in.skip(1, 4, "the entity of a block");
            const std::int64_t parametric = in.integer("0 or 1 for parameters", 4);
            const std::int64_t n = in.count("number of nodes", 8, 8);
            tags.clear();
            for (std::int64_t i = 0; i < n; ++i) tags.push_back(in.integer("number of a node", 8));
            for (const std::int64_t tag : tags) {
                add_node(tag, in);
                if (parametric) in.skip(std::clamp<std::int64_t>(dimension, 0, 2), 8, "parameters of a node");
            }
        }
    }

    std::int64_t count_line(std::size_t& next) {
        TextScanner in(content_, name_, {}, line_at(begin_));
        const std::int64_t n = in.integer(in.any_word(), "number of nodes or elements");
        in.check_room(n, 8, "nodes or elements");
        line_from(begin_, next);
        next -= begin_;
        return n;
    }
    void add_element(const ElementType& type, int group, const std::vector<std::int64_t>& nodes, const GmshSource& in) {
        std::array<int, 6> corner{};
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            const auto at = node_.find(nodes[k]);
            if (at == node_.end())
                in.fail(text("an element names the node ", nodes[k], ", which the file does not have"));
            corner[k] = at->second;
        }
        if (type.number == quadrilateral) return builder_.add_polygon({corner.data(), 4}, group);
        for (std::size_t k = 0; k + 2 < type.triangles.size() && type.triangles[k] >= 0; k += 3) {
            const auto c = [&](std::size_t i) { return corner[static_cast<std::size_t>(type.triangles[k + i])]; };
            const std::array<int, 3> triangle{c(0), c(1), c(2)};
            builder_.add_polygon(triangle, group);
        }
    }
    int group_of(std::int64_t physical, std::int64_t entity) {
        const auto named = physical_name_.find(physical);
        if (named != physical_name_.end()) return builder_.group_number(named->second);
        return builder_.group_number(std::to_string(physical != 0 ? physical : entity));
    }
    void read_elements_2(GmshSource in) {
        std::size_t next = 0;
        const std::int64_t n = count_line(next);
        GmshSource elements = in.is_binary() ? GmshSource(content_.substr(next), name_, 0, true, swap_) : in;
        if (!in.is_binary()) elements.integer("number of elements", 4);
        std::vector<std::int64_t> tags, nodes;
        for (std::int64_t i = 0; i < n;) {
            if (!in.is_binary()) elements.skip(1, 4, "the number of an element");
            const ElementType& type = type_of(elements.integer("type of an element", 4), elements);
            const std::int64_t together = in.is_binary() ? elements.count("number of elements", 4, 4) : 1;
            const std::int64_t num_tags = elements.count("number of tags", 4, 2);
            if (together < 1) elements.fail("a block without elements");
            for (std::int64_t e = 0; e < together; ++e, ++i) {
                if (in.is_binary()) elements.skip(1, 4, "the number of an element");
                read_list(elements, num_tags, 4, tags);
                read_list(elements, type.nodes, 4, nodes);
                if (type.dimension == 2)
                    add_element(type, group_of(num_tags > 0 ? tags[0] : 0, num_tags > 1 ? tags[1] : 0), nodes,
                                elements);
            }
        }
    }
    void read_elements_4(GmshSource in) {
        const std::int64_t blocks = in.count("number of blocks", 8, 4);
        in.skip(3, 8, "the header of the elements");
        std::vector<std::int64_t> nodes;
        for (std::int64_t b = 0; b < blocks; ++b) {
            in.skip(1, 4, "the dimension of a block");
            const std::int64_t entity = in.integer("entity of a block", 4);
            const ElementType& type = type_of(in.integer("type of the elements", 4), in);
            const std::int64_t n = in.count("number of elements", 8, 4);
            const auto physical = physical_of_surface_.find(entity);
            for (std::int64_t e = 0; e < n; ++e) {
                in.skip(1, 8, "the number of an element");
                read_list(in, type.nodes, 8, nodes);
                if (type.dimension == 2)
                    add_element(type, group_of(physical == physical_of_surface_.end() ? 0 : physical->second, entity),
                                nodes, in);
            }
        }
    }
    static void read_list(GmshSource& in, std::int64_t n, std::size_t width, std::vector<std::int64_t>& list) {
        list.clear();
        for (std::int64_t k = 0; k < n; ++k) list.push_back(in.integer("number of an element's node or tag", width));
    }

    std::string_view bytes_, section_, content_;
    const std::string& name_;
    std::size_t position_ = 0, begin_ = 0;
    int version_ = 0;
    bool binary_ = false, swap_ = false;
    SurfaceBuilder builder_;
    std::unordered_map<std::int64_t, int> node_;  // only looked up
    std::map<std::int64_t, std::string> physical_name_;
    std::map<std::int64_t, std::int64_t> physical_of_surface_;
};

}  // namespace

SurfaceFile read_gmsh(std::string_view bytes, const std::string& name) { return GmshReader(bytes, name).read(); }

std::string gmsh(const TriMesh& mesh) {
    const std::vector<std::vector<int>> parts = triangles_by_group(mesh);
    const std::string vertices = std::to_string(mesh.num_vertices()), triangles = std::to_string(mesh.num_triangles());
    std::string out = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", entities, elements;
    if (!mesh.group.empty()) {
        out += "$PhysicalNames\n" + std::to_string(parts.size()) + "\n";
        for (std::size_t g = 0; g < parts.size(); ++g) {
            std::string title = one_line(mesh.group_names[g]);
            std::replace(title.begin(), title.end(), '"', '\'');
            out += "2 " + std::to_string(g + 1) + " \"" + title + "\"\n";
        }
        out += "$EndPhysicalNames\n";
    }
    for (std::size_t g = 0; g < parts.size(); ++g)
        entities += text(g + 1, " 0 0 0 0 0 0 ", mesh.group.empty() ? "0" : text("1 ", g + 1), " 0\n");
    // A block for each run of triangles of one group, which keeps their order.
    int blocks = 0;
    for (int begin = 0, end = 0; begin < mesh.num_triangles(); begin = end, ++blocks) {
        const int group = mesh.group.empty() ? 0 : mesh.group[begin];
        while (end < mesh.num_triangles() && (mesh.group.empty() || mesh.group[end] == group)) ++end;
        elements += text("2 ", group + 1, " 2 ", end - begin, "\n");
        for (int t = begin; t < end; ++t)
            append_row(elements, std::to_string(t + 1) + " ", mesh.triangles.data() + 3 * t, 1);
    }
    out += "$Entities\n0 0 " + std::to_string(parts.size()) + " 0\n" + entities + "$EndEntities\n";
    out += "$Nodes\n1 " + vertices + " 1 " + vertices + "\n2 1 0 " + vertices + "\n";
    for (int v = 1; v <= mesh.num_vertices(); ++v) out += std::to_string(v) + "\n";
    for (int v = 0; v < mesh.num_vertices(); ++v) append_row(out, "", mesh.vertices.data() + 3 * v);
    out += "$EndNodes\n$Elements\n" + std::to_string(blocks) + " " + triangles + " 1 " + triangles + "\n";
    return out + elements + "$EndElements\n";
}

}  // namespace strake::formats
