#pragma once
#include "casefile/build/regions.hpp"
#include "core/planform/wing.hpp"

#include <memory>

namespace strake {

/// @param triangles of the wing, ascending; empty: the whole surface. @throws InvalidInput as Wing.
std::shared_ptr<const Wing> make_wing(const WingEntry& entry, const WingSetup& setup, const TriMesh& start,
                                      std::vector<int> triangles);

/// The triangles of a region of a wing.
std::vector<int> wing_region(const Wing& wing, const WingRegion& part, const TriMesh& start);

}  // namespace strake
