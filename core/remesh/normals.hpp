#pragma once
#include "core/remesh/base_surface.hpp"

/// Reliable normals for the input's triangles. Internal to core/remesh.
namespace strake {

/// Unit normals, area and mean edge; a triangle without a reliable normal takes that of a neighbour.
void find_normals(BaseSurface& base);

/// Slivers with folds that are not features take normals from their surroundings. @param angle of creases, radians
void level_slivers(double angle, BaseSurface& base);

}  // namespace strake
