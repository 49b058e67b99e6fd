#pragma once
#include <algorithm>
#include <cstring>

namespace strake {

/// A number from its bytes, without alignment; `swap`: their order is the reverse of this machine's.
template <class Number>
Number raw_number(const char* at, bool swap) {
    char raw[sizeof(Number)];
    std::memcpy(raw, at, sizeof raw);
    if (swap) std::reverse(raw, raw + sizeof raw);
    Number value;
    std::memcpy(&value, raw, sizeof raw);
    return value;
}

}  // namespace strake
