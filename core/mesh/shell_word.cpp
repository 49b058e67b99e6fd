#include "core/shell_word.hpp"

#include <cstdio>
#include <cstring>

#include "core/mesh/file.hpp"

namespace strake {
namespace {

/// Means the same to every shell wherever it stands in a word.
bool is_plain(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           (c != '\0' && std::strchr("_./:,+@%-", c) != nullptr);
}

/// $'...': only what is not text is escaped, and what ends or escapes within it.
std::string ansi_quoted(const std::string& word) {
    std::string out = "$'";
    for (const char c : word) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '\'' || c == '\\') {
            (out += '\\') += c;
        } else if (byte < 0x20 || byte >= 0x7f) {
            char octal[5];  // of three digits always: hexadecimal ones would go on into what follows
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
        if (c == '\'') quoted += "'\\'";  // the quotation is left for this one
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
