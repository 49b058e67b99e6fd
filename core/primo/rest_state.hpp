#pragma once
#include "core/mesh/adjacency.hpp"
#include "core/primo/shell_types.hpp"

#include <array>

/// The undeformed shell: prisms, the faces they share, and the map from prisms to vertices. Everything here
/// is constant during a solve. Prism i stands on triangle i; points are stored as arms from its rest centroid.
namespace strake {

/// Vectors at the 2 x 2 Gauss points of a prism's face, component by component: four lanes.
struct Quad {
    double x[4] = {}, y[4] = {}, z[4] = {};
    Eigen::Vector3d operator[](int g) const { return {x[g], y[g], z[g]}; }
    void set(int g, const Eigen::Vector3d& v) { x[g] = v.x(), y[g] = v.y(), z[g] = v.z(); }
};
using Arms = Quad;

/// The face that prisms i and j share, Eqs. (3)-(5): E = w/4 sum_g |y_i(g) - y_j(g)|^2. The integrand is biquadratic:
/// four Gauss points are exact (the bilinear mass matrix M_kl gives the same number).
struct SharedFace {
    int i, j;
    double weight;  ///< w_ij = |e|^2 / (A_i + A_j)
    Arms arm_i, arm_j;
    std::array<int, 2> vertex;              ///< ends of the edge
    std::array<Eigen::Vector3d, 2> normal;  ///< direction of extrusion at each end
};

/// A boundary face on the symmetry plane and its mirror image: E = w/2 sum_g (n . (y(g) - X(g)))^2, half of the pair's
/// energy.
struct MirroredFace {
    int i;
    double weight;  ///< w_s = |e|^2 / (2 A_i)
    Arms arm;
    std::array<int, 2> vertex;
    std::array<Eigen::Vector3d, 2> normal;
};

/// Gauss coordinates along the edge (u) and through the thickness (z) of point g = 2 a + b.
struct GaussPoint {
    double u, z;
};
const std::array<GaussPoint, 4>& gauss_points();

/// Sums of face contributions to prisms on several threads: groups of consecutive faces. A group writes directly to
/// prisms without a face in an earlier group and stores its contributions to others separately, in the order of the
/// prisms.
struct FaceGroups {
    static constexpr int faces = 4096, prisms = 1024;  ///< in a group
    std::vector<std::array<int, 2>> apart;             ///< per face, of its prisms i and j: place in `prism`, or -1
    std::vector<int> prism;                            ///< ascending
    std::vector<int> begin;                            ///< into `prism`, per group of prisms, and the end
};

struct RestState {
    TriMesh mesh;
    double diagonal = 0;
    Points centroid;               ///< m x 3
    Eigen::VectorXd area;          ///< m
    Eigen::VectorXd height;        ///< per vertex
    Eigen::VectorXd prism_height;  ///< m: mean of the three
    Eigen::VectorXd prism_radius;  ///< m: largest distance of a prism corner from the centroid
    Points normal;                 ///< per vertex, unit; zero where the triangles' normals cancel
    std::vector<int> pin;          ///< m
    std::vector<int> free_index;   ///< m: number among the free prisms, -1 if pinned
    std::vector<int> free_prisms;  ///< in the order of their numbers
    std::vector<SharedFace> faces;
    std::vector<MirroredFace> mirrored;
    FaceGroups face_groups;
    IntLists prism_vertices;                      ///< vertices driven by a prism
    IntLists vertex_prisms;                       ///< prisms that drive a vertex; none: it stays (fixed, or unused)
    std::vector<char> fixed_vertex;               ///< copied from the start
    std::vector<char> on_plane;                   ///< vertex on the symmetry plane: its motion is projected into it
    std::shared_ptr<const Attachments> attached;  ///< null: none
    std::optional<SymmetryPlane> symmetry;
    Eigen::Matrix3d plane_projector = Eigen::Matrix3d::Identity();  ///< I - n n^T

    int num_prisms() const { return static_cast<int>(pin.size()); }
    int num_free() const { return static_cast<int>(free_prisms.size()); }
    /// Arm of vertex k in prism i at rest.
    Eigen::Vector3d vertex_arm(int k, int i) const { return (mesh.vertices.row(k) - centroid.row(i)).transpose(); }
};

/// Unit direction along which prism i stands at vertex v: the vertex normal, or the normal of triangle i where normals
/// cancel.
Eigen::Vector3d corner_normal(const RestState& rest, int v, int i);

/// Fills `face_groups` and `prism_vertices` from `faces` and `vertex_prisms`.
void list_by_prism(RestState& rest);

/// @throws InvalidInput like PrimoShell's constructor.
RestState rest_state(const TriMesh& mesh, const ShellOptions& options);

}  // namespace strake
