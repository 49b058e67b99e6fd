#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// The header of a PLY file.
namespace strake::formats {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
std::size_t size_of(PlyType type);  ///< bytes

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::float32;
    bool is_list = false;
    PlyType count_type = PlyType::uint8;  ///< of lists
    long line = 0;
};

struct PlyElement {
    std::string name;
    std::int64_t count = 0;
    std::vector<PlyProperty> properties;
};

enum class PlyEncoding { ascii, little_endian, big_endian };

struct PlyHeader {
    PlyEncoding encoding = PlyEncoding::ascii;
    std::vector<PlyElement> elements;
    std::size_t bytes = 0;  ///< where the data begin
    long lines = 0;
    bool has(std::string_view element) const;
};

/// @throws InputError `FILE:LINE: …`.
PlyHeader read_ply_header(std::string_view bytes, const std::string& name);

}  // namespace strake::formats
