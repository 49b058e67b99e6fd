#pragma once
#include "core/formats/vtp.hpp"
#include "core/mesh/symmetry_plane.hpp"
#include "core/mesh/topology.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

/// Everything that `strake info` tells of a surface. Nothing here throws because of a defect.
namespace strake {

struct BoundaryLoop {
    std::vector<int> vertices;  ///< as TopologyFacts::boundary_loops
    double length = 0;          ///< of its open edges
    double size = 0;            ///< diagonal of its box
    Eigen::Vector3d center = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();  ///< of the plane nearest to it
    double deviation = 0;    ///< largest distance from that plane
    bool is_planar = false;  ///< deviation <= 1e-6 of the surface's diagonal
    int symmetry_axis = -1;  ///< 0, 1, 2: the plane is x, y, z = constant, and all of the surface on one side of it
    double symmetry_at = 0;  ///< that constant
};

/// One a connected boundary, in the order of TopologyFacts.
std::vector<BoundaryLoop> measured_loops(const TriMesh& mesh, const Adjacency& adjacent,
                                         const std::vector<std::vector<int>>& loops);

/// The plane at which half a body is cut, from the loops of its surface: all loops that lie in a coordinate plane with
/// the body on one side lie in this one, and the surface meets it at a right angle, as one that is continued by its
/// mirror image does without a crease. Nothing where there is none.
std::optional<SymmetryPlane> cut_of_half(const TriMesh& mesh, const Adjacency& adjacent,
                                         const std::vector<BoundaryLoop>& loops);
/// "half a body? Then add to the case symmetry: {plane: y, at: 0}".
std::string half_words(const SymmetryPlane& plane);

struct Histogram {
    std::vector<double> limits;  ///< k + 1, ascending
    std::vector<int> counts;     ///< k; a value at a limit belongs to the upper bin, the last limit to the last bin
};

struct SurfaceQuality {
    double edge_min = 0, edge_mean = 0, edge_max = 0, edge_median = 0;
    double angle_min_deg = 0, angle_max_deg = 0;
    int max_valence = 0;                                  ///< triangles at a vertex
    double mean = 0, smallest = 0, fifth_percentile = 0;  ///< 2 inradius / circumradius of the triangles
    Histogram angles_deg, ratios, edges;                  ///< corners, triangles, edges (in mean lengths)
};
SurfaceQuality surface_quality(const TriMesh& mesh, const Adjacency& adjacent);

struct Checkup {
    int vertices = 0, triangles = 0;
    Adjacency adjacent;
    TopologyFacts facts;
    std::vector<BoundaryLoop> loops;
    std::vector<int> crack_vertices;  ///< open-edge vertices within 1e-6 of the diagonal of another, ascending
    /// Folded over: an edge of two agreeing triangles with a dihedral above 170 degrees, and the normal against the sum
    /// of the three vertices' mean normals by more than 0.5. A knife edge is none: its mean normals vanish.
    std::vector<int> inverted_triangles;
    std::optional<Intersections> pairs;  ///< none: too many pairs around a vertex to test
    Box box{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    double diagonal = 0, area = 0, volume = 0;  ///< volume: of closed surfaces
    int inward_components = 0;                  ///< closed components of negative volume
    SurfaceQuality quality;
};
/// @throws InvalidInput on an index out of range or a coordinate that is not finite.
Checkup checkup(const TriMesh& mesh);

/// One sentence per defect, with the first few numbers.
std::vector<std::string> defects_in_words(const TriMesh& mesh, const Checkup& found);
/// Advice: helpful options of `strake repair`, and defects that it cannot repair; empty: none.
std::vector<std::string> advice(const TriMesh& mesh, const Checkup& found);

/// Every defect marked, for ParaView.
struct DefectFields {
    std::vector<Field> points, cells;
};
DefectFields defect_fields(const TriMesh& mesh, const Checkup& found);

}  // namespace strake
