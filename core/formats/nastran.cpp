#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/text/file.hpp"
#include "core/text/text_scanner.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <optional>
#include <unordered_map>

/// NASTRAN bulk data: GRID and the shells CTRIA3, CTRIAR, CTRIA6, CQUAD4, CQUADR, CQUAD8 (corners), in fixed fields of
/// 8 or 16 columns or free fields. Groups are the property numbers. Other cards are skipped.
namespace strake::formats {
namespace {

constexpr std::size_t columns = 8, wide_columns = 16;

std::string_view trimmed(std::string_view s) {
    while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
    while (!s.empty() && (s.back() == ' ' || s.back() == '\t')) s.remove_suffix(1);
    return s;
}

/// A card with its continuations: fields after the name, each at most 16 characters.
struct Card {
    std::string name;
    std::vector<std::string_view> fields;
    std::string_view field(std::size_t i) const { return i < fields.size() ? fields[i] : std::string_view(); }
};

class NastranReader {
public:
    NastranReader(std::string_view bytes, const std::string& name)
        : in_(bytes, name, {.comment = '$', .continuation = false, .fortran = true}), name_(name) {
        TextScanner ahead = in_;
        while (!has_head_ && ahead.next_line()) has_head_ = begins_bulk(ahead.whole_line());
    }

    SurfaceFile read() {
        bool in_bulk = !has_head_;
        std::optional<std::string_view> line = next_line();
        while (line) {
            if (!in_bulk) {  // the executive and case control sections
                in_bulk = begins_bulk(*line);
                line = next_line();
                continue;
            }
            Card card;
            add_fields(*line, card);
            line = next_line();
            while (line && is_continuation(*line)) {
                add_fields(*line, card);
                line = next_line();
            }
            if (card.name == "ENDDATA") break;
            read_card(card);
        }
        resolve();
        SurfaceBuilder surface = builder_.with_used_vertices_only();
        return surface.finish(name_, SurfaceFormat::nastran);
    }

private:
    std::optional<std::string_view> next_line() {
        if (!in_.next_line()) return {};
        last_line_ = in_.line();
        const std::string_view line = in_.whole_line();  // its leading blanks are columns
        return line.substr(0, line.find('$'));
    }
    /// "BEGIN BULK", with any blanks and in any case.
    static bool begins_bulk(std::string_view line) {
        constexpr std::string_view begin = "BEGIN";
        line = trimmed(line).substr(0, begin.size());
        return std::equal(line.begin(), line.end(), begin.begin(), begin.end(),
                          [](char c, char upper) { return std::toupper(static_cast<unsigned char>(c)) == upper; });
    }
    static bool is_continuation(std::string_view line) {
        return line.front() == '+' || line.front() == '*' || line.front() == ',' ||
               trimmed(line.substr(0, columns)).empty();
    }
    /// A free field's first comma follows the name; a later one is a mistake in a fixed field.
    static bool is_free(std::string_view line) {
        const std::size_t comma = line.find(','), first = line.find_first_not_of(" \t");
        if (comma == line.npos) return false;
        return first < columns ? comma - first <= columns : comma == first;
    }
    static std::string name_in(std::string_view head) {
        if (head.ends_with('*')) head.remove_suffix(1);
        std::string name;
        for (const char c : trimmed(head)) name += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        return name;
    }
    /// Appends the fields of one line; the first line names the card, the others continue it.
    static void add_fields(std::string_view line, Card& card) {
        const bool free = is_free(line);
        const std::string_view head = trimmed(free ? line.substr(0, line.find(',')) : line.substr(0, columns));
        const bool is_wide = head.ends_with('*') || head.starts_with('*');
        if (card.name.empty()) card.name = name_in(head);
        const std::size_t count = is_wide ? 4 : 8, gap = free ? 1 : 0;
        std::size_t found = 0;
        std::string_view left = free ? line.substr(line.find(',') + 1)
                                     : (line.size() > columns ? line.substr(columns) : std::string_view());
        while (found < count && (free || !left.empty())) {
            const std::size_t width = free ? left.find(',') : (is_wide ? wide_columns : columns);
            card.fields.push_back(trimmed(left.substr(0, width)));
            ++found;
            if (width >= left.size()) break;
            left.remove_prefix(width + gap);
        }
        for (; found < count; ++found) card.fields.emplace_back();
    }

    void read_card(const Card& card) {
        if (card.name == "GRID") return read_grid(card);
        if (card.name == "INCLUDE" || card.name.starts_with("INCLUDE"))
            in_.fail_at(last_line_, "INCLUDE: other files are not opened; paste them in");
        for (const char* name : {"CTRIA3", "CTRIAR", "CTRIA6"})
            if (card.name == name) return read_shell(card, 3);
        for (const char* name : {"CQUAD4", "CQUADR", "CQUAD8"})
            if (card.name == name) return read_shell(card, 4);
    }

