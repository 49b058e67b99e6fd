#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// Parts that nothing connects to the rest of the surface and that go with it all the same: a nacelle under a wing.
/// They are no unknowns of the shell; where they are follows from where their hosts are.
namespace strake {

enum class AttachHow {
    rigid,  ///< as a whole, by the best-fit rigid motion of the host near it
    follow  ///< the same, and every vertex with what the host's closest places do beyond that motion
};

struct AttachedPart {
    std::string name;            ///< for messages
    std::vector<int> triangles;  ///< what moves: whole connected parts
    std::vector<int> host;       ///< the triangles that it goes with
    AttachHow how = AttachHow::rigid;
};

/// Places of the attached vertices as a function of the others, and its exact derivatives. With X_i the host's vertices
/// at rest, x_i where they are and w_i = (their share of the host's area) phi(d_i / reach), d_i the distance of X_i
/// from the part at rest, phi(s) = (1 - s)^4 (4 s + 1) below 1, the motion of a part is R, c that minimise
///     sum_i w_i |x_i - c - R (X_i - C)|^2,    C = sum_i w_i X_i / sum_i w_i      (Kabsch 1976),
/// and a vertex P goes to c + R (P - C + S(P) u), where S = 0 for `rigid`; for `follow`, S is the `SurfaceMap` of the
/// host and u_i = R^T (x_i - c) - (X_i - C) what the host does beyond that motion. Rigid motions of the host are
/// followed exactly, however large. The reach is 1.5 times the distance of the host plus half the diagonal of the part.
/// Of half a body the mirror image of the host takes part in the fit; a part that reaches the plane stays on it.
class Attachments {
public:
    /// @throws InvalidInput: an empty part or host, triangles out of range, in two parts, or in a part and its own
    /// host; a part that shares vertices with other triangles; parts that go with each other in a circle; a host too
    /// narrow to turn with (all of it on one line).
    Attachments(const TriMesh& rest, const std::vector<AttachedPart>& parts,
                const std::optional<SymmetryPlane>& symmetry = {});
    ~Attachments();
    Attachments(Attachments&&) noexcept;
    Attachments& operator=(Attachments&&) noexcept;

    const std::vector<int>& part_of() const;  ///< per triangle: number of the part, -1 for those of the shell

    /// Moves the attached rows of `vertices` (n x 3) to where the others take them.
    void place(Points& vertices) const;
    /// The same for changes `rates` (n x 3) of `vertices`, which are placed already.
    void place_rates(const Points& vertices, Points& rates) const;
    /// dJ/dv of the shell's vertices, from that of all; the attached rows become zero. The transpose of `place_rates`.
    void pull_back(const Points& vertices, Points& dJ_dv) const;
    /// Rotation of each part; `vertices` are placed already.
    std::vector<Eigen::Quaterniond> rotations(const Points& vertices) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
