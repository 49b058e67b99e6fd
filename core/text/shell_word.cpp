#include "core/text/shell_word.hpp"

#include <cstdio>
#include <cstring>

#include "core/text/file.hpp"

namespace strake {
namespace {

/// Has no special meaning to any shell anywhere in a word.
bool is_plain(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           (c != '\0' && std::strchr("_./:,+@%-", c) != nullptr);
}

/// $'...': escapes non-text, quotes and backslashes.
std::string ansi_quoted(const std::string& word) {
    std::string out = "$'";
    for (const char c : word) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '\'' || c == '\\') {
            (out += '\\') += c;
        } else if (byte < 0x20 || byte >= 0x7f) {
            char octal[5];  // always three octal digits: hexadecimal escapes would swallow following digits
            std::snprintf(octal, sizeof octal, "\\%03o", byte);
            out += octal;
        } else {
            out += c;
        }
    }
    return out + '\'';
}

}  // namespace

std::string shell_word(const std::string& word) {
    std::string quoted = "'";
    for (const char c : word) {
        if (c == '\'') quoted += "'\\'";  // leaves the quotes for this one
        quoted += c;
    }
    return quoted + '\'';
}

std::string typed_path(const std::string& path) {
    if (path.starts_with('-')) return typed_path("./" + path);
    bool plain = !path.empty();
    for (const char c : path) plain = plain && is_plain(c);
    if (plain) return path;
    return printable(path, path.size()) == path ? shell_word(path) : ansi_quoted(path);
}

}  // namespace strake
