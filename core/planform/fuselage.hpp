#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "core/planform/outline.hpp"

#include <Eigen/Geometry>

#include <optional>
#include <string>
#include <vector>

/// A body by its length: what a designer of fuselages reads from its sections.
namespace strake {

/// How a body is declared.
struct FuselageDeclaration {
    std::string name = "body";
    std::vector<int> triangles = {};  ///< of the surface; empty: all
    /// Unit vectors, perpendicular to each other. `axis` from the nose to the tail.
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX(), up = Eigen::Vector3d::UnitZ();
    std::optional<SymmetryPlane> symmetry = {};              ///< what ends at it is half a body
    std::vector<double> stations = {0, 0.25, 0.5, 0.75, 1};  ///< fractions of the length in [0, 1], ascending
};

/// One section, across the axis. Lengths in the surface's unit.
struct FuselageStation {
    Varying width, height;  ///< extents; the width of half a body counts both sides
    Varying across, up;     ///< of the middle of both extents
    Varying camber;         ///< how high the middle lies above the straight line from nose to tail, over the length
    std::vector<std::vector<std::pair<double, double>>>
        outline;  ///< across and up, coordinates; of half a body that half
};

/// A declared body, measured on any surface of the start's triangles. Nose and tail are the start's foremost and
/// aftmost vertices. Planes are normal to the axis at fractions of the present length, those of nose and tail 0.1 % of
/// it inside.
class Fuselage {
public:
    /// @throws InvalidInput: directions that are not perpendicular, stations outside of [0, 1], triangles out of range,
    /// no extent along the axis, a station without a section.
    Fuselage(const TriMesh& start, const FuselageDeclaration& declaration);

    const FuselageDeclaration& declaration() const { return declared_; }
    Eigen::Vector3d across() const { return declared_.up.cross(declared_.axis); }  ///< unit
    Varying length(const TriMesh& surface, bool sensitivities = false) const;
    /// @throws InvalidInput (with the station) where there is no section.
    FuselageStation station(const TriMesh& surface, double station, bool sensitivities = false) const;
    double nose(const TriMesh& surface) const;  ///< coordinate along the axis

private:
    struct Ends {
        Varying nose, tail, nose_height, tail_height;
    };
    Ends ends(const TriMesh& surface, bool sensitivities) const;

    FuselageDeclaration declared_;
    std::vector<int> nose_, tail_;  ///< vertices, ascending
    double half_ = 0;               ///< 1, -1: only what lies on this side of the plane of symmetry is there
    double plane_ = 0;              ///< its coordinate across
};

}  // namespace strake
