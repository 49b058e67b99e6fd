#pragma once
#include "core/fields/field_frame.hpp"

#include <memory>
#include <string>
#include <vector>

/// Functions and motions that displacement fields are made of. Internal.
namespace strake {

class WingCoordinates;

using Powers = std::array<int, 3>;  ///< numbers of the functions along the axes of the frame: degrees of polynomials

/// What the amounts along the axis of the sections are made of. Across it they are polynomials.
enum class AlongAxis {
    polynomials,  ///< of Legendre
    splines  ///< cubic, of evenly spaced knots that are halved again and again: local, and they can take a kink away
};

/// Which functions there are.
struct FunctionSpace {
    FieldFrame frame;
    AlongAxis along = AlongAxis::polynomials;
    std::shared_ptr<const WingCoordinates> wing = {};  ///< functions of a wing's coordinates; null: of the frame's
    std::vector<Powers> powers = {};                   ///< their numbers

    /// The axis of the frame along which the function is linear, and constant across it; -1: it is another one.
    int linear_axis(const Powers& p) const;
    /// The function that is linear along an axis.
    Powers linear(int axis) const;
    /// On the plane of symmetry of the frame the function is 0.
    bool is_odd(const Powers& p) const;
};

constexpr int max_polynomial_degree = 40;
constexpr int max_spline_number = 600;

/// One motion before orthogonalization: components along the axes of the frame, each a multiple of a function.
struct FieldCandidate {
    struct Term {
        int axis;
        Powers powers;
        double factor;
    };
    std::vector<Term> terms;
    std::string name;
};

/// The first motions in the order in which they are tried, at least `count` of them unless the frame has no more up to
/// degree 40: affine ones, then sections by their degree along the axis, mixed with polynomials whose degree counts
/// more along shorter axes (by the root of the extents' ratio). Only those that are symmetric where the frame has a
/// plane, and that keep the kind of shape, and do one of the given things (none given: any). About an axis these are,
/// with w = eta + i zeta across it and w' its conjugate,
///   along the axis  P_i(s) w^p w'^q, p - q a multiple of the number of sectors;  across it  the same with p - q - 1;
/// real and imaginary part, for revolved shapes only what does not turn: p = q, and p = q + 1.
/// `up_to` takes the place of degree 40 along the axis of the sections.
std::vector<FieldCandidate> field_candidates(const FieldFrame& frame, bool is_symmetric, int count,
                                             const std::optional<ShapeKind>& kind = {},
                                             const std::vector<std::string>& motions = {},
                                             int up_to = max_polynomial_degree);

/// "scale" of section.scale_y.0, "out" of polynomial.out.r3.
std::string motion_of(const std::string& name);

/// Rigid motions of the whole body, in the same terms; only symmetric ones, and those that keep the kind of shape.
std::vector<FieldCandidate> rigid_candidates(const FieldFrame& frame, bool is_symmetric,
                                             const std::optional<ShapeKind>& kind = {});

/// The functions along one axis with numbers 0 to `last`, and their derivatives at s. Splines are polynomials up to
/// number 3. Those that follow are nested: with m = 2, 4, 8, ... intervals in [-1, 1] come the m / 2 B-splines around
/// the new knots, which with all before them span all cubic splines on these intervals. They come in pairs about s = 0,
/// from the middle outward: first the difference (an odd number), then the sum (an even one), so that even numbers are
/// even functions, as with polynomials. The one around 0 is even by itself.
struct FunctionsAlong {
    std::vector<double> value, slope;
    FunctionsAlong(AlongAxis kind, double s, int last);
    void set(double s);  ///< the same functions elsewhere

private:
    AlongAxis kind_;
};

}  // namespace strake
