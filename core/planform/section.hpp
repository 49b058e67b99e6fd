#pragma once
#include "core/planform/outline.hpp"

#include <array>
#include <numbers>
#include <optional>

/// The airfoil in a section: its edges, chord line, thickness and camber. Internal to core/planform.
namespace strake {

/// Of an outline at its nose, radians: what turns more is a corner there. Noses of polygons turn by about 100 degrees
/// at their foremost point, where they became a corner and a round nose in turn; runs of before keep that.
inline constexpr double nose_corner = 2.4, earlier_nose_corner = 100 * std::numbers::pi / 180;

/// All outlines of one section, which may be several elements of one airfoil. x is downstream, z up.
///
/// Trailing edge: the corners (turning of more than 50 degrees, or the ends of an open outline) within the last 3 % of
/// the chord of the outline that reaches farthest aft; the middle of the two sharpest, or the only one; without a
/// corner the weighted mean of the points in the last 0.2 %. Leading edge: where the nose begins in the direction of
/// the chord: the minimum of a polynomial of degree four in the height that is fitted to the points of the first 4 % of
/// the chord, with weights that fall to zero there. With fewer than seven of them, the point farthest from the trailing
/// edge by a parabola through three points; at a corner the corner. The chord joins the two;
/// chord fractions are measured along it and heights normal to it.
class Airfoil {
public:
    /// Nothing for outlines without two distinct points.
    static std::optional<Airfoil> from(std::vector<Outline> outlines, double corner = nose_corner);

    const PlanePoint& leading_edge() const { return leading_; }
    const PlanePoint& trailing_edge() const { return trailing_; }
    const Varying& chord() const { return chord_; }
    Varying twist() const;                                                 ///< radians, nose up
    const Varying& trailing_edge_thickness() const { return thick_end_; }  ///< distance of the two corners, length

    /// Heights of the upper and lower surface above the chord line at a chord fraction in (0, 1), length.
    /// @throws InvalidInput where no outline passes there.
    struct Heights {
        Varying upper, lower;
    };
    Heights heights(double chord_fraction) const;
    Varying thickness(double chord_fraction) const;  ///< upper - lower, length

    Varying max_thickness() const;  ///< largest thickness over the chord, and its chord fraction in `max_thickness_at`
    Varying max_camber() const;     ///< height of the mean line over the chord where its magnitude is largest; signed
    double max_thickness_at() const;
    double max_camber_at() const;
    /// Radius of curvature over the chord at the leading edge, of the fitted polynomial. 0 at a corner. Nothing with
    /// fewer than seven points.
    std::optional<Varying> leading_edge_radius() const;
    /// That the polynomial is fitted to; 0 where the leading edge is not by it.
    int num_nose_points() const { return num_nose_points_; }
    /// Of the outline at the point farthest from the trailing edge, radians; pi at an open end.
    double nose_turning() const { return nose_turning_; }
    /// Angle between the chords of the last 5 % of the upper and the lower surface, radians.
    Varying trailing_edge_angle() const;
    /// Area between two chord fractions, length squared.
    Varying area(double from, double to) const;

    /// Points in fractions of the chord, for pictures: outline by outline.
    std::vector<std::vector<std::pair<double, double>>> in_chords() const;

private:
    std::vector<Outline> outlines_;
    PlanePoint leading_, trailing_, along_, up_;  ///< along_: unit vector from leading to trailing edge
    PlanePoint upper_end_, lower_end_;            ///< corners of the trailing edge
    Varying chord_, thick_end_;
    bool sharp_nose_ = false;
    double corner_ = nose_corner, nose_turning_ = 0;
    int num_nose_points_ = 0;

    void find_trailing_edge();
    void find_leading_edge();
    void set_chord();
    std::optional<std::array<Varying, 5>> nose(int* num_points = nullptr) const;
    void refine_leading_edge();
    struct Extreme {
        double fraction;
        Varying value;
    };
    template <class Of>
    Extreme extreme(const Of& of) const;
    PlanePoint in_frame(const PlanePoint& p) const;  ///< chordwise and normal distance from the leading edge, length
    std::optional<Heights> heights_at(const Varying& distance) const;
};

}  // namespace strake
