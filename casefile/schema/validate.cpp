#include "casefile/schema/scalars.hpp"

#include <algorithm>
#include <map>

namespace strake {
namespace {

const char* described(Type type) {
    switch (type) {
        case Type::map:
            return "a map";
        case Type::list:
            return "a list";
        case Type::name:
            return "a name";
        case Type::word:
            return "a word";
        case Type::flag:
            return "true or false";
        case Type::integer:
            return "an integer";
        case Type::number:
            return "a number";
        case Type::fraction:
            return "a number or a percentage";
        case Type::length:
            return "a length";
        case Type::coordinate:
            return "a coordinate";
        case Type::angle:
            return "an angle";
        case Type::number_or_angle:
            return "a number or an angle";
        case Type::duration:
            return "a time";
        case Type::file:
            return "a file";
        case Type::path:
            return "a path";
        case Type::text:
            return "text";
    }
    return "a value";
}

Value::Form form_of(Type type) {
    return type == Type::map ? Value::Form::map : type == Type::list ? Value::Form::list : Value::Form::scalar;
}

std::string expected(const std::vector<const Key*>& rows) {
    std::vector<std::string> forms;
    for (const Key* row : rows) forms.push_back(described(row->type));
    return joined(forms, " or ");
}

const Value* raw_child(const Value& map, const std::string& key) {
    for (const Entry& entry : map.entries)
        if (entry.key == key) return &entry.value;
    return nullptr;
}

class Validator {
public:
    Validator(const ScalarContext& context, Diagnostics& errors) : context_(context), errors_(errors) {}

    /// @param pattern the table's path; @param shown the path in messages
    void node(Value& value, const std::string& pattern, const std::string& shown) {
        const auto& rows = schema_index().rows.at(pattern);
        if (value.null) {
            errors_.add(value.place, text(shown, " has no value; it must be ", expected(rows)));
            return;
        }
        for (const Key* row : rows)
            if (form_of(row->type) == value.form) {
                if (value.form == Value::Form::map) map(value, *row, pattern, shown);
                if (value.form == Value::Form::list) list(value, *row, pattern, shown);
                if (value.form == Value::Form::scalar) scalar(value, row->type, *row, shown);
                return;
            }
        wrong_form(value, rows, shown);
    }

    void map(Value& value, const Key& row, const std::string& pattern, const std::string& shown) {
        value.accepted = &row;
        report_duplicates(value, shown);
        const auto found = schema_index().children.find(pattern);
        if (found == schema_index().children.end()) return;
        const std::vector<std::string>& names = found->second;
        for (const std::string& name : names)
            if (name != "*") child(value, name, pattern, shown);
        const bool any = std::find(names.begin(), names.end(), "*") != names.end();
        for (Entry& entry : value.entries) {
            if (std::find(names.begin(), names.end(), entry.key) != names.end() && entry.key != "*") continue;
            if (any)
                named(entry, pattern, shown);
            else
                unknown(entry, names, shown);
        }
    }

private:
    const ScalarContext& context_;
    Diagnostics& errors_;

    static std::string below(const std::string& path, const std::string& name) {
        return path.empty() ? name : path + "." + name;
    }

    /// Words of a command line or of a list without brackets; quotes hold words together if each has its other.
    static std::vector<std::string> words_of(const std::string& line) {
        const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
        const bool has_spaces = std::any_of(line.begin(), line.end(), is_space);
        std::vector<std::string> words;
        std::string word;
        char quote = 0;
        bool is_word = false;
        for (std::size_t k = 0; k < line.size(); ++k) {
            const char c = line[k];
            const bool is_comma = c == ',' && (!has_spaces || k + 1 == line.size() || is_space(line[k + 1]));
            const bool begins_quote = (c == '"' || c == '\'') && !quote && line.find(c, k + 1) != std::string::npos;
            if (begins_quote || (quote && c == quote)) {
                quote = begins_quote ? c : 0;
                is_word = true;
            } else if (!quote && (is_space(c) || is_comma)) {
                if (is_word) words.push_back(word);
                word.clear();
                is_word = false;
            } else {
                word += c;
                is_word = true;
            }
        }
        if (is_word) words.push_back(word);
        return words;
    }

