#pragma once
#include "core/remesh/base_surface.hpp"

/// Normals of the input's triangles, as far as they mean anything. Internal to core/remesh.
namespace strake {

/// Unit normals, area and mean edge; a triangle without a reliable normal has that of one beside it.
void find_normals(BaseSurface& base);

/// Slivers whose folds are no features take normals that fit to what is around them. @param angle of creases, radians
void level_slivers(double angle, BaseSurface& base);

}  // namespace strake
