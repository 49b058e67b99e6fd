#pragma once
#include "core/mesh/adjacency.hpp"
#include "core/wrap/wrap.hpp"
#include "core/wrap/wrap_binding.hpp"

/// A wrap and the body in it: what is elastic, and what it carries along.
namespace strake {

struct WrapMapOptions {
    std::vector<char> held = {};  ///< per vertex of the body: stays where it is; empty: none
    /// The wrap is symmetric about this plane.
    std::optional<SymmetryPlane> plane = {};
    bool is_half = false;  ///< wrap and body are halves that end on the plane
    RadialSums sums = RadialSums::by_boxes;
    int max_centers = WrapBindingOptions().max_centers;
};

class WrapMap {
public:
    /// @throws InvalidInput as `WrapBinding`; a wrap that is not symmetric about its plane.
    WrapMap(TriMesh wrap, const TriMesh& body, const WrapMapOptions& options = {});

    const TriMesh& mesh() const { return mesh_; }
    const Adjacency& adjacent() const { return adjacent_; }
    const std::vector<char>& held() const { return held_; }  ///< per vertex of the body
    const WrapBinding& binding() const { return binding_; }

    /// B u: the body's displacement (N x 3) by that of the wrap's vertices (n x 3); of halves the mirror image of the
    /// wrap moves as well, and vertices of the body on the plane stay on it. B 0 is 0, bit for bit.
    Points displacement(const Points& of_wrap) const;
    /// B^T g, its exact transpose; of several functionals at once for less.
    Points transpose(const Points& of_body) const;
    std::vector<Points> transpose(const std::vector<Points>& of_body) const;
    /// Of functionals of one vertex of the body each (`WrapBinding::transpose_at`).
    std::vector<Points> transpose_at(const std::vector<int>& vertex, const Points& of_body) const;
    /// Per triangle of the body: the linear part of the motion at its middle (`WrapBinding::local_maps`); I where all
    /// of its vertices are held.
    std::vector<Eigen::Matrix3d> local_maps(const Points& of_wrap) const;
    /// Adds what they are beside I to maps of the same triangles.
    void add_to_maps(const Points& of_wrap, std::vector<Eigen::Matrix3d>& maps) const;

    /// Per triangle of the body the nearest of the wrap, and the other way round, by their middles.
    const std::vector<int>& wrap_triangle() const { return wrap_triangle_; }
    const std::vector<int>& body_triangle() const { return body_triangle_; }
    /// Triangles of the wrap whose nearest triangle of the body is listed, ascending; of a list that is not empty never
    /// none: at least those nearest to it.
    std::vector<int> carried(const std::vector<int>& body_triangles) const;

private:
    Points both(const Points& of_half) const;
    std::vector<Points> folded(std::vector<Points> of_both) const;
    void set_held_triangles(const TriMesh& body);
    bool is_held_triangle(Eigen::Index t) const {
        return !is_held_triangle_.empty() && is_held_triangle_[static_cast<std::size_t>(t)];
    }

    TriMesh mesh_;
    Adjacency adjacent_;
    std::vector<char> held_;
    std::vector<char> is_held_triangle_;      ///< all of its vertices are; empty: none
    std::optional<SymmetryPlane> half_;       ///< of halves
    std::vector<int> image_;                  ///< per vertex of the wrap, or of its whole
    std::vector<int> on_plane_;               ///< vertices of the body, of halves
    WrapBinding binding_;                     ///< to the whole wrap
    std::shared_ptr<const CellSums> middle_;  ///< of the body's triangles
    std::vector<int> wrap_triangle_, body_triangle_;
};

/// Per triangle of one surface the nearest of another, by its middle.
std::vector<int> nearest_triangles(const TriMesh& from, const TriMesh& to);

/// Where a body is thinner than its wrap can follow: both of its sides move together there.
struct ThinPlaces {
    double share = 0;                              ///< of the body's area, in [0, 1]
    Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< middle of the largest such triangle
};
/// Of triangles whose inner side (away from the wrap) meets the opposite side of the body in a ball of diameter `than`.
/// At most `samples` triangles are looked at, spread over the numbering.
ThinPlaces thinner_than(const TriMesh& body, const TriMesh& wrap, double than, int samples = 4000);

}  // namespace strake
