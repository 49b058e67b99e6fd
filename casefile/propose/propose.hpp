#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "core/repair/checkup.hpp"

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

/// The case that `strake init` writes for a surface.
namespace strake {

/// What keeps the body in its place.
enum class ProposedHold {
    band,   ///< regions that do not move: what a part is mounted by
    point,  ///< one triangle of each part: everything may change but the place and the attitude there
    none    ///< nothing: fields alone, which neither move nor turn the body in the mean
};

/// How the surface is made to move.
enum class ProposedWay {
    shell,           ///< an elastic shell on the surface, mended where it must be
    remeshed_shell,  ///< the same on new triangles
    wrap,            ///< patches of a wrap around the surface as it is, and displacement fields
    fields           ///< displacement fields alone (`shell: none`), on the surface as it is; nothing is held
};

struct ProposalOptions {
    int evaluations = 60;                    ///< budget, >= 1
    ProposedHold hold = ProposedHold::band;  ///< not of `wrap` and `fields`, on the surface as it is
    ProposedWay way = ProposedWay::shell;
    std::string reason;  ///< why this way, for the case and `found`; empty: nothing is said
    /// Of a surface for a shell, as the file has it: minutes of examination would lead to nothing.
    int max_triangles = std::numeric_limits<int>::max();
    /// New vertices are welcome where parts pass through each other, if they keep joints closed (`repair.joints`): of
    /// `wrap` and `fields`.
    bool joints = false;
};

/// A guess, with the reason that is written beside it.
struct ProposedRegion {
    std::string name, shape, why;  ///< shape as YAML: "plane: {...}, side: below"
};

struct ProposedCase {
    std::string yaml;                                ///< the whole file, with comments
    std::vector<std::string> found;                  ///< the guesses, one sentence each
    std::optional<SymmetryPlane> plane;              ///< of the half model, or of the whole one
    Eigen::Vector3d down = Eigen::Vector3d::Zero();  ///< toward the ground, if the body seems to stand; zero: unknown
    int num_triangles = 0;                           ///< of the surface as it would be deformed
    bool has_volume = false;
    bool has_new_vertices = false;  ///< at joints
    bool may_remesh = false;        ///< slivers, and a body that new triangles of the mean edge length can follow
    /// A part that carries area lies along or beside another one, and shells of each keep their joint only where it is
    /// held. What carries both along, a wrap or fields, is better where it is sound.
    bool ties_parts = false;
    bool is_dirty =
        false;  ///< slivers, parts that pierce each other, or edges of more than two triangles, split or not
};

/// Proposes a case for the surface in `file`: its repairs (only what it needs), symmetry (of a half model with an open
/// plane, or mirrored variables of a whole one), something to hold every part (the band beside the symmetry plane, a
/// flat end, a border, else the end of the longest axis), crease angle and number of patches, a thickness, and
/// volume as the objective (area where nothing encloses a volume).
/// @param case_file where the text will stand: paths in it are relative to its folder.
/// @throws InputError: the surface cannot be read, or no repair makes it usable; the text says what to do.
/// InvalidInput: more than `max_triangles`.
ProposedCase propose_case(const std::filesystem::path& file, const std::filesystem::path& case_file,
                          const ProposalOptions& options = {});

}  // namespace strake
