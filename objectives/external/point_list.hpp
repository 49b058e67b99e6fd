#pragma once
#include "core/mesh/mesh.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

/// Lists of points: nodes of a solver's boundary or volume mesh.
namespace strake {

/// A text with a header that names its columns, verbatim.
struct NamedText {
    std::string header;
    std::vector<std::string> rows;  ///< n
    std::array<int, 3> xyz{};       ///< columns of the coordinates
};

struct NumberedPoints {
    Points at;                           ///< n x 3
    std::vector<std::int64_t> ids = {};  ///< the program's own numbers; empty: none
    NamedText text = {};                 ///< of a file with a header; without rows: none
};

/// Points from
/// - .csv, .txt, .xyz: rows x,y,z; or a header that names x, y, z and maybe PointID, in any columns (SU2's surface
/// files);
/// - .npy: shape (n, 3);
/// - a surface file in any readable format: its vertices.
/// @throws InputError `FILE:LINE: what`: unreadable, empty, a coordinate that is not finite, a repeated number.
NumberedPoints read_points(const std::filesystem::path& file);
bool is_point_list(const std::filesystem::path& file);  ///< by its extension: a list, not a surface
bool is_npy(const std::filesystem::path& file);         ///< by its extension

/// Names of the columns other than coordinates and point numbers.
std::vector<std::string> other_columns(const NumberedPoints& points);

/// As .npy (double precision) or text whose numbers read back to the same bits: with all columns of `text`, else with
/// the header x,y,z, or PointID,x,y,z.
/// @throws InvalidInput for another extension, OutputError.
void write_points(const std::filesystem::path& file, const NumberedPoints& points);

}  // namespace strake
