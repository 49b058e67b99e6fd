#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <optional>
#include <string>
#include <vector>

/// A wrap around a dirty body: a closed, manifold, even surface that follows it from outside. An elastic shell stands
/// on the wrap where it cannot stand on the body; `WrapBinding` carries the body along.
///
///     const Wrap wrap = wrap_around(body);
///     const WrapBinding binding(wrap.mesh, body.vertices);
namespace strake {

struct WrapOptions {
    double alpha = 0;         ///< what is narrower is bridged; length; 0: a fiftieth of the diagonal
    double offset = 0;        ///< distance from the body; 0: alpha / 2.5
    double edge_length = 0;   ///< of the wrap's triangles; 0: 0.6 alpha
    double max_seconds = 20;  ///< of CPU, of one attempt to wrap; > 0, may be infinite: no limit
    int max_attempts = 3;     ///< alpha is doubled after one that fails; >= 1
    /// The wrap is symmetric about this plane, by construction: one half of it is mirrored.
    std::optional<SymmetryPlane> plane = {};
    /// The body is a half that ends on the plane, and so is the wrap: open there, its border exactly on the plane.
    bool is_half = false;
};
void validate(const WrapOptions& options);  ///< throws InvalidInput: field, value, limit

struct Wrap {
    TriMesh mesh;
    double alpha = 0, offset = 0, edge_length = 0;  ///< in use at the end
    int genus = 0;                                  ///< of the wrap: its handles
    double area_ratio = 0;                          ///< area of the wrap over that of the body with caps
    int capped_holes = 0;                           ///< open borders of the body, closed for the wrap alone
    int attempts = 1;                               ///< alpha is doubled after one that fails
    std::vector<std::string> notes;                 ///< what was doubled, and why
    double wrap_seconds = 0, remesh_seconds = 0;
};

/// CGAL's alpha wrap of the body, whose open borders are closed by fans from their middles (in the input of the wrap
/// only: a hole wider than alpha would let the wrap inside), remeshed by `remesh`.
/// Of a half the whole is wrapped, and clipped at the plane.
/// Accepted is a wrap in one piece, of at most 12 handles and 1.45 times the area of the body (more: it went inside),
/// whose new triangles do not intersect; else, and when it takes longer than `max_seconds`, alpha, offset and edge
/// length are doubled, up to twice (`max_attempts`).
/// @throws InvalidInput: a bad option, a body without triangles or area, a build without alpha wrap; none of the
/// attempts gave a wrap (what each of them gave).
Wrap wrap_around(const TriMesh& body, const WrapOptions& options = {});

/// The body with each open border closed by a fan, and their number.
TriMesh with_caps(const TriMesh& body, int& caps);

}  // namespace strake
