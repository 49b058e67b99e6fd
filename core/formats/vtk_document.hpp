#pragma once
#include "core/formats/vtp_arrays.hpp"
#include "core/text/xml_scanner.hpp"

/// VTK's XML files of any kind. Internal: programs use vtp_reader.hpp.
namespace strake::vtk {

/// Everything between the tags, before any array is decoded.
struct Document {
    Coding coding;
    std::vector<Array> arrays;
    std::vector<std::pair<std::size_t, std::string>> offsets;  ///< of appended arrays: number, offset
    int pieces = 0;
};

/// @param kind "PolyData" or "UnstructuredGrid". @throws InputError: no such file, or not of one piece.
Document scan(XmlScanner& in, const std::string& kind);

/// The first array of that section and name; an empty name: any. Null: none.
const Array* find(const Document& document, const std::string& section, const std::string& name);

/// All its numbers, whole rows. @throws InputError.
std::vector<double> decoded(const Array& array, const Document& document, const XmlScanner& in);

}  // namespace strake::vtk
