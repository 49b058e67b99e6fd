#include "objectives/external/result.hpp"

#include "core/error.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/log.hpp"
#include "objectives/external/refused.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

namespace strake {
namespace {

using nlohmann::json;

[[noreturn]] void refuse_result(const char* kind, const std::string& message) {
    throw Refused{{kind, ": " + message}};  // behind the name of the file
}

/// ":3:14: …" for the byte at `offset`.
[[noreturn]] void refuse_at(const char* kind, const std::string& bytes, std::size_t offset, const std::string& what) {
    const std::string before = bytes.substr(0, offset);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const auto column = before.size() - (before.find_last_of('\n') + 1) + 1;  // npos + 1 is 0
    throw Refused{{kind, text(":", line, ":", column, ": ", what)}};
}

/// Python and others write NaN and Infinity, which are not JSON: say this instead of "invalid literal".
[[noreturn]] void refuse_syntax(const std::string& bytes, const json::parse_error& error) {
    if (bytes.find_first_not_of(" \t\r\n") == std::string::npos)
        refuse_result("unreadable", bytes.empty() ? "the file is empty" : "the file holds nothing but blanks");
    const std::size_t last = std::min(bytes.size(), error.byte) - (error.byte > 0 ? 1 : 0);
    const auto part_of_word = [&](std::size_t k) { return std::isalpha(static_cast<unsigned char>(bytes[k])) != 0; };
    std::size_t begin = last, end = last;
    while (begin > 0 && part_of_word(begin - 1)) --begin;
    while (end < bytes.size() && part_of_word(end)) ++end;
    std::string word = bytes.substr(begin, end - begin);
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    if (word == "nan" || word == "inf" || word == "infinity")
        refuse_at("not_finite", bytes, begin,
                  text("'", printable_line(bytes.substr(begin, end - begin)), "' is not a finite number"));
    const std::string what = error.what();  // "[json.exception…] parse error at line 1, column 3: syntax error …"
    const std::size_t reason = what.find("syntax error");
    refuse_at("unreadable", bytes, last,
              text("is not JSON, as {\"value\": 0.5}: ",
                   reason == std::string::npos ? "" : printable_line(std::string_view(what).substr(reason))));
}

json parse(const std::string& bytes) {
    // Bounded, because copying and printing recurse. Of a key that stands twice the parser would keep the last value.
    std::vector<std::set<std::string>> keys;
    const json::parser_callback_t bounded = [&keys](int depth, json::parse_event_t event, json& parsed) {
        if (depth > 64) refuse_result("unreadable", "is nested deeper than 64 levels");
        if (event == json::parse_event_t::object_start) keys.emplace_back();
        if (event == json::parse_event_t::object_end) keys.pop_back();
        if (event == json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second)
            refuse_result("unreadable", text("has the key '", printable_line(parsed.get<std::string>()),
                                             "' twice: which one counts is unclear"));
        return true;
    };
    try {
        return json::parse(bytes, bounded);
    } catch (const json::parse_error& error) {
        refuse_syntax(bytes, error);
    } catch (const json::out_of_range& error) {  // "number overflow parsing '1e400'"
        const std::string what = error.what();
        const std::size_t quote = what.find('\'');
        const std::string number =
            quote == std::string::npos ? "" : what.substr(quote + 1, what.rfind('\'') - quote - 1);
        refuse_at("not_finite", bytes, number.empty() ? 0 : std::min(bytes.find(number), bytes.size()),
                  text("number ", printable_line(number), " is too large"));
    }
}

double number(const json& node, const std::string& where) {
    if (!node.is_number()) {
        const std::string shown =
            printable_line(node.dump(-1, ' ', true, json::error_handler_t::replace).substr(0, 60));
        refuse_result("wrong_type", text(where, " is ", node.is_null() ? "" : node.type_name() + std::string(" "),
                                         shown, ", must be a number"));
    }
    const double value = node.get<double>();
    if (!std::isfinite(value)) refuse_result("not_finite", text(where, " = ", value));
    return value;
}

/// "drag.csv", or {"file": "out.vtp", "field": "dDrag"}.
std::pair<std::string, std::string> file_and_field(const json& node, const std::string& where) {
    if (node.is_string()) return {node.get<std::string>(), ""};
    const bool is_pair = node.is_object() && node.contains("file") && node["file"].is_string() &&
                         (!node.contains("field") || node["field"].is_string());
    if (!is_pair)
        refuse_result("wrong_type", text(where, " is ", node.type_name(),
                                         ", must be the name of a file, or {\"file\": name, \"field\": name}"));
    return {node["file"].get<std::string>(), node.value("field", std::string())};
}

std::string names_in(const json& object) {
    std::string names;
    for (const auto& [key, value] : object.items()) names += (names.empty() ? "" : ", ") + printable_line(key);
    return names.empty() ? "nothing" : names;
}

/// A result.json that would do: {"value": 0.0123, "gradient": "gradient.csv"}.
std::string example(const std::vector<std::string>& outputs, bool with_gradients) {
    if (outputs.size() < 2 && with_gradients) return R"({"value": 0.0123, "gradient": "gradient.csv"})";
    if (outputs.size() < 2) return R"({"value": 0.0123})";
    std::string values, gradients;
    for (const std::string& name : outputs) {
        const char* between = values.empty() ? "" : ", ";
        values += text(between, '"', name, "\": 0.0123");
        gradients += text(between, '"', name, "\": \"", name, ".csv\"");
    }
    return text("{\"values\": {", values, "}", with_gradients ? ", \"gradients\": {" + gradients + "}" : "", "}");
}

[[noreturn]] void refuse_missing(const json& object, const std::string& where, const std::string& key) {
    for (const auto& [name, value] : object.items())
        if (similar(key, name))
            refuse_result("missing_key", text("no '", key, "' ", where, "; it has '", printable_line(name),
                                              "', did you mean '", key, "'?"));
    refuse_result("missing_key", text("no '", key, "' ", where, "; it has: ", names_in(object)));
}

/// The entries for `outputs`, in order, from the map `plural` or, for a single output, from the short form `singular`.
std::vector<json> entries(const json& result, const char* plural, const char* singular,
                          const std::vector<std::string>& outputs) {
    const bool has_map = result.contains(plural), has_short = result.contains(singular);
    if (has_map && has_short)
        refuse_result("wrong_type", text("has both '", plural, "' and '", singular, "', must have one of them"));
    if (has_short && outputs.size() > 1)
        refuse_result("missing_key",
                      text("'", singular, "' is for a command that outputs one value, this one outputs ",
                           outputs.size(), ": write \"", plural, "\": {\"", outputs.front(), "\": ...}"));
    if (has_short) return {result[singular]};
    if (!has_map) refuse_missing(result, "at the top", outputs.size() > 1 ? plural : singular);
    const json& map = result[plural];
    if (!map.is_object())
        refuse_result("wrong_type", text("'", plural, "' is ", map.type_name(), ", must be an object, as in ",
                                         example(outputs, plural == std::string("gradients"))));
    std::vector<json> found;
    const std::vector<std::string> unnamed{singular};
    for (const std::string& name : outputs.empty() ? unnamed : outputs) {
        if (!map.contains(name)) refuse_missing(map, text("in '", plural, "'"), name);
        found.push_back(map[name]);
    }
    return found;
}

/// The derivatives of one value by the requested variables; NaN if missing and allowed.
std::vector<double> derivatives(const json& by_variable, const std::string& where,
                                const std::vector<std::string>& wanted, bool may_lack) {
    if (!by_variable.is_object())
        refuse_result("wrong_type", text(where, " is ", by_variable.type_name(), ", must be an object"));
    for (const auto& [name, value] : by_variable.items()) number(value, text(where, " ", printable_line(name)));
    std::vector<double> found;
    for (const std::string& name : wanted) {
        bool is_misspelt = false;
        for (const auto& [key, value] : by_variable.items()) is_misspelt |= similar(name, key);
        if (by_variable.contains(name))
            found.push_back(by_variable[name].get<double>());
        else if (may_lack && !is_misspelt)
            found.push_back(std::numeric_limits<double>::quiet_NaN());
        else
            refuse_missing(by_variable, text("in ", where), name);
    }
    return found;
}

/// {value: {variable: number}}, or {variable: number} for a single value.
std::vector<std::vector<double>> all_derivatives(const json& result, const std::vector<std::string>& outputs,
                                                 const std::vector<std::string>& wanted, bool may_lack) {
    const std::vector<std::string> names = outputs.empty() ? std::vector<std::string>{"value"} : outputs;
    if (!result.contains("variables")) {
        if (!wanted.empty() && !may_lack)
            refuse_result("missing_key", text("no 'variables' at the top: the derivative of '", names[0], "' by '",
                                              wanted[0], "' is wanted (0 where it does not depend on it)"));
        return std::vector(names.size(), std::vector(wanted.size(), std::numeric_limits<double>::quiet_NaN()));
    }
    const json& map = result["variables"];
    if (!map.is_object()) refuse_result("wrong_type", text("'variables' is ", map.type_name(), ", must be an object"));
    const auto is_number = [](const json& entry) { return entry.is_number(); };
    if (names.size() == 1 && !map.empty() && std::all_of(map.begin(), map.end(), is_number))
        return {derivatives(map, "'variables'", wanted, may_lack)};
    for (const auto& [name, entry] : map.items())
        derivatives(entry, text("'variables.", printable_line(name), "'"), {}, true);
    std::vector<std::vector<double>> found;
    for (const std::string& name : names) {
        if (!map.contains(name) && !wanted.empty() && !may_lack) refuse_missing(map, "in 'variables'", name);
        found.push_back(derivatives(map.contains(name) ? map[name] : json::object(), text("'variables.", name, "'"),
                                    wanted, may_lack));
    }
    return found;
}

ProgramResult parse_named(const std::string& bytes, const std::vector<std::string>& outputs, bool want_gradients,
                          const std::vector<std::string>& variables, bool may_lack, bool want_values) {
    const json result = parse(bytes);
    const bool wants_both = want_gradients && want_values;
    const std::string values_only =
        wants_both ? text(
                         ". For a program that gives values only, add `gradients: false` to the quantity; result.json "
                         "is then ",
                         example(outputs, false))
                   : "";
    if (!result.is_object())
        refuse_result("wrong_type", text("is ", result.type_name(), ", must be an object, as ",
                                         example(outputs, wants_both), values_only));
    const bool is_known = std::any_of(result.items().begin(), result.items().end(), [](const auto& item) {
        return similar("value", item.key()) || similar("values", item.key()) || item.key() == "gradient" ||
               item.key() == "gradients";
    });
    if (wants_both && !is_known)
        refuse_result("missing_key", text("no '", outputs.size() > 1 ? "values" : "value", "' at the top; it has: ",
                                          names_in(result), "; result.json is ", example(outputs, true), values_only));
    const auto shown = [&](const char* plural, const char* singular, std::size_t k) {
        return outputs.empty() ? text("'", singular, "'") : text("'", plural, ".", outputs[k], "'");
    };
    ProgramResult found;
    for (const json& entry : want_values ? entries(result, "values", "value", outputs) : std::vector<json>())
        found.values.push_back(number(entry, shown("values", "value", found.values.size())));
    found.by_variable =
        all_derivatives(result, outputs, want_gradients ? variables : std::vector<std::string>(), may_lack);
    if (!want_gradients) {
        found.by_variable.clear();
        return found;
    }
    if (want_values && !result.contains("gradients") && !result.contains("gradient"))
        refuse_result("missing_key", text("no '", outputs.size() > 1 ? "gradients" : "gradient",
                                          "' at the top; it has: ", names_in(result),
                                          ". For a program that gives values only, add `gradients: false` to the ",
                                          "quantity; with gradients, result.json is ", example(outputs, true)));
    for (const json& entry : entries(result, "gradients", "gradient", outputs)) {
        const auto [file, field] = file_and_field(entry, shown("gradients", "gradient", found.gradient_files.size()));
        found.gradient_files.push_back(file);
        found.gradient_fields.push_back(field);
    }
    return found;
}

}  // namespace

ProgramResult parse_result(const std::string& bytes, const std::vector<std::string>& outputs, bool want_gradients,
                           const std::vector<std::string>& variables, bool may_lack, const std::string& name,
                           bool want_values) {
    try {
        return parse_named(bytes, outputs, want_gradients, variables, may_lack, want_values);
    } catch (const Refused& refused) {
        throw Refused{{refused.failure.kind, name + refused.failure.message}};
    }
}

}  // namespace strake
