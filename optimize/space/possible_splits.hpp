#pragma once
#include "optimize/space/refinement.hpp"

/// What a refinement can split or take. Internal.
namespace strake {

/// Parts of patches: the front that they are parts of, and of which of its patches each is one.
struct PartsOfPatches {
    const DesignSpace& child;
    const Front& above;
    std::vector<int> owner;  ///< by the child's patches

    PartsOfPatches(const DesignSpace& parts, const Front& front);
};

/// Patches that have to be split together because variables tie their children, or themselves: per patch of the front
/// above the first of its group.
/// @param parent whose front the patches are; null: no space has them
std::vector<int> split_groups(const DesignSpace* parent, const PartsOfPatches& parts);

/// A split each for the fields that the child has and the parent has not.
void offer_fields(const DesignSpace& parent, const DesignSpace& child, std::vector<SplitDecrease>& splits);

/// Splits of the patches of the last front that is passed, in the order of their first patch; fields come last.
std::vector<SplitDecrease> possible_splits(const DesignSpace& parent, const DesignSpace& child,
                                           const std::vector<Front>& passed);

/// The space's patches with the chosen ones of the last front split, and those of the fronts before it of which these
/// are parts; and its fields with these.
LevelSet refined(const DesignSpace& space, const std::vector<Front>& passed, std::vector<char> chosen,
                 const std::vector<int>& fields);

/// The fields of a space with these, and all that were offered.
FieldSet with_fields(const DesignSpace& space, const std::vector<int>& fields);

}  // namespace strake
