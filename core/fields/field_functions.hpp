#pragma once
#include "core/fields/field_frame.hpp"

#include <string>
#include <vector>

/// Functions and motions that displacement fields are made of. Internal.
namespace strake {

using Powers = std::array<int, 3>;  ///< degrees of the Legendre polynomials along the axes of the frame

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
/// plane, and that keep the kind of shape. About an axis these are, with w = eta + i zeta across it and w' its
/// conjugate,
///   along the axis  P_i(s) w^p w'^q, p - q a multiple of the number of sectors;  across it  the same with p - q - 1;
/// real and imaginary part, for revolved shapes only what does not turn: p = q, and p = q + 1.
std::vector<FieldCandidate> field_candidates(const FieldFrame& frame, bool is_symmetric, int count,
                                             const std::optional<ShapeKind>& kind = {});

/// Rigid motions of the whole body, in the same terms; only symmetric ones, and those that keep the kind of shape.
std::vector<FieldCandidate> rigid_candidates(const FieldFrame& frame, bool is_symmetric,
                                             const std::optional<ShapeKind>& kind = {});

/// Legendre polynomials P_0..P_degree and their derivatives at s.
struct LegendreValues {
    std::vector<double> value, slope;
    LegendreValues(double s, int degree);
    void set(double s);  ///< the same polynomials elsewhere
};

}  // namespace strake