    void read_grid(const Card& card) {
        const std::int64_t id = integer(card.field(0), "number of a GRID");
        if (const auto cp = card.field(1); !cp.empty() && integer(cp, "coordinate system of a GRID") != 0)
            in_.fail_at(last_line_, text("GRID ", id, " is given in the coordinate system ", cp,
                                         "; only the basic one (0 or blank) is known here"));
        if (!vertex_.emplace(id, builder_.num_vertices()).second)
            in_.fail_at(last_line_, text("GRID ", id, " stands there twice"));
        for (std::size_t k = 2; k < 5; ++k)
            builder_.coordinates.push_back(card.field(k).empty() ? 0.0 : number(card.field(k), "coordinate of a GRID"));
    }
    void read_shell(const Card& card, std::size_t corners) {
        const std::int64_t id = integer(card.field(0), "number of an element");
        const std::int64_t property = card.field(1).empty() ? id : integer(card.field(1), "property of an element");
        Shell shell{{}, corners, builder_.group_number(std::to_string(property)), last_line_};
        for (std::size_t k = 0; k < corners; ++k) shell.corner[k] = integer(card.field(2 + k), "GRID of an element");
        shells_.push_back(shell);
    }
    /// Elements may precede their points.
    void resolve() {
        for (const Shell& shell : shells_) {
            std::array<int, 4> polygon{};
            for (std::size_t k = 0; k < shell.corners; ++k) {
                const auto at = vertex_.find(shell.corner[k]);
                if (at == vertex_.end())
                    in_.fail_at(shell.line,
                                text("an element names the GRID ", shell.corner[k], ", which the file does not have"));
                polygon[k] = at->second;
            }
            builder_.add_polygon({polygon.data(), shell.corners}, shell.group);
        }
    }

    std::int64_t integer(std::string_view field, std::string_view what) const {
        if (field.empty()) in_.fail_at(last_line_, text("expected ", what, ", got an empty field"));
        return in_.integer(field, what);
    }
    /// NASTRAN's notation: "1.5-3" is 1.5e-3.
    double number(std::string_view field, std::string_view what) const {
        std::string word(field);
        const std::size_t sign = word.find_last_of("+-");
        if (sign != word.npos && sign > 0 && std::isdigit(static_cast<unsigned char>(word[sign - 1])))
            word.insert(sign, 1, 'e');
        else if (sign != word.npos && sign > 0 && word[sign - 1] == '.')
            word.insert(sign, 1, 'e');
        return in_.number(word, what);
    }

    struct Shell {
        std::array<std::int64_t, 4> corner;
        std::size_t corners;
        int group;
        long line;
    };
    TextScanner in_;
    const std::string& name_;
    bool has_head_ = false;
    long last_line_ = 1;
    SurfaceBuilder builder_;
    std::unordered_map<std::int64_t, int> vertex_;  // only looked up
    std::vector<Shell> shells_;
};

/// As many digits as 16 columns hold.
std::string wide(double value) {
    char digits[48];
    std::string field;
    for (int precision = 17; precision > 0 && (field.empty() || field.size() > wide_columns); --precision) {
        const auto end =
            std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general, precision).ptr;
        field.assign(digits, end);
        if (const std::size_t e = field.find('e'); e != field.npos && field.find('.') > e) field.insert(e, 1, '.');
        if (field.find('.') == field.npos) field += '.';
    }
    field.resize(wide_columns, ' ');
    return field;
}

}  // namespace

SurfaceFile read_nastran(std::string_view bytes, const std::string& name) { return NastranReader(bytes, name).read(); }

std::string nastran(const TriMesh& mesh) {
    std::string out = "BEGIN BULK\n";
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        std::string number = std::to_string(v + 1);
        number.resize(2 * wide_columns, ' ');  // and a blank coordinate system
        out.append("GRID*   ").append(number);
        out.append(wide(mesh.vertices(v, 0))).append(wide(mesh.vertices(v, 1)));
        out.append("\n*       ").append(wide(mesh.vertices(v, 2))).append("\n");
    }
    const std::vector<std::string> numbers = component_numbers(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        out += "CTRIA3,";
        append(out, t + 1);
        out.append(",").append(mesh.group.empty() ? "1" : numbers[mesh.group[t]]);
        for (int k = 0; k < 3; ++k) {
            out += ',';
            append(out, mesh.triangles(t, k) + 1);
        }
        out += '\n';
    }
    return out + "ENDDATA\n";
}

}  // namespace strake::formats
