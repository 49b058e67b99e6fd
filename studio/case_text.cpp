#include "studio/case_text.hpp"

#include "casefile/yaml/value.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <optional>

namespace strake {
namespace {

using Lines = std::vector<std::string>;

Lines lines_of(const std::string& yaml) {
    Lines lines;
    std::size_t from = 0;
    for (std::size_t end; (end = yaml.find('\n', from)) != std::string::npos; from = end + 1)
        lines.push_back(yaml.substr(from, end - from));
    if (from < yaml.size()) lines.push_back(yaml.substr(from));
    return lines;
}

std::string text_of(const Lines& lines) {
    std::string yaml;
    for (const std::string& line : lines) yaml += line + "\n";
    return yaml;
}

std::size_t indent_of(const std::string& line) { return std::min(line.find_first_not_of(' '), line.size()); }
bool is_empty(const std::string& line) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    return first == std::string::npos || line[first] == '#';
}
bool begins_with_key(const std::string& line, const std::string& key) {
    const std::size_t at = indent_of(line);
    if (line.compare(at, key.size(), key) == 0 && line.compare(at + key.size(), 1, ":") == 0) return true;
    const std::string quoted = '"' + key + '"';
    return line.compare(at, quoted.size(), quoted) == 0 && line.compare(at + quoted.size(), 1, ":") == 0;
}

struct Block {
    std::size_t first, end;  ///< its key's line; behind its last line that is not empty
};

std::optional<Block> find_block(const Lines& lines, const std::string& key) {
    for (std::size_t k = 0; k < lines.size(); ++k) {
        if (indent_of(lines[k]) != 0 || !begins_with_key(lines[k], key)) continue;
        std::size_t end = k + 1;
        for (std::size_t next = k + 1; next < lines.size(); ++next) {
            if (is_empty(lines[next])) continue;
            const bool is_item = lines[next].starts_with("- ");  // of a list that is not indented
            const bool closes = lines[next].starts_with("}") || lines[next].starts_with("]");
            if (indent_of(lines[next]) == 0 && !is_item && !closes) break;
            end = next + 1;
        }
        return Block{k, end};
    }
    return {};
}

/// What stands behind the colon of a key's line, without a comment and blanks.
std::string rest_of(const std::string& line) {
    std::string rest = line.substr(line.find(':') + 1);
    if (const std::size_t comment = rest.find(" #"); comment != std::string::npos) rest.resize(comment);
    const std::size_t first = rest.find_first_not_of(" \t\r");
    if (first == std::string::npos) return "";
    return rest.substr(first, rest.find_last_not_of(" \t\r") - first + 1);
}

/// Puts words in front of the last closing bracket of a block in flow style.
void add_in_flow(Lines& lines, const Block& block, char open, char close, const std::string& words) {
    for (std::size_t k = block.end; k-- > block.first;) {
        std::string& line = lines[k];
        const std::size_t comment = std::min(line.find(" #"), line.size());
        const std::size_t at = line.rfind(close, comment);
        if (at == std::string::npos || at >= comment) continue;
        const std::size_t before = line.find_last_not_of(" \t", at - 1);
        const bool is_first = before != std::string::npos && line[before] == open;
        line.insert(before == std::string::npos ? at : before + 1, (is_first ? "" : ", ") + words);
        return;
    }
}

/// Where a new top-level block stands: behind these, or at the end.
std::size_t place_behind(const Lines& lines, const std::vector<std::string>& keys) {
    for (const std::string& key : keys)
        if (const auto block = find_block(lines, key)) return block->end;
    return lines.size();
}

void insert(Lines& lines, std::size_t at, const Lines& what) {
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(at), what.begin(), what.end());
}

void replace_entry(Lines& lines, const Block& block, std::size_t at, std::size_t indent, const std::string& line) {
    std::size_t end = at + 1;
    while (end < block.end && (is_empty(lines[end]) ? false : indent_of(lines[end]) > indent)) ++end;
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(at), lines.begin() + static_cast<std::ptrdiff_t>(end));
    insert(lines, at, {line});
}

bool is_plain(const std::string& name) {
    return std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-';
    });
}

}  // namespace

std::string region_line(const RegionText& region) {
    return region.name + ": " + (region.is_formula ? region.value : "{" + region.value + "}");
}

std::string with_region(const std::string& yaml, const RegionText& region) {
    if (region.name.empty() || region.name.size() > 60 || !is_plain(region.name) || region.name == "all")
        throw InvalidInput("a region's name is made of letters, digits, _ and -, at most 60, and is not 'all'");
    Lines lines = lines_of(yaml);
    const auto block = find_block(lines, "regions");
    const std::string entry = region_line(region);
    if (!block) {
        insert(lines, place_behind(lines, {"symmetry", "axes", "remesh", "repair", "surface", "case"}),
               {"", "regions:", "  " + entry});
        return text_of(lines);
    }
    const std::string rest = rest_of(lines[block->first]);
    if (rest.starts_with('{')) {
        for (std::size_t k = block->first; k < block->end; ++k)
            if (lines[k].find(region.name + ":") != std::string::npos)
                throw InvalidInput(text("the case writes regions: {...} in braces and has '", region.name,
                                        "' already: choose another name, or remove it there first"));
        add_in_flow(lines, *block, '{', '}', entry);
        return text_of(lines);
    }
    if (!rest.empty()) throw InvalidInput("regions: is followed by something else than a map; mend that first");
    std::size_t indent = 2;
    for (std::size_t k = block->first + 1; k < block->end; ++k)
        if (!is_empty(lines[k])) {
            indent = indent_of(lines[k]);
            break;
        }
    const std::string line = std::string(indent, ' ') + entry;
    for (std::size_t k = block->first + 1; k < block->end; ++k)
        if (!is_empty(lines[k]) && indent_of(lines[k]) == indent && begins_with_key(lines[k], region.name)) {
            replace_entry(lines, *block, k, indent, line);
            return text_of(lines);
        }
    insert(lines, block->end, {line});
    return text_of(lines);
}

std::string with_fixed(const std::string& yaml, const std::string& name) {
    Lines lines = lines_of(yaml);
    const auto block = find_block(lines, "fixed");
    if (!block) {
        insert(lines, place_behind(lines, {"regions"}), {"fixed: [" + name + "]"});
        return text_of(lines);
    }
    for (const Entry& key : parse_yaml(yaml, "case").entries)
        if (key.key == "fixed")
            for (const Entry& item : key.value.entries)
                if (item.value.text == name) return yaml;
    const std::string rest = rest_of(lines[block->first]);
    if (rest.starts_with('[')) {
        add_in_flow(lines, *block, '[', ']', name);
    } else if (rest.empty()) {
        std::size_t indent = 2;
        for (std::size_t k = block->first + 1; k < block->end; ++k)
            if (!is_empty(lines[k])) indent = indent_of(lines[k]);
        insert(lines, block->end, {std::string(indent, ' ') + "- " + name});
    } else {
        throw InvalidInput("fixed: is followed by something else than a list; mend that first");
    }
    return text_of(lines);
}

std::string block_of(const std::string& yaml, const std::string& key) {
    const Lines lines = lines_of(yaml);
    const auto block = find_block(lines, key);
    if (!block) return "";
    return text_of({lines.begin() + static_cast<std::ptrdiff_t>(block->first),
                    lines.begin() + static_cast<std::ptrdiff_t>(block->end)});
}

}  // namespace strake
