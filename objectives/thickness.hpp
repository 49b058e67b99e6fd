#pragma once
#include "objectives/quantity.hpp"

#include <filesystem>

/// Thickness of the body along given lines: room for a spar, a tank, a tool.
namespace strake {

struct ThicknessLine {
    Eigen::Vector3d at, direction;  ///< any length but zero
    std::optional<double> wanted;   ///< for fits, > 0, length
    long line = 0;                  ///< of the file, for messages; 0: none
};

enum class ThicknessValues {
    each,     ///< one value per line, named NAME.1, NAME.2, ...
    smallest  ///< one value, NAME: the smallest; its gradient is that of the line which has it
};

/// The distance, length, between the two crossings of each line with the surface: the nearest one on either side of
/// the point, or the two nearest where all lie on one side. With s the place along the unit direction d,
/// ds/dv_k = b_k N_k / (N . d) at each crossing, b its barycentric coordinates and N the triangle's normal.
/// Residuals (where every line has `wanted`): (thickness - wanted) / sqrt(number of lines).
/// A deformed surface with fewer than two crossings gives a failure of kind `undefined`.
/// @throws InvalidInput (with the line of the file) when the start has fewer than two, a direction is zero, a number is
/// not finite, only some lines have `wanted`, or there are no lines.
Quantity thickness(const std::string& name, const TriMesh& start, const std::vector<ThicknessLine>& lines,
                   ThicknessValues values);

/// Rows x,y,z,dx,dy,dz[,wanted]. @throws InputError `FILE:LINE: what`.
std::vector<ThicknessLine> read_thickness_lines(const std::filesystem::path& file);

}  // namespace strake
