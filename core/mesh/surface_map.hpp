#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <memory>
#include <optional>

/// Maps displacements of the surface to other points (a solver's boundary or volume mesh) and sensitivities back.
namespace strake {

struct SurfaceMapOptions {
    double reach = 1;  ///< distance from the surface beyond which nothing moves, in diagonals of the surface, > 0
    std::optional<SymmetryPlane> symmetry;  ///< the surface is half a body: points on the plane stay on it
};

/// A map that is linear in the displacement of the vertices, made once for a surface and points at rest; its transpose
/// carries sensitivities back exactly. With d the distance of a point p from the surface, q the closest point, h the
/// edge length there, w_i the rotation vector at i (`LocalRotation`), and v_k, b_k, G_k the corners of the closest
/// triangle, the barycentric coordinates of q and the gradients of the displacement
/// (`LocalGradient`):
///   u(p) = psi(d / reach) ((1 - s) near(p) + s far(p)),   s = smoothstep(d / h)
///   near(p) = sum_k b_k (u_k + G_k (q - v_k) / 2 + w_k x (p - q))                 exact at the vertices, to second
///             order between them: finer surfaces move smoothly, not faceted like the coarse one
///   far(p)  = sum_i a_i phi(|p - r_i| / R) (u_i + w_i x (p - r_i)) / sum_i a_i phi(|p - r_i| / R)
///   psi(x) = phi(x) = (1 - x)^4 (4 x + 1) for x < 1, else 0                        (Wendland 1995, C2)
/// The r_i are centroids of the vertices in cells of edge h_l, with mean displacement and rotation, areas a_i, and
/// R = 1.5 times the distance of the nearest + h_l; two levels of cells with h_l <= d < 2 h_l are blended. This is
/// inverse-distance weighting with rotations (Luke, Collins & Blades, J. Comput. Phys. 231, 2012) with compact weights.
/// u is continuous except at points nearer than h that are equidistant from two parts of the surface. It reproduces
/// infinitesimal rigid motions exactly (times psi).
class SurfaceMap {
public:
    /// @param rest n vertices. @param points P x 3, anywhere.
    /// @throws InvalidInput: a surface without area, a point that is not finite (which), a reach <= 0.
    SurfaceMap(const TriMesh& rest, const Points& points, const SurfaceMapOptions& options = {});
    ~SurfaceMap();
    SurfaceMap(SurfaceMap&&) noexcept;
    SurfaceMap& operator=(SurfaceMap&&) noexcept;

    int num_vertices() const;
    int num_points() const;
    const Eigen::VectorXd& distances() const;  ///< of the points from the surface at rest, P

    /// Displacements of the points (P x 3) from those of the vertices (n x 3).
    Points apply(const Points& displacement) const;
    /// dJ/dv (n x 3) from the sensitivities at the points (P x 3): <g, apply(u)> = <transpose(g), u>.
    Points transpose(const Points& sensitivities) const;
    /// Points for these vertices (n x 3). Points that coincide with vertices at rest get exactly their coordinates.
    Points moved(const Points& vertices) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
