#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "core/planform/section.hpp"

#include <optional>
#include <string>
#include <vector>

/// A wing by its planform: sections along the span, and what a wing designer reads from them: span, sweep, dihedral,
/// chord, twist, thickness and camber by station.
namespace strake {

/// How sections are laid and measured; all but the first are meanings of earlier runs.
enum class WingRules : int {
    latest,
    sliding,  ///< a winglet's planes are at fractions of its present extent along their normals, from the root on
    earlier   ///< so they are; noses are corners from `earlier_nose_corner` on, and a winglet's planes end where steps
              ///< along it do
};

/// How a wing is declared.
struct WingDeclaration {
    std::string name = "wing";
    std::vector<int> triangles = {};  ///< of the surface; empty: all
    /// Unit vectors. `span` along one of the wings (either), perpendicular to both others, which are to each other.
    Eigen::Vector3d span = Eigen::Vector3d::UnitY(), downstream = Eigen::Vector3d::UnitX(),
                    up = Eigen::Vector3d::UnitZ();
    std::optional<SymmetryPlane> symmetry = {};  ///< the surface is half a body
    std::vector<double> stations = {};           ///< fractions of the semispan in [0, 1], ascending; empty: at kinks
    double axis = 0.25;                          ///< chord fraction of the axis of sweep and dihedral, in [0, 1]
    WingRules rules = WingRules::latest;
};

/// One section. Both sides of a whole wing count half each. Angles in radians, lengths in the surface's unit.
struct StationFacts {
    double station = 0;                           ///< fraction of the semispan
    Eigen::Vector3d leading_edge, trailing_edge;  ///< of the first side
    Varying chord, twist;                         ///< twist: nose up, against the stream
    Varying leading_x, trailing_x;                ///< of the edges, downstream
    Varying thickness_to_chord, camber;
    double thickness_at = 0, camber_at = 0;      ///< chord fractions
    std::optional<Varying> leading_edge_radius;  ///< over the chord
    Varying trailing_edge_angle, trailing_edge_thickness;
    std::vector<std::vector<std::pair<double, double>>> outline;  ///< in fractions of the chord, of the first side
};

/// Of the whole wing, also where the surface is half of it.
struct WingFacts {
    Varying span;          ///< from tip to tip, body included
    Varying area;          ///< of the exposed wing, both sides: integral of the chord over the exposed semispan
    Varying aspect_ratio;  ///< (twice the exposed semispan)^2 / area
    Varying taper;         ///< last station's chord over the first one's
    Varying sweep;         ///< of the axis: straight line through it, by least squares over the chord; tip aft
    Varying dihedral;      ///< likewise; tip up
    Varying mean_chord;    ///< mean aerodynamic chord, integral of c^2 over that of c
};

/// The axis between two neighbouring stations, root and tip among them. Both sides count half each.
struct PanelFacts {
    double from = 0, to = 1;  ///< stations
    bool is_upright = false;  ///< more than 45 degrees of dihedral at the start
    /// Distance of both ends across the stream: along the span, of an upright one seen from the front.
    Varying width;
    Varying sweep;     ///< of the straight line between the ends: atan of how far it goes aft, over the width; tip aft
    Varying dihedral;  ///< of that line seen from the front, against the span; tip up
};

/// The slot between a wing and the one ahead of it, a main wing and its flap, lengths.
struct SlotFacts {
    Varying gap;      ///< distance of the trailing edge ahead from this section; negative inside of it
    Varying overlap;  ///< how far the trailing edge ahead lies downstream of this section's leading edge
};

/// Those of the vertices, at these positions (one row each), that are farthest along n, within 1e-6 of `scale`.
std::vector<int> outermost(const Points& positions, const std::vector<int>& vertices, const Eigen::Vector3d& n,
                           double scale);

/// The planes of a declared wing, laid out once on the start surface; then measured on any surface of the same
/// triangles. Planes are streamwise, normal to the span at fractions of the present semispan. Of a wing with a winglet
/// fractions are those of the length of the start's axis seen from the front, and planes beyond 45 degrees of dihedral
/// are normal to it; each keeps its direction and goes where the edges of its section at the start have gone.
///
/// The root is where the listed triangles begin, or the plane of symmetry; it keeps its place. The tip is the mean of
/// the start's outermost vertices. A wing open at one end is half a wing, whose other half is its mirror image. A wing
/// that is its own mirror image has two sides. The station 1 lies at 99.8 % of the semispan, or where the chord of a
/// rounded tip begins to fall.
class Wing {
public:
    /// @throws InvalidInput: directions that are not perpendicular, stations outside of [0, 1], triangles out of range,
    /// no sections along the span (with the reason).
    Wing(const TriMesh& start, const WingDeclaration& declaration);

