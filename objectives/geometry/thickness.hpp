#pragma once
#include "objectives/quantity/quantity.hpp"

#include <filesystem>

/// Thickness of the body along given lines: room for a spar, a tank, a tool.
namespace strake {

struct ThicknessLine {
    Eigen::Vector3d at, direction;  ///< any nonzero length
    std::optional<double> target;   ///< for fits, > 0, length
    long line = 0;                  ///< of the file, for messages; 0: none
};

enum class ThicknessValues {
    each,     ///< one value per line, named NAME.1, NAME.2, ...
    smallest  ///< one value, NAME: the smallest, with the gradient of its line
};

/// The distance, length, between the two crossings of each line with the surface: the nearest one on either side of
/// the point, or the two nearest where all lie on one side. With s the position along the unit direction d,
/// ds/dv_k = b_k N_k / (N . d) at each crossing, b its barycentric coordinates and N the triangle's normal.
/// Residuals (where every line has `target`): (thickness - target) / sqrt(number of lines).
/// `evaluate` fails with kind `undefined` on a surface with fewer than two crossings.
/// @throws InvalidInput (with the line of the file): fewer than two crossings at the start; a zero direction; a number
/// that is not finite; a `target` on only some lines; no lines.
Quantity thickness(const std::string& name, const TriMesh& start, const std::vector<ThicknessLine>& lines,
                   ThicknessValues values);

/// Rows x,y,z,dx,dy,dz[,target]. @throws InputError `FILE:LINE: what`.
std::vector<ThicknessLine> read_thickness_lines(const std::filesystem::path& file);

}  // namespace strake
