#pragma once
#include "core/mesh/mesh.hpp"

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

/// Small tables of numbers: measured points, lines of thickness.
namespace strake {

struct TableRow {
    std::vector<double> values;
    long line = 0;  ///< in the file, from 1
};

/// Rows of numbers separated by commas, semicolons or blanks; `#` starts a comment, and a first row that begins with a
/// letter is a header. @param columns their names as messages show them; the first `required` must be there.
/// @throws InputError `FILE:LINE: what` for a file that cannot be read, is empty, or holds a row of another length or a
/// number that is not finite.
std::vector<TableRow> read_table(const std::filesystem::path& file, const std::vector<std::string>& columns,
                                 int required);

/// n x 3 coordinates from a list (.csv, .txt, .xyz: rows x,y,z as `read_table`; .npy: `parse_npy`), or the vertices of
/// a surface file in any format that is read. @throws InputError as the readers; a coordinate that is not finite (row).
Points read_points(const std::filesystem::path& file);
bool is_point_list(const std::filesystem::path& file);  ///< by its extension: a list, no surface

/// As .npy (double precision), or text with the header x,y,z and numbers that read back to the same bits.
/// @throws InvalidInput for another extension, OutputError.
void write_points(const std::filesystem::path& file, const Points& points);

}  // namespace strake
