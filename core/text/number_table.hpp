#pragma once
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

}  // namespace strake