    /// "python3 {case_dir}/solve.py" as [python3, "{case_dir}/solve.py"]: what a user meant who forgot the brackets.
    static std::string list_of_words(const std::string& line) {
        std::string list;
        for (const std::string& word : words_of(line)) {
            const std::string shown = printable(word);
            const bool is_plain = !word.empty() && word.find_first_of(" {}[],:#&*!|>'\"%@`\\") == std::string::npos;
            const bool has_marks = word.find_first_of("\"\\") != std::string::npos;
            if (!list.empty()) list += ", ";
            if (is_plain)
                list += shown;
            else
                list += has_marks && word.find('\'') == std::string::npos ? "'" + shown + "'" : '"' + shown + '"';
        }
        return list;
    }

    void wrong_form(const Value& value, const std::vector<const Key*>& rows, const std::string& shown) {
        const bool wants_list = rows.size() == 1 && rows[0]->type == Type::list;
        std::string got = value.form == Value::Form::map ? "a map" : "a list";
        if (value.form == Value::Form::scalar) got = text("'", printable(value.text), "'");
        const std::string hint =
            wants_list && value.form == Value::Form::scalar && rows[0]->count == 0 && !value.text.empty()
                ? text("; write [", list_of_words(value.text), "]")
                : "";
        errors_.add(value.place, text(shown, " must be ", expected(rows), ", got ", got, hint));
    }

    void report_duplicates(Value& value, const std::string& shown) {
        std::map<std::string, Place> first;
        std::vector<Entry> kept;
        for (Entry& entry : value.entries) {
            const auto [known, is_new] = first.emplace(entry.key, entry.key_place);
            if (is_new)
                kept.push_back(std::move(entry));
            else
                errors_.add(entry.key_place,
                            text("key '", printable(entry.key), "' given twice", shown.empty() ? "" : " in " + shown,
                                 " (first on ", line_words(known->second), ")"));
        }
        value.entries = std::move(kept);
    }

    /// Key::when against the siblings; a refused sibling decides nothing.
    static bool holds(const std::string& when, const Value& map, bool if_refused) {
        if (when.empty()) return true;
        const Condition condition = parse_condition(when);
        if (condition.kind == Condition::Kind::present)
            return std::any_of(condition.words.begin(), condition.words.end(),
                               [&](const std::string& key) { return raw_child(map, key) != nullptr; });
        const Value* sibling = raw_child(map, condition.key);
        if (!sibling) return false;
        if (!sibling->accepted) return if_refused;
        const auto has_word = [&](const Value& value) {
            return std::find(condition.words.begin(), condition.words.end(), value.text) != condition.words.end();
        };
        if (condition.kind == Condition::Kind::is_list) return sibling->form == Value::Form::list;
        if (condition.kind == Condition::Kind::is_word)
            return sibling->form == Value::Form::scalar && has_word(*sibling);
        return std::any_of(sibling->entries.begin(), sibling->entries.end(),
                           [&](const Entry& entry) { return has_word(entry.value); });
    }

    static std::string condition_words(const std::string& when) {
        const Condition condition = parse_condition(when);
        if (condition.kind == Condition::Kind::present) return text("'", joined(condition.words, "' or '"), "'");
        if (condition.kind == Condition::Kind::is_list) return text("a list of '", condition.key, "'");
        const bool in_list = condition.kind == Condition::Kind::holds_word;
        return text("'", condition.key, ": ", in_list ? "[" : "", joined(condition.words, " or "), in_list ? "]" : "",
                    "'");
    }

