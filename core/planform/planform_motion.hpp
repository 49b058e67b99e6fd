#pragma once
#include "core/planform/fuselage.hpp"
#include "core/planform/wing.hpp"

#include <complex>
#include <functional>
#include <memory>

/// Design variables of a wing designer: the exact motion of a surface by changes of the planforms of its wings; and of
/// bodies by their length.
namespace strake {

/// What of a wing varies. Values are changes; span is of the whole wing.
enum class PlanformChange {
    span,       ///< from tip to tip, as a share of it; sweep and dihedral angles stay
    sweep,      ///< of the wing's axis, radians, tip aft; by station, of the panel from there to the next
    dihedral,   ///< likewise, tip up; not of a panel that is upright
    chord,      ///< as a share of it; t/c stays, or the thickness where `keeps_thickness`
    twist,      ///< radians, nose up, about the wing's axis
    thickness,  ///< t/c, as a share of it; the mean line and the thickness of the trailing edge stay
    aft,        ///< the whole wing along the stream, as a share of its mean aerodynamic chord at the start
    up,         ///< likewise, up
    camber,     ///< of the mean line where it is highest, as a share of the chord, up; of a body, of its length
    length,     ///< of a body, from its nose on, as a share of it
    width,      ///< of its sections about their middle, as a share of it
    height      ///< likewise
};

/// "span" and so on, in the order of `PlanformChange`.
const std::vector<std::string>& planform_changes();
inline bool is_angle(PlanformChange change) {
    return change == PlanformChange::sweep || change == PlanformChange::dihedral || change == PlanformChange::twist;
}
/// Of the whole wing, which keeps its shape.
inline bool is_shift(PlanformChange change) { return change == PlanformChange::aft || change == PlanformChange::up; }
inline bool has_stations(PlanformChange change) {
    return change != PlanformChange::span && change != PlanformChange::length && !is_shift(change);
}
/// Camber is one of both.
inline bool is_of_bodies(PlanformChange change) { return change >= PlanformChange::camber; }
inline bool is_of_wings(PlanformChange change) { return change <= PlanformChange::camber; }
/// Of the axis, by panels between the stations; others are of the sections at them.
inline bool has_panels(PlanformChange change) {
    return change == PlanformChange::sweep || change == PlanformChange::dihedral;
}

/// What the user gives a range to.
struct PlanformRange {
    int wing = 0;  ///< number of the wing; bodies follow the wings
    PlanformChange change = PlanformChange::span;
    bool by_station = false;  ///< one variable for each station (panel) of the wing, instead of one for all sections
    bool root_held = false;   ///< by station: section or panel at the root keeps its value, also where it is no station
    std::vector<double> only = {};  ///< by station: of these alone; the others keep their values. Empty: all
    bool keeps_thickness = false;   ///< `chord`
    double lower = 0, upper = 0;    ///< of the change, lower <= 0 <= upper, lower < upper
};

/// How changes of sections pass a station between oblique rows of vertices: level, or with a kink whose corner
/// triangles cut, at the leading edge otherwise than at the trailing edge (the meaning of earlier runs).
enum class StationCorners : int { level, kinked };

/// v = v0 + u(v0; z), exact and smooth in z, and zero at z = 0 to the last bit. Each vertex of a wing has its section
/// (at a fraction s of the semispan) and in it the complex place w = downstream + i up from the axis. With e the chord
/// vector of the section, zeta = xi - axis + i eta = w / e, and the changes at s,
///
///   u(s, w) = d + a(s) + [(M(s) - 1) zeta + M(s) H(s, zeta)] e(s),   M = m exp(-i theta)
///   H = i h - (1 - xi - i eta) l,   h = (q (1 + t (1 - b(xi))) - 1) (eta - mean line) + k B(xi)
///
/// d is the shift of the whole wing, aft and up; a is the motion of the axis (stretched by the span, sheared by sweep
/// and dihedral; a panel between two stations by itself, what is outboard of it moves as far as its outer end), m the
/// factor on the chord, theta the change of twist, t that of t/c, k that of camber; q = 1/m where the chord keeps the
/// thickness, else 1; B the mean line of NACA's four digits with its top at that of the section; b = xi^8 where the
/// trailing edge is blunt, which keeps its thickness, else 0; l is what h does to the leading edge, to first order, so
/// that this stays where a section shows it. Between two stations, r from the first to the second,
///
///   M = ((1 - r) e_0 M_0 + r e_1 M_1) / ((1 - r) e_0 + r e_1):
///
/// so that an edge that was straight there stays straight, and equal changes at both are that change everywhere
/// between. Where rows of vertices are oblique to the sections, a panel's shear has no corner at its ends: beside them,
/// over w, three rows wide, |d| becomes d^2 (2 w - |d|) / w^2 in it, which meets the end and both straight lines.
/// t, q and k are linear between stations, and all is constant beyond the first and the last. Where rows of vertices
/// are oblique, M, t, q and k are those of the station, too, as far as triangles that its plane cuts reach, and r
/// begins there: the section shows what its station has. Between rows along the sections the variable of a station is
/// what its section shows; triangles cut the corners of M, t and k there.
///
/// Sections are normal to the span, on a winglet to its axis. Both sides of a whole wing do the same. Vertices that are
/// not of the wing do not move; where the wing is joined to other triangles, it moves from its root on, whose section
/// must then be held.
class PlanformMotion {
public:
    /// @throws InvalidInput: numbers and ranges out of their limits, the same change of a wing twice, a change by
    /// station of what has none, a wing joined to other triangles whose root section would change, wings that share
    /// vertices; as Wing.
    PlanformMotion(const TriMesh& start, const std::vector<std::shared_ptr<const Wing>>& wings,
                   const std::vector<PlanformRange>& ranges = {},
                   const std::vector<std::shared_ptr<const Fuselage>>& bodies = {},
                   StationCorners corners = StationCorners::level);
    /// One more range. @param start the same. @throws as above.
    void add(const TriMesh& start, const PlanformRange& range);

