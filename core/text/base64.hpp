#pragma once
#include <string>
#include <string_view>

/// Bytes as text (RFC 4648, section 4).
namespace strake {

std::string base64(std::string_view bytes);  ///< with padding
int base64_digit(char c);                    ///< value of a digit, 0 to 63; -1 for any other character

}  // namespace strake