    const WingDeclaration& declaration() const { return declared_; }
    const std::vector<double>& stations() const { return stations_; }  ///< declared, or found at kinks
    int num_sides() const { return static_cast<int>(sides_.size()); }
    bool has_winglet() const;                    ///< some planes are not streamwise
    double semispan(const TriMesh& mesh) const;  ///< exposed, of the first side

    /// `surface` has the start's triangles. @throws InvalidInput (with the station) where a section does not exist.
    WingFacts facts(const TriMesh& surface, bool sensitivities = false) const;
    StationFacts station(const TriMesh& surface, double station, bool sensitivities = false) const;
    /// The ends of panels: the stations, root and tip. A station on a rounded tip, beyond that of the tip, is none.
    std::vector<double> panel_ends() const;
    /// The panel from a station outward, or in which it lies; of the tip the last.
    PanelFacts panel(const TriMesh& surface, double station, bool sensitivities = false) const;
    /// In this wing's section at a station, both sides half each. @throws InvalidInput where one of the two has none.
    SlotFacts slot(const TriMesh& surface, const Wing& ahead, double station, bool sensitivities = false) const;
    /// The sections at a station, one a side.
    std::vector<Airfoil> sections(const TriMesh& surface, double station, bool sensitivities = false) const;
    /// The same with where they are, in space.
    struct PlacedSection {
        Airfoil airfoil;
        Eigen::Vector3d leading_edge, trailing_edge;
    };
    std::vector<PlacedSection> placed_sections(const TriMesh& surface, double station) const;
    /// The edges of one section in its plane, by coordinates downstream and up, with their derivatives.
    struct Edges {
        PlanePoint leading, trailing;
        Eigen::Vector3d normal, up;     ///< unit, of the plane
        Eigen::Vector3d leading_point;  ///< in space
        Eigen::Vector3d trailing_point;
        int num_nose_points = 0;  ///< that the polynomial of the leading edge is fitted to; 0: none is
        double nose_turning = 0;  ///< of the outline, radians
    };
    /// In the plane that `planes_of` has at a place (as `place` gives it), which stays where it is. Nothing where it
    /// meets no section. @param triangles of the side, those that may be cut; null: all of them
    std::optional<Edges> edges(const TriMesh& surface, const TriMesh& planes_of, int side, double place,
                               bool sensitivities, const std::vector<int>* triangles = nullptr) const;
    /// Volume of both sides between two chord fractions, from the first to the second station, length cubed.
    Varying volume(const TriMesh& surface, std::pair<double, double> chord, std::pair<double, double> span,
                   bool sensitivities = false) const;

    /// Where a point lies in the wing: fractions of the semispan and of the local chord (both also outside of [0, 1]).
    struct Place {
        int side;
        double span, chord;
    };
    std::vector<Place> places(const TriMesh& surface) const;  ///< per vertex
    /// Marks of the triangles of the wing whose three vertices lie in the ranges, ends included, and whose normals
    /// point up (`side` 1), down (-1) or anywhere (0).
    std::vector<char> region(const TriMesh& surface, std::pair<double, double> chord, std::pair<double, double> span,
                             int side = 0) const;

