#pragma once
#include "casefile/build/regions.hpp"

/// What regions are chosen on, without the rest of the problem: for tools in which they are pointed at.
namespace strake {

struct RegionGround {
    StartSurface start;   ///< repaired and remeshed as the case says
    PatchHierarchy tree;  ///< whose patches regions may name
    std::vector<std::string> notes, warnings;
};

/// The very surface and patches that `build_problem` evaluates the regions of this case on, patches also where no
/// region names one yet. Neither regions nor quantities are looked at: nothing that the case names is executed.
/// @throws as build_problem: InputError (surface file), SurfaceRefused, CaseError.
RegionGround region_ground(const Case& the_case);

}  // namespace strake
