#pragma once
#include <cstdint>
#include <string>
#include <vector>

/// Arrays of whole numbers as text that a page can hold: each column as differences from row to row, low and high bytes
/// apart, packed by zlib, in base64. report/page/src/packed.js is the other end.
namespace strake {

/// @param columns of the array, which holds its rows one after the other; the number of values is a multiple of it.
std::string packed_array(const std::vector<std::uint16_t>& values, std::size_t columns);
std::string packed_array(const std::vector<std::uint32_t>& values, std::size_t columns);

std::string base64(const std::string& bytes);

}  // namespace strake
