#pragma once
#include "casefile/model/case.hpp"
#include "core/planform/wing.hpp"

#include <memory>
#include <vector>

namespace strake {

/// The wings that a case declares, without the rest of its problem. @param surface that of the case, prepared.
/// @throws InvalidInput as Wing; what `region_ground` throws where it is needed: triangles by patches, or by
/// their numbers in the file of a surface that is repaired.
std::vector<std::shared_ptr<const Wing>> declared_wings(const Case& the_case, const TriMesh& surface);

}  // namespace strake
