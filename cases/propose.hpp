#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "core/repair/checkup.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// A case for a surface that nobody has described yet: what `strake init` writes.
namespace strake {

struct ProposalOptions {
    int evaluations = 60;  ///< budget, >= 1
};

/// A guess, with the reason that stands beside it in the file.
struct ProposedRegion {
    std::string name, shape, why;  ///< shape as YAML: "plane: {...}, side: below"
};

struct ProposedCase {
    std::string yaml;                                ///< the whole file, with comments
    std::vector<std::string> found;                  ///< what was guessed, a sentence each
    std::optional<SymmetryPlane> plane;              ///< of the half model, or of the whole one
    Eigen::Vector3d down = Eigen::Vector3d::Zero();  ///< on what the body seems to stand; zero: not known
    bool has_volume = false;
};

/// Proposes a case for the surface in `file`: its repairs (only what it needs), symmetry (of a half model with an open
/// plane, or mirrored variables of a whole one), something to hold every part (the band beside the symmetry plane, a
/// flat end, a border, else the end of the longest axis), crease angle and number of patches, a thickness, and
/// volume as the objective (area where nothing encloses a volume).
/// @param case_file where the text will stand: paths in it are relative to its folder.
/// @throws InputError: the surface cannot be read, or no repair would make it fit for use; the text says what to do.
ProposedCase propose_case(const std::filesystem::path& file, const std::filesystem::path& case_file,
                          const ProposalOptions& options = {});

}  // namespace strake
