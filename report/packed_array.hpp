#pragma once
#include <cstdint>
#include <string>
#include <vector>

/// Integer arrays as text for a page: each column as differences from row to row, low and high bytes separated,
/// compressed by zlib, in base64. report/page/src/packed.js decodes them.
namespace strake {

/// @param columns of the array, which is stored row by row; the number of values is a multiple of it.
std::string packed_array(const std::vector<std::uint16_t>& values, std::size_t columns);
std::string packed_array(const std::vector<std::uint32_t>& values, std::size_t columns);

}  // namespace strake
