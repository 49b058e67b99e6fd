#pragma once
#include "objectives/stream.hpp"

namespace strake {

/// Area of the silhouette that the surface shows to a stream, length^2: frontal area for one along x, plan area for one
/// along z. Exact also where parts hide others; open surfaces show what is turned towards the stream. For a half model
/// the half's silhouette. Continuous; kinks as `VisibleAreas` tells, and where a face is exactly edge-on to the stream.
/// @throws InvalidInput as `check_stream`.
Quantity projected_area(const std::string& name, const TriMesh& start, const Stream& stream);

}  // namespace strake
