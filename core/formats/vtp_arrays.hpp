#pragma once
#include <string>
#include <string_view>
#include <vector>

/// The arrays of VTK's XML files, as bytes. Internal: programs use vtp_reader.hpp.
namespace strake::vtk {

/// Attributes of `VTKFile`.
struct Coding {
    bool is_swapped = false;       ///< big-endian
    std::size_t header_bytes = 4;  ///< 4 or 8, of each length
    bool is_compressed = false;    ///< by zlib
};

/// Of one `DataArray`.
struct Array {
    std::string section, name;  ///< the element around it: "PointData", "Points", "Polys", …
    std::string type;           ///< "Float64", "Int32", …
    std::size_t components = 1;
    std::string_view inside;  ///< behind its tag (inline), or the appended data from its offset on
    bool is_text = false;     ///< numbers as words
    bool is_base64 = false;   ///< else raw bytes
    bool is_appended = false;
    std::string offset;                              ///< as written, where appended
    std::size_t element_begin = 0, element_end = 0;  ///< where <DataArray ...> stands in the file, with its end
};

bool is_numeric(const std::string& type);

/// All numbers of an array. @throws std::runtime_error with the reason: too short, damaged, an unknown type.
std::vector<double> numbers(const Array& array, const Coding& coding);

}  // namespace strake::vtk
