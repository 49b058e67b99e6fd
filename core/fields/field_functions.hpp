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
/// plane.
std::vector<FieldCandidate> field_candidates(const FieldFrame& frame, bool is_symmetric, int count);

/// Rigid motions of the whole body, in the same terms; only symmetric ones where asked for.
std::vector<FieldCandidate> rigid_candidates(const FieldFrame& frame, bool is_symmetric);

/// Legendre polynomials P_0..P_degree and their derivatives at s.
struct LegendreValues {
    std::vector<double> value, slope;
    LegendreValues(double s, int degree);
};

}  // namespace strake
