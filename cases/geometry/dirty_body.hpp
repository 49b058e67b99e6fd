#pragma once
#include "core/mesh/mesh.hpp"

#include <string>
#include <vector>

/// Bodies as converters and old programs leave them: of parts that pass through each other, of slivers, with gaps,
/// holes, doubled and flipped faces. Each kind has one defect that is typical of a source; the seed places the parts
/// and the defects.
namespace strake::example {

/// crossing_boxes, crossing_cylinders, wing_through_body, cad_slivers, gaps, t_junctions, flipped_parts, doubled_faces,
/// holes, inner_walls, zero_areas, rough_cut.
const std::vector<std::string>& dirty_body_kinds();

/// About 4 long in x, 500 to 4 000 triangles; rough_cut is the half y > 0 of a body, cut planar to 4e-5 of its
/// diagonal only. The same kind and seed give the same bits. @throws InvalidInput: no such kind.
TriMesh dirty_body(const std::string& kind, unsigned seed = 1);

}  // namespace strake::example