    void child(Value& map, const std::string& name, const std::string& pattern, const std::string& shown) {
        const std::string path = below(pattern, name), shown_path = below(shown, name);
        const Key& row = *schema_index().rows.at(path).front();
        for (Entry& entry : map.entries)
            if (entry.key == name) {
                if (!holds(row.when, map, true))
                    errors_.add(entry.key_place, text(shown_path, " is only allowed with ", condition_words(row.when)));
                else
                    node(entry.value, path, shown_path);
                return;
            }
        const bool is_needed = row.required ? holds(row.when, map, false)
                                            : !row.required_when.empty() && holds(row.required_when, map, false);
        if (is_needed)
            errors_.add(map.place, text(shown_path, " is missing"));
        else if (!row.fallback.empty() && holds(row.when, map, false))
            add_default(map, row, name, path, shown_path);
    }

    void add_default(Value& map, const Key& row, const std::string& name, const std::string& path,
                     const std::string& shown) {
        Entry entry{name, map.place, parse_yaml(row.fallback, "default of " + row.path)};
        entry.value.place = map.place;
        entry.value.from_default = true;
        node(entry.value, path, shown);
        map.entries.push_back(std::move(entry));
    }

    void named(Entry& entry, const std::string& pattern, const std::string& shown) {
        const std::string shown_path = below(shown, printable(entry.key));
        Value name;
        name.text = entry.key;
        if (pattern == "regions" || pattern == "planform" || pattern == "quantities" || pattern == "variables") {
            const std::string error = convert_scalar(name, Type::name, Key{}, context_);
            if (!error.empty()) errors_.add(entry.key_place, text(shown_path, " ", error));
        }
        node(entry.value, below(pattern, "*"), shown_path);
    }

    void unknown(const Entry& entry, const std::vector<std::string>& names, const std::string& shown) {
        const std::string in = shown.empty() ? "" : " in " + shown;
        const std::string key = printable(entry.key);
        if (entry.value.null && !key.empty() && key.find_first_not_of("0123456789") == std::string::npos) {
            errors_.add(entry.key_place,
                        text("unknown key '", key, "'", in, "; numbers take a decimal point, no comma"));
            return;
        }
        const std::string near = nearest(entry.key, names);
        const std::string hint = near.empty() ? text("; keys: ", joined(names)) : text("; did you mean '", near, "'?");
        errors_.add(entry.key_place, text("unknown key '", key, "'", in, hint));
    }

    void list(Value& value, const Key& row, const std::string& pattern, const std::string& shown) {
        const int count = static_cast<int>(value.entries.size());
        if (row.count > 0 && count != row.count) {
            errors_.add(value.place, text(shown, " must have ", row.count, " entries, got ", count));
            return;
        }
        if (count == 0 && !row.may_be_empty) {
            errors_.add(value.place, text(shown, " must not be empty"));
            return;
        }
        value.accepted = &row;
        const bool has_rows = schema_index().rows.count(pattern + "[]") > 0;
        for (int i = 0; i < count; ++i) {
            Value& element = value.entries[i].value;
            const std::string element_shown = text(shown, "[", i, "]");
            if (has_rows)
                node(element, pattern + "[]", element_shown);
            else if (element.form != Value::Form::scalar || element.null)
                errors_.add(element.place, text(element_shown, " must be ", described(row.element)));
            else
                scalar(element, row.element, row, element_shown);
        }
    }

    void scalar(Value& value, Type type, const Key& row, const std::string& shown) {
        const std::string error = convert_scalar(value, type, row, context_);
        if (error.empty())
            value.accepted = &row;
        else
            errors_.add(value.place, text(shown, " = ", printable(value.text), " ", error));
    }
};

}  // namespace

void validate(Value& root, const std::filesystem::path& case_dir, Diagnostics& errors) {
    static const Key root_row{};
    if (root.form != Value::Form::map) {
        errors.add(root.place, "a case must be a map of keys, for example 'case: wing'");
        return;
    }
    ScalarContext context{case_dir, ""};
    // Lengths are read in the surface's unit, wherever in the file it is stated.
    if (const Value* surface = raw_child(root, "surface"))
        if (const Value* units = raw_child(*surface, "units"))
            if (std::find(length_units().begin(), length_units().end(), units->text) != length_units().end())
                context.units = units->text;
    Validator(context, errors).map(root, root_row, "", "");
}

}  // namespace strake
