#include "report/packed_array.hpp"

#include "core/error.hpp"
#include "core/text/base64.hpp"

#include <zlib.h>

namespace strake {
namespace {

std::string deflated(const std::string& bytes) {
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    std::string out(size, '\0');
    if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                  static_cast<uLong>(bytes.size()), 6) != Z_OK)
        throw OutputError(text("the report's shapes could not be compressed: no memory for ", bytes.size(), " bytes"));
    out.resize(size);
    return out;
}

/// Neighbours have similar values: their differences compress well, and so do the high bytes by themselves.
template <class Whole>
std::string packed(const std::vector<Whole>& values, std::size_t columns) {
    if (columns == 0 || values.size() % columns != 0)
        throw InvalidInput(text("packed_array: ", values.size(), " values in rows of ", columns));
    std::string planes(sizeof(Whole) * values.size(), '\0');
    for (std::size_t i = 0; i < values.size(); ++i) {
        const Whole before = i >= columns ? values[i - columns] : Whole{0};
        const auto difference = static_cast<Whole>(values[i] - before);
        for (std::size_t byte = 0; byte < sizeof(Whole); ++byte)
            planes[byte * values.size() + i] = static_cast<char>(difference >> (8 * byte) & 0xff);
    }
    return base64(deflated(planes));
}

}  // namespace

std::string packed_array(const std::vector<std::uint16_t>& values, std::size_t columns) {
    return packed(values, columns);
}
std::string packed_array(const std::vector<std::uint32_t>& values, std::size_t columns) {
    return packed(values, columns);
}

}  // namespace strake
