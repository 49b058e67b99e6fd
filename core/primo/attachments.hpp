#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// Disconnected parts that follow the rest of the surface, for example a nacelle under a wing. They are not unknowns of
/// the shell: their positions follow from their hosts'.
namespace strake {

enum class AttachHow {
    rigid,  ///< as a rigid body, by the best-fit motion of the nearby host
    follow  ///< the same, plus the host's local deformation beyond that motion
};

struct AttachedPart {
    std::string name;            ///< for messages
    std::vector<int> triangles;  ///< the moving triangles: whole connected parts
    std::vector<int> host;       ///< the triangles that it follows
    AttachHow how = AttachHow::rigid;
};

/// Positions of the attached vertices as a function of the others, with exact derivatives. With X_i the host's vertices
/// at rest, x_i their current positions and w_i = (their share of the host's area) phi(d_i / reach), d_i the distance
/// of X_i from the part at rest, phi(s) = (1 - s)^4 (4 s + 1) below 1, the motion R, c of a part minimizes
///     sum_i w_i |x_i - c - R (X_i - C)|^2,    C = sum_i w_i X_i / sum_i w_i      (Kabsch 1976),
/// and a vertex P goes to c + R (P - C + S(P) u), where S = 0 for `rigid`; for `follow`, S is the `SurfaceMap` of the
/// host and u_i = R^T (x_i - c) - (X_i - C) the host's deformation beyond that motion. Rigid motions of the host of any
/// size are followed exactly. The reach is 1.5 times the distance of the host plus half the diagonal of the part. For a
/// half model the mirror image of the host joins the fit; a part that reaches the plane stays on it.
class Attachments {
public:
    /// @throws InvalidInput: an empty part or host, triangles out of range, in two parts, or in a part and its own
    /// host; a part that shares vertices with other triangles; parts that follow each other in a circle; a host too
    /// narrow to define a rotation (all on one line).
    Attachments(const TriMesh& rest, const std::vector<AttachedPart>& parts,
                const std::optional<SymmetryPlane>& symmetry = {});
    ~Attachments();
    Attachments(Attachments&&) noexcept;
    Attachments& operator=(Attachments&&) noexcept;

    const std::vector<int>& part_of() const;  ///< per triangle: number of the part, -1 for those of the shell

    /// Places the attached rows of `vertices` (n x 3) by the others.
    void place(Points& vertices) const;
    /// The same for changes `rates` (n x 3) of already placed `vertices`.
    void place_rates(const Points& vertices, Points& rates) const;
    /// dJ/dv of the shell's vertices, from dJ/dv of all; sets the attached rows to zero. The transpose of
    /// `place_rates`.
    void pull_back(const Points& vertices, Points& dJ_dv) const;
    /// Rotation of each part, from already placed `vertices`.
    std::vector<Eigen::Quaterniond> rotations(const Points& vertices) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
