#pragma once
#include "casefile/propose/propose.hpp"

/// The parts of propose_case. Between its files; not for others.
namespace strake::proposing {

/// Halving of long edges where parts pass through each other (`repair.joints`), as a test bend shows it.
struct JointTrial {
    double percent = 0;            ///< of the diagonal: edges that are left
    double before = 0, after = 0;  ///< largest gap of a joint, diagonals
    int triangles = 0;             ///< with them
};
/// Bends the body by 5 % of its diagonal, as it is and with edges of 1 % or else 2 % of the diagonal at its joints.
/// None where joints stay closed as they are, or halved edges do not close them to a tenth without multiplying
/// triangles.
/// @param pairs that intersect, none where they are not known
std::optional<JointTrial> tried_joints(const TriMesh& mesh, const std::optional<Intersections>& pairs);

/// "a bend of 5 % of the diagonal opens joints by 2.1e-06 of it (0.0032 as they are); 13599 triangles"
std::string joint_words(const JointTrial& tried);

/// The repairs that a surface needs before it can be deformed (entries of `repair:`), and the result.
struct RepairedSurface {
    std::vector<std::string> keys;  ///< "holes: 19%"; empty: none needed
    std::vector<std::string> why;   ///< one per key
    TriMesh mesh;
    Checkup checkup;
    bool couple = false;               ///< edges with more than two triangles remain
    std::optional<JointTrial> joints;  ///< what new vertices would do, or do where `has_new_vertices`
    bool has_new_vertices = false;     ///< they are among the keys
};
/// Debris is dropped first. @throws InputError if no repair helps.
RepairedSurface repaired(const std::filesystem::path& file, TriMesh mesh);

/// Pieces of a few triangles away from everything else, open, of next to no area and without a name of their own: what
/// an export left behind. They say nothing about the body, but would turn its plane of symmetry, and leave it without a
/// volume.
struct Debris {
    int pieces = 0, triangles = 0;
    double share = 0;             ///< of the area
    double min_area_percent = 0;  ///< `repair.components.min_area` that drops them and nothing else
};
/// None where a limit on the area would drop other pieces as well.
std::optional<Debris> debris(const TriMesh& mesh);

/// The surface as it is for displacement fields, which need no repair but that its triangles agree on what is outside;
/// debris is dropped.
/// @param adds_vertices where parts pass through each other and `tried_joints` says that it pays
RepairedSurface as_it_is(TriMesh mesh, bool adds_vertices);

/// The plane of a half model: the coordinate plane in which its open boundary lies. None for the mouth of a vessel,
/// beyond which the body reaches to all sides.
std::optional<SymmetryPlane> half_plane(const Checkup& checkup, const TriMesh& mesh);
/// A half whose cut is not quite planar: `symmetry.snap` moves it onto the plane.
struct NearCut {
    SymmetryPlane plane;
    double percent = 0;    ///< of the diagonal, for `symmetry.snap`
    double deviation = 0;  ///< largest distance of its edges from the plane
};
/// The largest open border, where it lies within 1e-4 of the diagonal of a coordinate plane, but not of 1e-6, with all
/// of the surface on one side.
std::optional<NearCut> near_cut(const TriMesh& mesh);

/// Every open edge lies on the plane, and neighbours agree.
bool encloses_volume(const RepairedSurface& surface, const std::optional<SymmetryPlane>& plane);

/// What a connected part of a surface does.
struct PartRole {
    enum class Kind { main, moves, attached, held };
    int component = 0;
    Kind role = Kind::held;
    std::string name;       ///< that of the file where it names this part alone, else part_N
    bool is_named = false;  ///< by the file
    double area = 0;
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
    int host = -1;   ///< the part nearest to it that moves; -1: none
    double gap = 0;  ///< its distance from there
    int image = -1;  ///< the part that is its mirror image; -1: none
};
/// The main part has the largest area. Others with a twentieth of that move, unless they are far away and smaller than
/// half of it; smaller ones, and those named as what hangs on others (nacelle, store), are attached to what they are
/// near, else held, as what is named as a support is.
std::vector<PartRole> part_roles(const TriMesh& mesh, const std::vector<int>& component, double diagonal,
                                 const std::optional<SymmetryPlane>& mirror);

struct ProposedHolds {
    std::vector<ProposedRegion> regions;             ///< that hold every part which is not attached
    std::vector<PartRole> parts;                     ///< of a surface of several
    Eigen::Vector3d down = Eigen::Vector3d::Zero();  ///< outward, of the flat end that is held; or zero
    /// A part that carries area lies along another and is held there over its length, or lies beside it and is held
    /// elsewhere alone: a shell of each would not keep the joint, or not move it.
    bool ties_parts = false;
};
ProposedHolds held_regions(const RepairedSurface& surface, const std::optional<SymmetryPlane>& half,
                           const std::optional<SymmetryPlane>& mirror);

struct CreaseAngles {
    int sharp_deg = 40;                           ///< the emptiest angle between 20 and 53 degrees
    std::vector<double> shares;                   ///< of the length of all edges, by `limits_deg`
    std::vector<double> limits_deg;               ///< one more than shares
    std::vector<std::pair<double, int>> patches;  ///< crease angle, and the number of patches from creases alone
};
CreaseAngles crease_angles(const TriMesh& mesh, const Adjacency& adjacent);

/// The unit that the head of the file states ("units: mm"); empty: it does not.
std::string stated_units(const std::filesystem::path& file);

std::string plane_text(const Eigen::Vector3d& normal, double at);  ///< "{normal: [0, 1, 0], at: 0.05}"
char axis_letter(const Eigen::Vector3d& normal);                   ///< x, y, z; 0: none of them

}  // namespace strake::proposing