    // One of `num_sides()`, for what moves it.
    const Eigen::Vector3d& span(int side) const { return at(side).span; }  ///< unit, outboard
    double root(int side) const { return at(side).root; }                  ///< coordinate along its span
    bool is_joined(int side) const { return at(side).is_joined; }          ///< the root borders on other triangles
    const std::vector<int>& triangles(int side) const { return at(side).triangles; }  ///< ascending
    const std::vector<int>& vertices(int side) const { return at(side).vertices; }    ///< ascending
    /// Where a station lies: the same fraction, but for the tip's.
    double place(int side, double station) const { return place_of(at(side), station); }
    /// Exposed semispan of one side. `fraction_at` wants that of the start.
    double reach(const TriMesh& surface, int side) const { return plane(surface, at(side), 0, false).reach.value; }
    double fraction_at(int side, double reach, const Eigen::Vector3d& x) const { return along(at(side), reach, x); }
    Eigen::Vector3d up_at(int side, double place) const;  ///< unit, in the section's plane across the stream

private:
    /// Of a wing with winglet: the line through the middles of the chords, from root to tip.
    struct Node {
        double station;        ///< fraction of its length seen from the front
        double angle;          ///< of the plane's normal above the span, radians
        Eigen::Vector3d axis;  ///< at the start
        /// The middle of the section's foremost and aftmost point: vertices with their shares, and where it starts.
        std::vector<std::pair<int, double>> middle = {};
        Eigen::Vector3d middle_at = Eigen::Vector3d::Zero();
        Varying gone(const TriMesh& surface, const Eigen::Vector3d& way, bool sensitivities) const;
    };
    struct Side {
        Eigen::Vector3d span;             ///< unit, outboard
        std::vector<int> triangles = {};  ///< ascending
        std::vector<int> vertices = {};   ///< of them, ascending
        std::vector<int> tip = {};        ///< the outermost vertices of the start
        double root = 0;                  ///< coordinate along `span`
        Eigen::Vector3d root_point = {};  ///< in the root's plane
        std::vector<Node> nodes = {};     ///< empty: all planes are streamwise
        Points start = {};                ///< positions of `vertices` at the start, where there are nodes
        double length = 0;                ///< of the line, with nodes
        double last = 1;                  ///< where the station 1 lies
        double scale = 0;                 ///< extent along the span at the start
        bool is_joined = false;           ///< to other triangles at the root

        struct Between {
            const Node &a, &b;
            double ratio;
        };
        Between nodes_at(double fraction) const;
    };
    struct Plane {
        SectionFrame frame;
        Varying reach;   ///< distance of the tip from the root, along the normal
        Varying length;  ///< per station, over `stretch`
        double stretch = 1;
        std::optional<Eigen::Vector3d> near;  ///< which outlines count: those at this point
    };

    WingDeclaration declared_;
    std::vector<double> stations_;
    std::vector<Side> sides_;
    double centre_ = 0;          ///< coordinate along `span` of the plane between both sides
    bool keeps_centre_ = false;  ///< the span is measured from there

    const Side& at(int side) const { return sides_[static_cast<std::size_t>(side)]; }
    // wing_layout.cpp
    void find_sides(const TriMesh& start);
    bool is_mirrored(const TriMesh& start, std::array<double, 2>& outer) const;
    void split_at(const TriMesh& start, double centre, const std::vector<int>& signs);
    Side begun(const TriMesh& start, int sign, double from) const;
    void find_winglet(const TriMesh& start, Side& side) const;
    void march(const TriMesh& start, Side& side) const;
    void tie(const TriMesh& start, const Side& side, Node& node) const;
    void find_last(const TriMesh& start, Side& side) const;
    std::vector<double> kinks(const TriMesh& start) const;
    // wing.cpp
    Plane plane(const TriMesh& surface, const Side& side, double place, bool sensitivities) const;
    bool follows() const { return has_winglet() && declared_.rules == WingRules::latest; }
    void follow(const TriMesh& surface, const Side& side, double fraction, bool sensitivities, Plane& plane) const;
    Varying length_of(const TriMesh& surface, const Side& side, const Plane& root, double share,
                      bool sensitivities) const;
    Varying step(const TriMesh& surface, const Side& side, const Node& a, const Node& b, bool sensitivities) const;
    std::vector<Outline> outlines(const TriMesh& surface, const Side& side, const Plane& plane, bool sensitivities,
                                  const std::vector<int>* triangles = nullptr) const;
    std::optional<Airfoil> section(const TriMesh& surface, const Side& side, double place, bool sensitivities) const;
    std::optional<Airfoil> section(const TriMesh& surface, const Side& side, const Plane& plane, bool sensitivities,
                                   const std::vector<int>* triangles = nullptr) const;
    Airfoil needed(const TriMesh& surface, const Side& side, double place, bool sensitivities) const;
    // wing_places.cpp
    double along(const Side& side, double reach, const Eigen::Vector3d& x) const;
    // wing_panels.cpp
    std::array<Varying, 3> axis_at(const TriMesh& surface, const Side& side, double station, bool sensitivities) const;
    bool is_upright(double from, double to) const;
    double corner_of_noses() const { return declared_.rules == WingRules::earlier ? earlier_nose_corner : nose_corner; }
    static double place_of(const Side& side, double station);
    static Eigen::Vector3d in_space(const Plane& plane, const PlanePoint& point);
};

}  // namespace strake
