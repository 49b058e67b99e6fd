#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <Eigen/Geometry>

#include <array>
#include <optional>
#include <string>
#include <vector>

/// Kinds of shape that every motion of a surface keeps: extruded, revolved, cyclic.
namespace strake {

/// What the shape is unchanged by.
struct ShapeKind {
    enum class Type {
        extruded,  ///< the same section all along `axis`; no motion goes along it
        revolved,  ///< the same under every rotation about the axis; nothing turns
        cyclic     ///< the same under rotations by 1 / `count` of a turn
    };
    Type type = Type::extruded;
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();    ///< unit
    Eigen::Vector3d through = Eigen::Vector3d::Zero();  ///< a point of the axis; not for `extruded`
    int count = 1;                                      ///< of `cyclic`, >= 2
};
std::string to_string(const ShapeKind& kind);  ///< "extruded along y"

/// Vertices that the kind of shape takes to each other form a class: a column, a ring, or the images in all sectors.
/// A motion keeps the kind where it is the same on a class, seen from each member; projecting makes it so, exactly up
/// to round-off: x0 + P u is of the kind where x0 is, to the deviation of x0. P takes the mean of a class, in which
/// vertices on the plane of a half model count half; P P = P.
class Invariance {
public:
    /// @param tolerance of the start, in diagonals, > 0.
    /// @param cut of a half model: vertices on it stay there.
    /// @throws InvalidInput: an axis that is not of length one, count < 2, and in words with place and deviation:
    /// - extruded: a triangle that lies neither across the axis nor along it, or a vertex beside the columns;
    /// - revolved: a vertex on no ring of three or more that goes all around (half around with `cut`);
    /// - cyclic: a vertex or triangle whose image is none.
    Invariance(const TriMesh& rest, const ShapeKind& kind, double tolerance = 1e-6,
               const std::optional<SymmetryPlane>& cut = {});

    const ShapeKind& kind() const { return kind_; }
    int num_vertices() const { return static_cast<int>(class_of_.size()); }
    int num_classes() const { return static_cast<int>(first_.size()) - 1; }
    int class_of(int v) const { return class_of_[static_cast<std::size_t>(v)]; }

    /// P u: what of the displacement keeps the kind of shape. @param motion n x 3.
    Points projected(const Points& motion) const;
    /// P^T f: of forces and sensitivities. The gradient of J(x0 + P u) by u is P^T dJ/dv; forces P^T f do on any motion
    /// the work that forces f do on what of it keeps the kind.
    Points pulled_back(const Points& forces) const;
    /// What is held has to be of the kind, too: whole classes. @throws InvalidInput with the place of one that is not.
    void check_held(const TriMesh& rest, const std::vector<int>& triangles) const;
    /// Largest length of u - P u over the vertices.
    double deviation(const Points& motion) const;

private:
    Eigen::Vector3d allowed(int v, Eigen::Vector3d motion) const;
    Points averaged(const Points& of, bool is_transposed) const;
    void classify_columns(const TriMesh& rest, double tolerance);
    void classify_rings(const TriMesh& rest, double tolerance, const std::optional<SymmetryPlane>& cut);
    void classify_sectors(const TriMesh& rest, double tolerance);
    void collect();
    bool goes_around(int c, bool is_half) const;

    ShapeKind kind_;
    std::vector<int> class_of_;           ///< per vertex
    std::vector<int> first_, member_;     ///< members of class c: member_[first_[c]] to member_[first_[c + 1]]
    Eigen::VectorXd weight_;              ///< per vertex, in the mean of its class
    std::vector<char> is_on_axis_;        ///< per vertex: moves along the axis alone
    std::vector<Eigen::Matrix3d> frame_;  ///< per vertex: from the class's coordinates to space; empty: the same in all
};

/// Of motions of any points (n x 3): the mean over those that lie in one column along the axis (to `tolerance`, a
/// length) without what goes along it. Points of a volume mesh of one layer stay in pairs across, its ends stay flat.
/// Its own transpose. @throws InvalidInput: sizes
Points motion_of_columns(const Points& points, const Eigen::Vector3d& axis, double tolerance, const Points& motion);

}  // namespace strake
