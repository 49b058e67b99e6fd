#pragma once
#include "casefile/propose/propose.hpp"

/// The parts of propose_case. Between its files; not for others.
namespace strake::proposing {

/// The repairs that a surface needs before it can be deformed (entries of `repair:`), and the result.
struct RepairedSurface {
    std::vector<std::string> keys;  ///< "holes: 19%"; empty: none needed
    std::vector<std::string> why;   ///< one per key
    TriMesh mesh;
    Checkup checkup;
    bool couple = false;  ///< edges with more than two triangles remain
};
/// @throws InputError if no repair helps.
RepairedSurface repaired(const std::filesystem::path& file, TriMesh mesh);

/// The surface as it is for displacement fields, which need no repair but that its triangles agree on what is outside.
RepairedSurface as_it_is(TriMesh mesh);

/// The plane of a half model: the coordinate plane in which its open boundary lies.
std::optional<SymmetryPlane> half_plane(const Checkup& checkup);
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

/// Regions that hold every part of the surface. @param down becomes the outward direction of the flat end that is held,
/// or zero.
std::vector<ProposedRegion> held_regions(const RepairedSurface& surface, const std::optional<SymmetryPlane>& half,
                                         const std::optional<SymmetryPlane>& mirror, Eigen::Vector3d& down);

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
