#include "casefile/schema/scalars.hpp"

#include "core/text/windows_path.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <numbers>
#include <system_error>

namespace strake {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

struct Unit {
    const char* name;
    double factor;
};
// In nanometres, where every factor is an integer: 5 cm is 50 mm without rounding.
constexpr Unit length_table[] = {{"m", 1e9}, {"cm", 1e7}, {"mm", 1e6}, {"um", 1e3}, {"in", 25.4e6}, {"ft", 304.8e6}};
constexpr Unit time_table[] = {{"s", 1}, {"min", 60}, {"h", 3600}};

double length_factor(const std::string& unit) {
    for (const Unit& u : length_table)
        if (unit == u.name) return u.factor;
    return 0;
}

/// "5.5 mm" -> "5.5", "mm". The number part ends with the last digit, point or exponent.
std::pair<std::string, std::string> split_unit(const std::string& text) {
    std::size_t end = text.size();
    while (end > 0 && !is_digit(text[end - 1]) && text[end - 1] != '.') --end;
    std::size_t unit = end;
    while (unit < text.size() && text[unit] == ' ') ++unit;
    return {text.substr(0, end), text.substr(unit)};
}

std::string read_integer(const std::string& text, double& number) {
    std::size_t i = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
    const std::size_t first = i;
    while (i < text.size() && is_digit(text[i])) ++i;
    if (i == first || i != text.size()) return "must be an integer";
    if (text[first] == '0' && text.size() > first + 1) return "must be written without leading zeros";
    int parsed = 0;
    const char* begin = text.c_str() + (text[0] == '+' ? 1 : 0);
    const auto end = std::from_chars(begin, text.c_str() + text.size(), parsed);
    if (end.ec != std::errc()) return "must be an integer between -2147483648 and 2147483647";
    number = parsed;
    return "";
}

std::string read_flag(const std::string& text, double& number) {
    if (text != "true" && text != "false") return "must be true or false";
    number = text == "true" ? 1 : 0;
    return "";
}

std::string read_fraction(const std::string& text, double& number) {
    const auto [digits, unit] = split_unit(text);
    if (unit.empty()) return read_number(text, number);
    if (unit != "%") return "must be a number or a percentage, for example 0.02 or 2%";
    const std::string error = read_number(digits, number);
    number /= 100;
    return error;
}

std::string read_length(const std::string& text, const ScalarContext& context, bool may_be_relative, Value& value) {
    const auto [digits, unit] = split_unit(text);
    if (unit == "%") {
        if (!may_be_relative) return "must be a coordinate: a percentage of the diagonal has no origin";
        value.relative = true;
        const std::string error = read_number(digits, value.number);
        value.number /= 100;
        return error;
    }
    const std::string error = read_number(unit.empty() ? text : digits, value.number);
    if (unit.empty()) return error;
    if (length_factor(unit) == 0) {
        const std::string units = joined(length_units());
        return text.find_first_of("0123456789") == std::string::npos || !error.empty()
                   ? strake::text("must be a length: a number, with a unit (", units, may_be_relative ? ") or %" : ")")
                   : strake::text("has the unknown unit '", printable(unit), "'; units: ", units,
                                  may_be_relative ? ", %" : "");
    }
    if (context.units.empty())
        return "has a unit, but surface.units does not state the unit of the surface; state it, or leave the unit out";
    if (unit != context.units) value.number = value.number * length_factor(unit) / length_factor(context.units);
    return error;
}

std::string read_angle(const std::string& text, double& number) {
    const auto [digits, unit] = split_unit(text);
    const std::string error = read_number(unit.empty() ? text : digits, number);
    if (unit.empty() && error.empty() && number == 0) return "";
    if (unit != "deg" && unit != "rad") return "must be an angle with a unit, for example 5deg or 0.1rad";
    if (unit == "deg") number *= std::numbers::pi / 180;
    return error;
}

std::string read_number_or_angle(const std::string& text, double& number) {
    const std::string unit = split_unit(text).second;
    if (unit == "deg" || unit == "rad") return read_angle(text, number);
    const std::string error = read_number(text, number);
    return error.empty() ? "" : "must be a number, or an angle with a unit, for example 5deg or 0.1rad";
}

std::string read_duration(const std::string& text, double& number) {
    const auto [digits, unit] = split_unit(text);
    for (const Unit& u : time_table)
        if (unit == u.name) {
            const std::string error = read_number(digits, number);
            number *= u.factor;
            return error;
        }
    return "must be a time with a unit, for example 90s, 15min or 2h";
}

std::string read_name(const std::string& text) {
    const auto legal = [](char c) {
        return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-';
    };
    if (text.empty() || text.size() > 100 || !std::all_of(text.begin(), text.end(), legal))
        return "must be a name of letters, digits, '_' and '-'";
    return "";
}

/// The file in the folder whose name is nearest to a mistyped one.
std::string similar_file(const std::filesystem::path& path) {
    constexpr int max_names = 1000;  // a folder of results may hold a million
    std::vector<std::string> names;
    std::error_code error;
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        if (names.size() < max_names) names.push_back(at->path().filename().string());
    std::sort(names.begin(), names.end());  // the order of a folder is not reproducible
    const std::string near = nearest(path.filename().string(), names);
    return near.empty() ? "" : text("; did you mean '", printable(near, 200), "'?");
}

/// Checks a file before anything runs.
std::string check_file(const std::string& name, const std::filesystem::path& case_dir) {
    if (name.empty()) return "must name a file";
    const std::filesystem::path path = case_dir / name;
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (status.type() == std::filesystem::file_type::not_found)
        return text("does not exist", path == name ? "" : " (" + printable(path.string(), 300) + ")",
                    windows_path_hint(name), similar_file(path));
    if (error) return text("cannot be read: ", error.message());
    if (!std::filesystem::is_regular_file(status)) return "is not a regular file";
    return "";
}

std::string read_word(Value& value, const Key& key) {
    const auto same = [&](const std::string& word) {
        return key.loose_word ? algorithm_word(value.text) == algorithm_word(word) : value.text == word;
    };
    // What is written exactly comes first: nlopt_slsqp is not another way of writing sqp's alias.
    for (const std::string& word : key.words)
        if (value.text == word) return "";
    for (std::size_t k = 0; k < key.words.size(); ++k)
        if (same(key.words[k]) || (k < key.aliases.size() && same(key.aliases[k]))) {
            value.text = key.words[k];
            return "";
        }
    const std::string near = nearest(key.loose_word ? algorithm_word(value.text) : value.text, key.words);
    const std::string hint = near.empty() ? "" : text("; did you mean '", near, "'?");
    return text("must be ", key.words.size() > 1 ? "one of " : "", joined(key.words), hint);
}

std::string quoted_word(Type type) {
    return type == Type::flag ? "is quoted text; write true or false without quotes"
                              : "is quoted text; write the number without quotes";
}

std::string check_limits(const Value& value, Type type, const Limits& limits) {
    double v = value.number;
    const bool is_angle = type == Type::angle;
    if (is_angle) v = degrees(v);
    const bool low = limits.min_open ? v <= limits.min : v < limits.min;
    const bool high = limits.max_open ? v >= limits.max : v > limits.max;
    if (!low && !high) return "";
    const auto shown = [&](double limit) {
        if (type == Type::fraction) return text(limit * 100, "%");
        return text(limit, is_angle ? "deg" : "");
    };
    if (std::isinf(limits.max)) return text("must be ", limits.min_open ? "> " : ">= ", shown(limits.min));
    return text("must be in ", limits.min_open ? "(" : "[", shown(limits.min), ", ", shown(limits.max),
                limits.max_open ? ")" : "]");
}

std::string convert(Value& value, Type type, const Key& key, const ScalarContext& context) {
    if (value.text.find('\0') != std::string::npos) return "must not contain a NUL character";
    switch (type) {
        case Type::text:
            return value.text.empty() ? "must not be empty" : "";
        case Type::path:
            return value.text.empty() ? "must name a file or folder" : "";
        case Type::name:
            return read_name(value.text);
        case Type::word:
            return read_word(value, key);
        case Type::file:
            return check_file(value.text, context.case_dir);
        default:
            break;
    }
    if (value.quoted) return quoted_word(type);
    switch (type) {
        case Type::flag:
            return read_flag(value.text, value.number);
        case Type::integer:
            return read_integer(value.text, value.number);
        case Type::number:
            return read_number(value.text, value.number);
        case Type::fraction:
            return read_fraction(value.text, value.number);
        case Type::length:
            return read_length(value.text, context, true, value);
        case Type::coordinate:
            return read_length(value.text, context, false, value);
        case Type::angle:
            return read_angle(value.text, value.number);
        case Type::number_or_angle:
            return read_number_or_angle(value.text, value.number);
        case Type::duration:
            return read_duration(value.text, value.number);
        default:
            return "must be a list or a map";
    }
}

}  // namespace

