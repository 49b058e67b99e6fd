#include "core/formats/npy.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"
#include "core/text/raw_number.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>

static_assert(std::endian::native == std::endian::little, "arrays are read and written in native order");

namespace strake {
namespace {

constexpr std::string_view magic = "\x93NUMPY";

[[noreturn]] void refuse_npy(const std::string& what) { throw NpyError(what); }

/// The header, a Python dictionary literal: searches values after their keys, which suffices for NumPy's files.
class Header {
public:
    explicit Header(std::string_view text) : text_(text) {}

    std::string_view value(std::string_view key) const {
        for (const char quote : {'\'', '"'}) {
            const std::string quoted = quote + std::string(key) + quote;
            const std::size_t at = text_.find(quoted);
            if (at == std::string_view::npos) continue;
            const std::size_t colon = text_.find_first_not_of(" \t", at + quoted.size());
            if (colon == std::string_view::npos || text_[colon] != ':') break;
            const std::size_t begin = text_.find_first_not_of(" \t", colon + 1);
            if (begin != std::string_view::npos) return text_.substr(begin);
        }
        refuse_npy(text("the header has no '", key, "'; it is: ", printable(text_, 200)));
    }
    std::string_view word(std::string_view key) const {
        const std::string_view from = value(key);
        const char quote = from[0];
        if (quote != '\'' && quote != '"')
            refuse_npy(text("'", key, "' is ", printable(from, 60),
                            ", must be a type of number such as '<f8'; write numpy.asarray(a, dtype=float)"));
        return from.substr(1, from.find(quote, 1) - 1);
    }
    bool flag(std::string_view key) const {
        const std::string_view from = value(key);
        if (from.starts_with("True")) return true;
        if (!from.starts_with("False")) refuse_npy(text("'", key, "' is neither True nor False"));
        return false;
    }
    /// "(n, 3)"; anything else is refused.
    std::int64_t rows_of_three() const {
        const std::string_view from = value("shape");
        const std::string_view shape = from.substr(0, from.find(')') + 1);
        std::int64_t n = -1, columns = -1;
        const char *at = shape.data() + (shape.empty() ? 0 : 1), *end = shape.data() + shape.size();
        const auto number = [&](std::int64_t& into) {
            while (at != end && (*at == ' ' || *at == ',')) ++at;
            const auto [next, error] = std::from_chars(at, end, into);
            if (error == std::errc()) at = next;
            return error == std::errc();
        };
        const bool is_pair = shape.starts_with('(') && number(n) && number(columns);
        while (is_pair && at != end && (*at == ' ' || *at == ',')) ++at;
        if (!is_pair || at == end || *at != ')' || columns != 3 || n < 0)
            refuse_npy(text("shape ", printable(shape, 60), ", must be (n, 3)"));
        return n;
    }

private:
    std::string_view text_;
};

struct Data {
    Header header;
    std::string_view bytes;
};

Data split(std::string_view bytes) {
    if (!bytes.starts_with(magic)) refuse_npy("no NumPy array: it does not begin with \\x93NUMPY");
    if (bytes.size() < 10) refuse_npy("the file ends inside its header");
    const auto byte = [&](std::size_t k) { return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[k])); };
    const std::uint32_t version = byte(6);
    if (version < 1 || version > 3) refuse_npy(text("format version ", version, ", known are 1 to 3"));
    if (version > 1 && bytes.size() < 12) refuse_npy("the file ends inside its header");
    const std::size_t begin = version == 1 ? 10 : 12;
    const std::size_t length =
        version == 1 ? byte(8) + (byte(9) << 8) : byte(8) + (byte(9) << 8) + (byte(10) << 16) + (byte(11) << 24);
    if (bytes.size() - begin < length) refuse_npy("the file ends inside its header");
    return {Header(bytes.substr(begin, length)), bytes.substr(begin + length)};
}

}  // namespace

Points parse_npy(std::string_view bytes) {
    const Data data = split(bytes);
    const std::string_view type = data.header.word("descr");
    const std::string_view kind = type.size() > 1 ? type.substr(1) : "";
    if ((kind != "f4" && kind != "f8") || std::string_view("<>=").find(type[0]) == std::string_view::npos)
        refuse_npy(text("numbers of type '", printable(type, 60), "', must be floats of 4 or 8 bytes ('<f8')"));
    const bool is_fortran = data.header.flag("fortran_order");
    const std::int64_t n = data.header.rows_of_three();
    const std::size_t size = kind == "f4" ? 4 : 8;
    // Compared without overflow: n comes from the file.
    if (n > 715827882 || data.bytes.size() != 3 * size * static_cast<std::uint64_t>(n))
        refuse_npy(text("shape (", n, ", 3) of ", size, "-byte numbers, but ", data.bytes.size(), " bytes of them"));
    Points points(static_cast<Eigen::Index>(n), 3);
    for (std::int64_t i = 0; i < n; ++i)
        for (std::int64_t c = 0; c < 3; ++c) {
            const char* at = data.bytes.data() + size * static_cast<std::size_t>(is_fortran ? c * n + i : 3 * i + c);
            points(i, c) = size == 4 ? raw_number<float>(at, type[0] == '>') : raw_number<double>(at, type[0] == '>');
        }
    return points;
}

std::string npy_bytes(const Points& points) {
    std::string header = text("{'descr': '<f8', 'fortran_order': False, 'shape': (", points.rows(), ", 3), }");
    constexpr std::size_t before = 10, unit = 64;  // the data begins at a multiple of 64
    header.resize((before + header.size() + 1 + unit - 1) / unit * unit - before - 1, ' ');
    header += '\n';
    std::string bytes(magic);
    bytes += {'\1', '\0', static_cast<char>(header.size() & 0xff), static_cast<char>(header.size() >> 8)};
    bytes += header;
    bytes.append(reinterpret_cast<const char*>(points.data()), 8 * static_cast<std::size_t>(points.size()));
    return bytes;
}

}  // namespace strake
