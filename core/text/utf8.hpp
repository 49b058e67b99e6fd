#pragma once
#include <cstddef>
#include <string_view>

/// Characters of UTF-8 text (RFC 3629).
namespace strake {

struct Utf8Character {
    std::size_t length = 0;  ///< bytes; 0: not valid UTF-8 (cut off, overlong, a surrogate, or beyond U+10FFFF)
    char32_t code = 0;
};
/// The character that starts at byte `i`. @pre i < bytes.size()
Utf8Character utf8_at(std::string_view bytes, std::size_t i);
/// Control characters: C0, DEL and C1.
bool is_control(char32_t code);

}  // namespace strake