std::string read_number(const std::string& text, double& number) {
    const std::size_t first = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
    const bool starts = first < text.size() && (is_digit(text[first]) || text[first] == '.');
    if (starts && text.size() > first + 1 && text[first] == '0' && is_digit(text[first + 1]))
        return "must be written without leading zeros";
    if (starts && text.find(',') != std::string::npos) return "must be a number with a decimal point, not a comma";
    if (starts && text.find('_') != std::string::npos) return "must be a number without '_'";
    const char* begin = text.c_str() + (first && text[0] == '+' ? 1 : 0);
    const char* end = text.c_str() + text.size();
    const auto parsed = starts ? std::from_chars(begin, end, number) : std::from_chars_result{begin, {}};
    if (starts && parsed.ec == std::errc::result_out_of_range && parsed.ptr == end)
        return "is outside the range of a double";
    if (!starts || parsed.ec != std::errc() || parsed.ptr != end || !std::isfinite(number))
        return "must be a finite number";
    return "";
}

std::string algorithm_word(const std::string& name) {
    std::string word;
    for (const char c : name)
        if (c != '-') word += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    for (const char* prefix : {"nlopt_", "ld_", "ln_", "gd_", "gn_", "g_"})
        if (word.rfind(prefix, 0) == 0) word.erase(0, std::strlen(prefix));
    return word;
}

double degrees(double radians) { return std::round(radians * (180 / std::numbers::pi) * 1e12) / 1e12; }

std::string shown_value(double value, bool is_angle) { return is_angle ? text(degrees(value), "deg") : text(value); }

const std::vector<std::string>& length_units() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const Unit& u : length_table) all.push_back(u.name);
        return all;
    }();
    return names;
}

std::string convert_scalar(Value& value, Type type, const Key& key, const ScalarContext& context) {
    if (type == key.type && type != Type::word && !value.quoted &&
        std::find(key.words.begin(), key.words.end(), value.text) != key.words.end())
        return "";
    std::string error = convert(value, type, key, context);
    if (error.empty() && !std::isfinite(value.number)) error = "is outside the range of a double";
    if (error.empty() && type != Type::word) error = check_limits(value, type, key.limits);
    return error;
}

}  // namespace strake
