#pragma once
#include "casefile/model/case.hpp"

/// Which triangles lie in boxes, spheres and half-spaces, or touch them.
namespace strake {

using RegionShape = std::variant<BoxShape, SphereShape, HalfSpace>;

/// Triangles of which all three vertices lie in the shape, or, with `touches`, any point, ascending. Borders are
/// inside, 1e-9 of the diagonal beyond them. @param diagonal of the surface; a radius may be a share of it
std::vector<int> triangles_in(const RegionShape& shape, const TriMesh& mesh, double diagonal, bool touches);

/// The triangle that comes nearest to being in the shape.
struct NearestMiss {
    int triangle = -1;     ///< -1: the surface has none
    double shortfall = 0;  ///< by how much each face of a box, the radius, or the plane would have to move outwards
    int touching = 0;      ///< triangles that `touches` would take
};
/// The first of several; of a shape that holds triangles, one of these with a shortfall of 0.
NearestMiss nearest_miss(const RegionShape& shape, const TriMesh& mesh, double diagonal, bool touches);

/// "triangle 118 comes nearest, and would be inside with radius 0.153 (now 0.12)", and what `touch: any` would take.
std::string miss_words(const RegionShape& shape, const TriMesh& mesh, double diagonal, bool touches);

}  // namespace strake
