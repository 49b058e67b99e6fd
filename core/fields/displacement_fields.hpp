#pragma once
#include "core/fields/field_frame.hpp"
#include "core/fields/field_functions.hpp"

#include <Eigen/Geometry>
#include <string>
#include <vector>

/// Displacement fields: smooth motions of space, restricted to a surface. Each cross-section along an axis is moved,
/// turned, scaled and sheared by amounts that are polynomials along the axis; polynomials of higher degree follow. They
/// make what a shell resists: sweep, taper, thickening, flattening, swelling.
///
///   u(x) = c(x) sum_ijk B_i(s) P_j(eta) P_k(zeta) C_ijk,   P Legendre polynomials, (s, eta, zeta) in [-1, 1]^3
///
/// along the axes of the frame, s along the longest; B are the same polynomials, or nested cubic splines. The cut-off c
/// is a product: for each connected held part the distance from it over the largest distance of a vertex, one linear
/// ramp over the whole body (short or smooth steps crease it). It is exactly zero on what is held. Of more than four
/// parts the smaller ones count as one: a product of many ramps leaves no motion between them.
namespace strake {

struct FunctionValues;

/// What the fields have to respect.
struct FieldConditions {
    std::vector<int> held;  ///< triangles whose vertices do not move
    /// Half model: no vertex leaves this plane, and the fields are those of the whole body that are symmetric.
    std::optional<SymmetryPlane> cut;
    /// Whole model: only symmetric fields. Not together with `cut`.
    std::optional<SymmetryPlane> mirror;
    /// Every motion keeps this kind of shape, up to round-off; what is held is of the kind.
    std::optional<ShapeKind> kind;
    /// Where nothing is held: no field moves or turns the body at this point (in half models its image on the plane,
    /// for shapes that are the same around an axis that on the axis). None: in the mean over the surface.
    std::optional<Eigen::Vector3d> still;
    /// The fields leave what is held with no slope: the cut-off is a product of squared ramps.
    bool smooth_border = false;
    /// Rigid motions of the whole are taken out where nothing is held: they are there only by this.
    bool keeps_rigid_motions = false;
};

struct FieldOptions {
    int number = 27;                      ///< at most so many fields, in [1, 600]; the first ones of a larger number
    std::optional<Eigen::Vector3d> axis;  ///< of the sections, unit; none: the longest principal axis
    /// Only these, by the first word of their names behind the dot ("scale" of section.scale_y.0); empty: all. The
    /// words are those of `field_motions()`.
    std::vector<std::string> motions{};
    AlongAxis along = AlongAxis::polynomials;
    bool axis_by_extent_alone = false;  ///< see `field_frame`: of runs that began so
    bool products_as_before = false;    ///< of one field alone: the bits of earlier runs, in many times the time
    /// Fields of this wing, in its own coordinates; then without `axis` and `along`, and not of a kind of shape.
    std::shared_ptr<const WingCoordinates> wing{};
    bool keeps_planform = false;  ///< of a wing: only what leaves both edges of its sections where they are
};

/// move, scale, twist, tilt, shear, out, around: what a field does, as its name says it.
const std::vector<std::string>& field_motions();
/// The same of fields of a wing: move, twist, chord, camber, thickness, bend, stretch, tilt.
const std::vector<std::string>& wing_motions();

/// The rotation next to a linear map with a positive determinant (Higham, 1986).
Eigen::Matrix3d polar_rotation(const Eigen::Matrix3d& F);

/// The fields of a surface at rest. Orthogonal in the mean over the surface, each scaled to a largest displacement of
/// 1: its value is a length. A field is named after what it does before what those before it do is taken out:
///   section.move_z.2     the sections move along z, by the second polynomial along the axis
///   section.scale_y.0    they grow along y;  section.tilt_y.1  they lean forward, in proportion to y
///   section.twist.0      they turn;          section.shear.0   they are sheared
///   polynomial.move_z.y2 z-displacement by a polynomial of degree 2 in y
/// x, y, z stand for the axis of the frame that is nearest to each.
class DisplacementFields {
public:
    /// @throws InvalidInput: number out of range, a held triangle that is none, an axis that is not of length one or
    /// crosses the plane of symmetry at an angle, a motion that is none, nothing that is free to move.
    /// Vertices that no triangle uses stay where they are.
    DisplacementFields(const TriMesh& surface, const FieldConditions& conditions, const FieldOptions& options);

    int size() const { return static_cast<int>(names_.size()); }  ///< <= number: what adds nothing is left out
    const std::string& name(int b) const { return names_[static_cast<std::size_t>(b)]; }
    int num_vertices() const { return static_cast<int>(values_.rows()); }
    const FieldFrame& frame() const { return space_.frame; }

    Points field(int b) const;                            ///< n x 3, at z_b = 1
    Points displacement(const Eigen::VectorXd& z) const;  ///< n x 3: sum_b z_b field(b)
    Eigen::VectorXd gradient(const Points& dJ_dv) const;  ///< dJ/dz, exactly: the transpose of `displacement`
    Eigen::VectorXd gradient(int vertex, const Eigen::Vector3d& dJ_dv) const;  ///< of one vertex alone: the same bits
    /// Per triangle: I + grad u at its centroid, the linear part of the map x -> x + u(x) there.
    std::vector<Eigen::Matrix3d> local_maps(const Eigen::VectorXd& z) const;
    /// dJ/dz by that of the linear part F at the centroid of one triangle: the transpose of `local_maps`.
    Eigen::VectorXd map_gradient(int triangle, const Eigen::Matrix3d& dJ_dF) const;
    /// Per triangle: the rotation of the map x -> x + u(x) at its centroid, the polar part of I + grad u; the identity
    /// where the map is not locally invertible (determinant <= 0).
    std::vector<Eigen::Matrix3d> rotations(const Eigen::VectorXd& z) const;

private:
    /// Per function the three components of the motion.
    using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 3>;
    Coefficients combined(const Eigen::VectorXd& z) const;
    void choose(const TriMesh& rest, const Eigen::VectorXd& cut, const std::vector<FieldCandidate>& rigid,
                const std::vector<FieldCandidate>& candidates, int count);
    Eigen::VectorXd gradient_by(const Coefficients& by_kept) const;
    void keep_used(FunctionValues& at_vertices);
    Coefficients still_at(const Eigen::Vector3d& point, Coefficients motion) const;
    void keep_in_plane(const TriMesh& rest, const SymmetryPlane& plane);

    FunctionSpace space_;
    std::optional<Eigen::Vector3d> still_;
    bool products_as_before_ = false;
    std::vector<int> columns_;                ///< functions that a field has
    Eigen::MatrixXd values_;                  ///< n x these, cut-off included
    std::vector<Coefficients> coefficients_;  ///< per field
    std::vector<std::string> names_;
    Points centroid_;          ///< m x 3
    Eigen::VectorXd cut_off_;  ///< at the centroids
    Points cut_off_gradient_;  ///< m x 3
};

}  // namespace strake
