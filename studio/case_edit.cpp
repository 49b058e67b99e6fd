#include "studio/case_edit.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <map>

namespace strake {
namespace {

std::vector<std::string> names_in(const std::string& path) {
    std::vector<std::string> names;
    std::size_t from = 0;
    for (std::size_t dot; (dot = path.find('.', from)) != std::string::npos; from = dot + 1)
        names.push_back(path.substr(from, dot - from));
    names.push_back(path.substr(from));
    return names;
}

/// Byte of a 1-based line and column, which counts bytes.
std::size_t byte_at(const std::string& yaml, const Place& place) {
    std::size_t at = 0;
    for (int line = 1; line < place.line && at < yaml.size(); ++line) {
        const std::size_t end = yaml.find('\n', at);
        at = end == std::string::npos ? yaml.size() : end + 1;
    }
    return std::min(at + static_cast<std::size_t>(std::max(place.column, 1) - 1), yaml.size());
}

std::size_t line_begin(const std::string& yaml, std::size_t at) {
    const std::size_t end = at == 0 ? std::string::npos : yaml.rfind('\n', at - 1);
    return end == std::string::npos ? 0 : end + 1;
}
std::size_t line_end(const std::string& yaml, std::size_t at) { return std::min(yaml.find('\n', at), yaml.size()); }

std::string trimmed(const std::string& words) {
    const std::size_t first = words.find_first_not_of(" \t\r\n");
    if (first == std::string::npos) return "";
    return words.substr(first, words.find_last_not_of(" \t\r\n") - first + 1);
}

/// Behind a quoted scalar or a value in brackets that begins at `at`.
std::size_t behind_enclosed(const std::string& yaml, std::size_t at) {
    int depth = 0;
    for (; at < yaml.size(); ++at) {
        const char c = yaml[at];
        if (c == '\'' || c == '"') {
            for (++at; at < yaml.size() && yaml[at] != c; ++at)
                if (c == '"' && yaml[at] == '\\') ++at;
        } else if (c == '#' && at > 0 && (yaml[at - 1] == ' ' || yaml[at - 1] == '\n')) {
            at = line_end(yaml, at);
        } else if (c == '{' || c == '[') {
            ++depth;
        } else if (c == '}' || c == ']') {
            --depth;
        }
        if (depth <= 0) return std::min(at + 1, yaml.size());
    }
    return yaml.size();
}

/// Behind a value that begins on the line of its key.
std::size_t behind_value(const std::string& yaml, std::size_t at, bool in_flow) {
    if (at < yaml.size() && std::string("{['\"").find(yaml[at]) != std::string::npos) return behind_enclosed(yaml, at);
    std::size_t end = line_end(yaml, at);
    if (const std::size_t comment = yaml.find(" #", at > 0 ? at - 1 : 0); comment < end) end = comment;
    if (in_flow) end = std::min(end, yaml.find_first_of(",}]", at));
    while (end > at && (yaml[end - 1] == ' ' || yaml[end - 1] == '\t' || yaml[end - 1] == '\r')) --end;
    return end;
}

/// Behind the lines below a key that are indented more, or are items of its list.
std::size_t behind_block(const std::string& yaml, std::size_t key) {
    const std::size_t indent = key - line_begin(yaml, key);
    std::size_t end = line_end(yaml, key);
    for (std::size_t at = end + 1; at < yaml.size(); at = line_end(yaml, at) + 1) {
        const std::size_t first = yaml.find_first_not_of(' ', at);
        if (first == std::string::npos) break;
        if (yaml[first] == '\n' || yaml[first] == '#' || yaml[first] == '\r') continue;
        const bool is_item = first - at == indent && yaml.compare(first, 2, "- ") == 0;
        if (first - at <= indent && !is_item) break;
        end = line_end(yaml, at);
    }
    return end;
}

/// Begin of the comment lines directly above a line.
std::size_t above_comment(const std::string& yaml, std::size_t line) {
    while (line > 0) {
        const std::size_t before = line_begin(yaml, line - 1), first = yaml.find_first_not_of(" \t", before);
        if (first >= line || yaml[first] != '#') break;
        line = before;
    }
    return line;
}

std::string comment_words(const std::string& yaml, std::size_t from, std::size_t to) {
    std::string words;
    for (std::size_t at = from; at < to; at = line_end(yaml, at) + 1) {
        const std::size_t sign = yaml.find('#', at);
        if (sign >= std::min(line_end(yaml, at), to)) continue;
        const std::string one = trimmed(yaml.substr(sign + 1, std::min(line_end(yaml, at), to) - sign - 1));
        if (!one.empty()) words += (words.empty() ? "" : " ") + one;
    }
    return words;
}

EntrySpan span_of(const std::string& yaml, const Entry& entry, bool in_flow) {
    EntrySpan span;
    span.in_flow = in_flow;
    span.line = entry.key_place.line;
    span.key = byte_at(yaml, entry.key_place);
    const bool is_below = !in_flow && entry.value.place.line > entry.key_place.line;
    if (is_below) {
        const std::size_t colon = yaml.find(':', span.key);
        span.value = std::min(colon, yaml.size() - 1) + 1;
        span.end = behind_block(yaml, span.key);
    } else if (entry.value.null && entry.value.text.empty()) {
        span.value = span.end = std::min(yaml.find(':', span.key), yaml.size() - 1) + 1;
    } else {
        span.value = byte_at(yaml, entry.value.place);
        span.end = behind_value(yaml, span.value, in_flow);
    }
    span.words = trimmed(yaml.substr(span.value, span.end - span.value));
    if (in_flow) return span;
    const std::size_t line = line_begin(yaml, span.key);
    span.comment = comment_words(yaml, above_comment(yaml, line), line);
    if (!is_below) {
        const std::string behind = comment_words(yaml, span.end, line_end(yaml, span.end));
        if (!behind.empty()) span.comment = behind;
    }
    return span;
}

struct Found {
    const Entry* entry = nullptr;
    bool in_flow = false;
    std::size_t depth = 0;  ///< names that exist
    std::vector<const Entry*> above = {};
};

bool is_in_flow(const std::string& yaml, const Value& map) {
    const std::size_t at = byte_at(yaml, map.place);
    return at < yaml.size() && yaml[at] == '{';
}

Found find(const std::string& yaml, const Value& root, const std::vector<std::string>& names) {
    Found found;
    const Value* here = &root;
    for (const std::string& name : names) {
        if (here->form != Value::Form::map) break;
        const auto entry =
            std::find_if(here->entries.begin(), here->entries.end(), [&](const Entry& one) { return one.key == name; });
        found.in_flow = found.in_flow || is_in_flow(yaml, *here);
        if (entry == here->entries.end()) break;
        if (found.entry) found.above.push_back(found.entry);
        found.entry = &*entry;
        here = &entry->value;
        ++found.depth;
    }
    return found;
}

void flatten(const Value& value, const std::string& path, std::map<std::string, std::string>& flat) {
    if (value.form == Value::Form::scalar) flat[path] = (value.quoted ? "'" : value.null ? "~" : "") + value.text;
    for (std::size_t k = 0; k < value.entries.size(); ++k)
        flatten(value.entries[k].value,
                path + (value.form == Value::Form::map ? "." + value.entries[k].key : "[" + std::to_string(k) + "]"),
                flat);
}

/// All that does not lie at the path or, where something is removed, above it.
std::map<std::string, std::string> others(const std::string& yaml, const std::string& path) {
    std::map<std::string, std::string> flat;
    if (trimmed(yaml).empty()) return flat;
    flatten(parse_yaml(yaml, "case"), "", flat);
    const std::string own = "." + path;
    std::erase_if(flat, [&](const auto& one) {
        const std::string& key = one.first;
        const bool is_below =
            key.starts_with(own) && (key.size() == own.size() || key[own.size()] == '.' || key[own.size()] == '[');
        return is_below || own.starts_with(key + ".") || key.empty();
    });
    return flat;
}

/// "{budget: {evaluations: 60}}" of the names from `from` on.
std::string nested_in_flow(const std::vector<std::string>& names, std::size_t from, const std::string& value) {
    std::string words = value;
    for (std::size_t k = names.size(); k-- > from + 1;) words = "{" + names[k] + ": " + words + "}";
    return names[from] + ": " + words;
}

std::string nested_in_block(const std::vector<std::string>& names, std::size_t from, std::size_t indent,
                            const std::string& value) {
    std::string words;
    for (std::size_t k = from; k < names.size(); ++k, indent += 2)
        words += std::string(indent, ' ') + names[k] + ":" + (k + 1 < names.size() ? "\n" : " " + value + "\n");
    return words;
}

std::string with_new(std::string yaml, const Found& found, const std::vector<std::string>& names,
                     const std::string& value) {
    if (!yaml.empty() && yaml.back() != '\n') yaml += '\n';
    if (!found.entry) return yaml + nested_in_block(names, 0, 0, value);
    const Value& parent = found.entry->value;
    const EntrySpan span =
        span_of(yaml, *found.entry, !found.above.empty() && is_in_flow(yaml, found.above.back()->value));
    if (parent.form == Value::Form::map && is_in_flow(yaml, parent)) {
        const std::size_t close = span.end - 1;
        std::size_t before = close;
        while (before > 0 && std::string(" \t\n\r").find(yaml[before - 1]) != std::string::npos) --before;
        return yaml.insert(before, (parent.entries.empty() ? "" : ", ") + nested_in_flow(names, found.depth, value));
    }
    if (parent.form != Value::Form::map && !parent.null)
        throw InvalidInput(text(names[found.depth - 1], " is no map in this case: change it in the text"));
    std::size_t indent = span.key - line_begin(yaml, span.key) + 2, at = span.end;
    if (!parent.entries.empty()) {
        const std::size_t first = byte_at(yaml, parent.entries.front().key_place);
        indent = first - line_begin(yaml, first);
    }
    at = line_end(yaml, at);
    return yaml.insert(std::min(at + 1, yaml.size()), nested_in_block(names, found.depth, indent, value));
}

std::string without(std::string yaml, const EntrySpan& span) {
    if (!span.in_flow) {
        const std::size_t line = line_begin(yaml, span.key), from = above_comment(yaml, line);
        std::size_t end = std::min(line_end(yaml, span.end) + 1, yaml.size());
        const bool is_alone =
            (from == 0 || (from > 1 && yaml[from - 2] == '\n')) && end < yaml.size() && yaml[end] == '\n';
        return yaml.erase(from, end + (is_alone ? 1 : 0) - from);
    }
    std::size_t from = span.key, end = span.end;
    const std::size_t next = yaml.find_first_not_of(" \t\n", end);
    if (next != std::string::npos && yaml[next] == ',') {
        end = std::min(yaml.find_first_not_of(" ", next + 1), yaml.size());
    } else {
        const std::size_t before = yaml.find_last_not_of(" \t\n", from - 1);
        if (before != std::string::npos && yaml[before] == ',') from = before;
    }
    return yaml.erase(from, end - from);
}

std::vector<std::string> checked_names(const std::string& path) {
    auto names = names_in(path);
    for (const std::string& name : names)
        if (name.empty() || name.size() > 200 || name.find_first_of(" \t\n#:{}[],'\"&*!|>%@`") != std::string::npos)
            throw InvalidInput(text("'", printable(path), "' is no path of keys"));
    return names;
}

bool is_one_line(const std::string& value) {
    if (value.size() > 10000 || value.find('\n') != std::string::npos) return false;
    try {
        const Value read = parse_yaml("x: " + value + "\n", "value");
        return read.form == Value::Form::map && read.entries.size() == 1 && read.entries[0].key == "x" &&
               span_of("x: " + value + "\n", read.entries[0], false).words == value;
    } catch (const CaseError&) {
        return false;
    }
}

}  // namespace

Value case_map(const std::string& yaml) {
    Value empty;
    empty.form = Value::Form::map;
    return trimmed(yaml).empty() ? empty : parse_yaml(yaml, "case");
}

std::optional<EntrySpan> entry_span(const std::string& yaml, const std::string& path) {
    if (trimmed(yaml).empty()) return {};
    const Value root = parse_yaml(yaml, "case");
    const auto names = names_in(path);
    const Found found = find(yaml, root, names);
    if (found.depth < names.size()) return {};
    return span_of(yaml, *found.entry, found.in_flow);
}

std::string with_value(const std::string& yaml, const std::string& path, const std::string& asked) {
    const std::string value = trimmed(asked);
    const auto names = checked_names(path);
    if (!value.empty() && !is_one_line(value))
        throw InvalidInput(text("'", printable(value), "' is no value of a case in one line"));
    const Value root = case_map(yaml);
    const Found found = find(yaml, root, names);
    std::string made = yaml;
    if (found.depth == names.size()) {
        const EntrySpan span = span_of(yaml, *found.entry, found.in_flow);
        if (!value.empty()) {
            const bool needs_blank = span.value > 0 && yaml[span.value - 1] == ':';
            made.replace(span.value, span.end - span.value, (needs_blank ? " " : "") + value);
        } else if (!found.above.empty() && found.above.back()->value.entries.size() == 1) {
            return with_value(yaml, path.substr(0, path.rfind('.')), "");
        } else {
            made = without(yaml, span);
        }
    } else if (!value.empty()) {
        made = with_new(yaml, found, names, value);
    }
    const auto now = made == yaml || trimmed(made).empty() ? std::optional<EntrySpan>{} : entry_span(made, path);
    const bool is_kept = made == yaml || others(made, path) == others(yaml, path);
    const bool is_set = made == yaml || (value.empty() ? !now : now && now->words == value);
    if (!is_kept || !is_set)
        throw InvalidInput(text(path, " is written in a way that cannot be changed here: change it in the text"));
    return made;
}

}  // namespace strake