    /// "wing.delta_span", "wing.delta_twist@0.5".
    struct Variable {
        std::string name;
        PlanformChange change;
        int wing;
        double station;  ///< -1: of all sections
        double lower, upper;
    };
    const std::vector<Variable>& variables() const { return variables_; }
    int size() const { return static_cast<int>(variables_.size()); }
    int num_vertices() const { return static_cast<int>(start_.rows()); }

    Points displacement(const Eigen::VectorXd& z) const;  ///< n x 3; z: size()
    /// d(displacement)/dz_j at z, n x 3.
    Points derivative(const Eigen::VectorXd& z, int j) const;
    /// The motion by a small change dz at z, n x 3: all derivatives times it.
    Points rate(const Eigen::VectorXd& z, const Eigen::VectorXd& dz) const;
    /// dJ/dz at z: the transpose of all derivatives.
    Eigen::VectorXd gradient(const Eigen::VectorXd& z, const Points& dJ_dv) const;
    /// Per triangle: the linear part of the map x -> x + u(x) at its centroid, by differences in space. The identity
    /// off the wings.
    std::vector<Eigen::Matrix3d> local_maps(const Eigen::VectorXd& z) const;

private:
    /// A smooth function of the fraction of a body's length: the cubic spline through values at some places, level or
    /// free at its ends, constant beyond.
    struct Along {
        std::vector<double> places;
        Eigen::VectorXd values, slopes;
        Along() = default;
        Along(std::vector<double> at, Eigen::VectorXd by, bool has_free_ends);
        double operator()(double s) const;
    };
    /// At s of the length: width and height change about the middle of the section at the start.
    struct MovedBody {
        std::shared_ptr<const Fuselage> body;
        std::vector<int> vertices;
        double nose, length;         ///< at the start, along the axis
        std::vector<double> places;  ///< where the middles are
        std::vector<Eigen::Vector2d> middles;
    };
    using Complex = std::complex<double>;
    /// A section of the start between which changes are interpolated; of both sides in the mean.
    struct Node {
        double place;               ///< fraction of the semispan
        Complex chord;              ///< e
        Eigen::Vector3d axis;       ///< outboard from the root, downstream, up
        Eigen::VectorXd mean_line;  ///< over the chord: factors of xi (1 - xi) (2 xi - 1)^k
        Eigen::VectorXd bump;       ///< likewise of B; empty: the four-digit mean line
        bool is_blunt;
        double rounding = 0;  ///< how far beside it panels are rounded off, fraction of the semispan
        double level = 0;     ///< how far beside it changes of sections are its own, likewise
    };
    /// A point of a wing.
    struct Place {
        int wing = -1;  ///< -1: it does not move
        int side = 0;
        std::size_t node = 0;  ///< before it
        double ratio = 0;      ///< between that and the next, in [0, 1]
        Complex zeta, e;
        double turned = 0;          ///< r
        Complex first;              ///< share of the node before it in M
        double straight = 0;        ///< as `ratio`, beyond the first and the last node outside of [0, 1]
        std::size_t corner = 0;     ///< the node beside which it is rounded off
        double off_corner = 0;      ///< what that makes of a change of slope there by 1; 0: nothing
        Eigen::Vector3d arm;        ///< of the axis from that at the root: outboard, downstream, up
        Eigen::Vector3d up;         ///< of its section
        double height, bump, kept;  ///< eta - mean line, B, 1 - b
        Complex lead_by_thickness, lead_by_camber;  ///< where a unit of eta - mean line, and of B, takes the nose
    };
    /// What a wing moves by, or rates of it. At the nodes: M, t, q, k, and how far panels take the axis; of the whole
    /// axis: share of the semispan, slopes.
    struct Changes {
        std::vector<Complex> factor;                  ///< less 1
        std::vector<double> thickness, kept, camber;  ///< kept: q - 1
        std::vector<double> aft, rise;                ///< lengths
        double stretch = 0, sweep = 0, dihedral = 0;
        double shift_aft = 0, shift_up = 0;  ///< lengths
    };
    struct MovedWing {
        std::shared_ptr<const Wing> wing;
        std::vector<Node> nodes;
        std::vector<double> reach;                       ///< per side
        double sweep = 0, dihedral = 0, mean_chord = 0;  ///< at the start
        double span = 0;                                 ///< that a change by 1 adds to the axis
        bool keeps_thickness = false;
        /// Along the span: what a unit of i (eta - mean line), and of i B, does to the leading edge that is measured.
        std::vector<double> nose_places;
        std::vector<Complex> nose_by_thickness, nose_by_camber;
    };

