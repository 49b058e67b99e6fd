#pragma once
#include "objectives/aero/stream.hpp"

namespace strake {

/// Area of the surface's silhouette seen along the stream, length^2: the frontal area for a stream along x, the plan
/// area for one along z. Exact where parts hide others; an open surface counts the side that faces the stream. A half
/// model gives the silhouette of the half. Continuous; kinks as in `VisibleAreas`, and where a face is exactly edge-on
/// to the stream.
/// @throws InvalidInput as `check_stream`.
Quantity projected_area(const std::string& name, const TriMesh& start, const Stream& stream);

}  // namespace strake
