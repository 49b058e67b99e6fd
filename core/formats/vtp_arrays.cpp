#include "core/formats/vtp_arrays.hpp"

#include "core/error.hpp"
#include "core/text/base64.hpp"
#include "core/text/file.hpp"
#include "core/text/raw_number.hpp"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>

namespace strake::vtk {
namespace {

constexpr std::string_view blanks = " \t\r\n";
constexpr std::uint64_t max_deflated = 1040;  // zlib's limit is 1 : 1032

[[noreturn]] void refuse_array(const std::string& what) { throw std::runtime_error(what); }

/// A sequence of bytes in either encoding. VTK encodes in groups that end with padding.
class Bytes {
public:
    Bytes(std::string_view source, bool is_base64) : source_(source), is_base64_(is_base64) {
        if (is_base64_) source_.remove_prefix(std::min(source_.find_first_not_of(blanks), source_.size()));
    }
    /// The first `count` bytes of a group, without consuming it.
    std::string peek(std::uint64_t count) const {
        if (count > source_.size()) refuse_array("the array ends too early");
        if (!is_base64_) return std::string(source_.substr(0, count));
        std::string out;
        out.reserve(count + 3);
        const std::uint64_t digits = (count + 2) / 3 * 4;
        if (digits > source_.size()) refuse_array("the array ends too early");
        for (std::uint64_t at = 0; at < digits; at += 4) {
            std::uint32_t group = 0;
            for (std::uint64_t k = 0; k < 4; ++k) {
                const char c = source_[at + k];
                const int digit = c == '=' && at + 4 >= digits ? 0 : base64_digit(c);
                if (digit < 0) refuse_array(text("'", printable(source_.substr(at + k, 1)), "' is no base64"));
                group = (group << 6) | static_cast<std::uint32_t>(digit);
            }
            for (const int shift : {16, 8, 0}) out += static_cast<char>((group >> shift) & 0xff);
        }
        out.resize(count);
        return out;
    }
    /// The group of `count` bytes.
    std::string take(std::uint64_t count) {
        std::string out = peek(count);
        source_.remove_prefix(is_base64_ ? (count + 2) / 3 * 4 : count);
        return out;
    }
    std::uint64_t size() const { return source_.size(); }

private:
    std::string_view source_;
    bool is_base64_;
};

std::uint64_t length_at(const std::string& bytes, std::size_t number, const Coding& coding) {
    const char* at = bytes.data() + number * coding.header_bytes;
    return coding.header_bytes == 4 ? raw_number<std::uint32_t>(at, coding.is_swapped)
                                    : raw_number<std::uint64_t>(at, coding.is_swapped);
}

/// [number of blocks][bytes of a block][bytes of the last, 0: like the others][compressed bytes of each], then the
/// blocks.
std::string inflated(Bytes bytes, const Coding& coding) {
    const std::string head = bytes.peek(3 * coding.header_bytes);
    const std::uint64_t blocks = length_at(head, 0, coding), full = length_at(head, 1, coding),
                        last = length_at(head, 2, coding);
    if (blocks == 0) return "";
    if (blocks > bytes.size() || full > max_deflated * bytes.size() || last > full)
        refuse_array("the lengths of its blocks are damaged");
    const std::string sizes = bytes.take((3 + blocks) * coding.header_bytes);
    std::uint64_t packed = 0;
    for (std::uint64_t b = 0; b < blocks; ++b) {
        const std::uint64_t size = length_at(sizes, 3 + b, coding);
        if (size > bytes.size() - std::min(packed, bytes.size())) refuse_array("the lengths of its blocks are damaged");
        packed += size;
    }
    const std::string data = bytes.take(packed);
    std::string out;
    std::uint64_t at = 0;
    for (std::uint64_t b = 0; b < blocks; ++b) {
        const std::uint64_t size = length_at(sizes, 3 + b, coding);
        uLongf length = b + 1 == blocks && last > 0 ? last : full;
        if (length > max_deflated * (size + 16)) refuse_array("the lengths of its blocks are damaged");
        const std::size_t before = out.size();
        out.resize(before + length);
        const uLongf wanted = length;
        if (uncompress(reinterpret_cast<Bytef*>(out.data() + before), &length,
                       reinterpret_cast<const Bytef*>(data.data() + at), size) != Z_OK ||
            length != wanted)
            refuse_array(text("block ", b, " is damaged (zlib)"));
        at += size;
    }
    return out;
}

std::string content(const Array& array, const Coding& coding) {
    Bytes bytes(array.inside, array.is_base64);
    if (coding.is_compressed) return inflated(bytes, coding);
    const std::uint64_t length = length_at(bytes.peek(coding.header_bytes), 0, coding);
    if (length > bytes.size()) refuse_array("the array ends too early");
    return bytes.take(coding.header_bytes + length).substr(coding.header_bytes);
}

template <class Number>
std::vector<double> converted(const std::string& bytes, bool swap) {
    if (bytes.size() % sizeof(Number) != 0)
        refuse_array(text(bytes.size(), " bytes are no whole number of ", sizeof(Number), "-byte numbers"));
    std::vector<double> out(bytes.size() / sizeof(Number));
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = static_cast<double>(raw_number<Number>(bytes.data() + sizeof(Number) * i, swap));
    return out;
}

std::vector<double> words(std::string_view inside) {
    std::vector<double> out;
    for (std::size_t begin = inside.find_first_not_of(blanks); begin != std::string_view::npos;
         begin = inside.find_first_not_of(blanks, begin)) {
        const std::size_t end = std::min(inside.find_first_of(blanks, begin), inside.size());
        const std::string_view word = inside.substr(begin, end - begin);
        double value = 0;
        const char* from = word.data() + (word.starts_with('+') ? 1 : 0);
        const auto [stop, error] = std::from_chars(from, word.data() + word.size(), value);
        if (stop != word.data() + word.size() || error == std::errc::invalid_argument)
            refuse_array(text("'", printable(word, 60), "' is not a number"));
        if (error == std::errc::result_out_of_range)
            value = word.find("e-") != word.npos || word.find("E-") != word.npos
                        ? 0
                        : std::numeric_limits<double>::infinity();
        out.push_back(value);
        begin = end;
        if (begin >= inside.size()) break;
    }
    return out;
}

}  // namespace

bool is_numeric(const std::string& type) { return type.starts_with("Float") || type.find("Int") != type.npos; }

std::vector<double> numbers(const Array& array, const Coding& coding) {
    if (array.is_text) return words(array.inside);
    const bool swap = coding.is_swapped;
    const std::string bytes = content(array, coding);
    if (array.type == "Float64") return converted<double>(bytes, swap);
    if (array.type == "Float32") return converted<float>(bytes, swap);
    if (array.type == "Int64") return converted<std::int64_t>(bytes, swap);
    if (array.type == "UInt64") return converted<std::uint64_t>(bytes, swap);
    if (array.type == "Int32") return converted<std::int32_t>(bytes, swap);
    if (array.type == "UInt32") return converted<std::uint32_t>(bytes, swap);
    if (array.type == "Int16") return converted<std::int16_t>(bytes, swap);
    if (array.type == "UInt16") return converted<std::uint16_t>(bytes, swap);
    if (array.type == "Int8") return converted<std::int8_t>(bytes, swap);
    if (array.type == "UInt8") return converted<std::uint8_t>(bytes, swap);
    refuse_array(text("numbers of the unknown type '", printable(array.type, 60), "'"));
}

}  // namespace strake::vtk