    void add_wing(const TriMesh& start, const std::shared_ptr<const Wing>& wing);
    // planform_stations.cpp
    void add_stations(const TriMesh& start, const PlanformRange& range, bool is_root_held, const std::string& shown);
    void add_panels(const TriMesh& start, const PlanformRange& range, bool is_root_held, const std::string& shown);
    /// What a unit of each row's shares changes at each of the stations, as a section of the moved surface has it.
    /// @param angles of the panels at the start; empty for changes of sections
    Eigen::MatrixXd measured(const TriMesh& start, const PlanformRange& range, const std::vector<double>& stations,
                             const Eigen::MatrixXd& shares, const std::vector<double>& angles = {});
    static void check_angle(const PlanformRange& range, double now, const std::string& shown);
    void add_variable(const PlanformRange& range, double station, Eigen::VectorXd shares, double angle = 0);
    // planform_layout.cpp
    void check_range(const PlanformRange& range, const std::string& shown) const;
    static double angle_of(const MovedWing& moved, PlanformChange change);  ///< of the whole wing at the start
    void place_vertices(const TriMesh& start);
    /// Rows of vertices that cross the plane of a station at an angle cut the corner of a shear there otherwise at the
    /// leading edge than at the trailing edge, which would show as twist.
    void round_corners(const TriMesh& start, const Wing& wing, double reach, std::vector<Node>& nodes) const;
    void set_span_right(const TriMesh& start, MovedWing& moved) const;
    static double rounded_off(const Node& node, double distance);
    static double blend(double a, double b, double ratio) { return a + ratio * (b - a); }
    static std::vector<std::pair<double, double>> nose_places(const MovedWing& moved);
    static void set_shares(const Node& a, const Node& b, Place& at);
    void measure_noses(const TriMesh& start, int wing);
    Node node_at(const TriMesh& start, const Wing& wing, double station) const;
    Place place_at(int wing, int side, const Eigen::Vector3d& x) const;
    // planform_motion.cpp
    std::vector<Changes> changes(const Eigen::VectorXd& z) const;
    Changes changes_of(int wing, const Eigen::VectorXd& z) const;
    Eigen::Matrix3d slope_at(int wing, int side, const Eigen::Vector3d& x, const Changes& now) const;
    /// Rates of the wing's changes by variable j.
    Changes rates(const Changes& now, int j, const Eigen::VectorXd& z) const;
    Changes zero(int wing) const;
    Eigen::Vector3d moved(const Place& at, const Changes& by) const;
    Eigen::Vector3d moved_rate(const Place& at, const Changes& by, const Changes& rate) const;
    Eigen::Vector3d in_space(const Place& at, const Eigen::Vector3d& axis, Complex section) const;
    void check_size(const Eigen::VectorXd& z) const;
    // fuselage_variables.cpp
    void add_body(const TriMesh& start, const std::shared_ptr<const Fuselage>& body);
    void add_body_range(const TriMesh& start, const PlanformRange& range);
    std::vector<double> body_stations(const TriMesh& start, const MovedBody& moved, const PlanformRange& range,
                                      const std::string& shown) const;
    Eigen::Vector3d body_motion(const MovedBody& moved, PlanformChange change, const Along& along,
                                const Eigen::Vector3d& x) const;
    Points body_field(const MovedBody& moved, PlanformChange change, const Along& along) const;
    void add_body_maps(const Eigen::VectorXd& z, std::vector<Eigen::Matrix3d>& maps) const;
    /// The motion by a unit of a variable of a body; null of one of a wing.
    const Points* body_field(int j) const {
        const auto k = static_cast<std::size_t>(j);
        return k < fields_.size() && fields_[k].rows() > 0 ? &fields_[k] : nullptr;
    }

    Points start_;
    Triangles triangles_;
    StationCorners corners_;
    std::vector<MovedWing> wings_;
    std::vector<MovedBody> bodies_;
    std::vector<Variable> variables_;
    /// Per variable: what the nodes have of it, of panels per unit of slope; empty for the whole axis.
    std::vector<Eigen::VectorXd> shares_;
    std::vector<double> angles_;  ///< per variable: sweep or dihedral at the start
    std::vector<Points> fields_;  ///< per variable of a body: the motion by a unit; else without rows
    std::vector<Along> alongs_;   ///< likewise: how much of it at s
    std::vector<int> vertices_;   ///< of wings, that move
    std::vector<Place> places_;   ///< of them
};

}  // namespace strake
