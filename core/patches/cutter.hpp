#pragma once
#include "core/patches/parts.hpp"

#include <algorithm>
#include <array>

namespace strake {

/// Number of parts for an area of `x` fair shares. Rounds up late: half of an odd number of shares, frequent on
/// symmetric bodies, then rounds the same way on every mesh.
int worth(double x);

/// A part and its target area. Cuts follow the triangles, so areas vary slightly with the mesh; the next number of
/// parts follows from the target, which does not.
struct Piece {
    TriangleSet triangles;
    double due = 0;
};

/// Cuts sets of triangles into a target number of parts of similar area. In this order: along creases; a sheet (a wing)
/// into its two sides; by a plane across one of the body's principal axes.
class Cutter {
public:
    Cutter(const Body& body, const Creases& creases, double min_area)
        : body_(body), parts_(body, creases), creases_(creases), min_area_(min_area) {}

    std::vector<Piece> cut(const Piece& piece, int wanted) {
        std::vector<Piece> pieces;
        cut_into(pieces, piece, wanted);
        return pieces;
    }
    double area(const TriangleSet& set) const { return parts_.area(set); }
    /// Joins the smallest of the pieces of `set` with a neighbour.
    std::vector<Piece> without_smallest(const TriangleSet& set, const std::vector<Piece>& pieces);
    std::vector<TriangleSet> along_creases(const TriangleSet& set, int wanted);

private:
    /// Minimum area of a part: half a fair share.
    double least(const TriangleSet& set, int wanted) const { return std::max(min_area_, 0.5 * area(set) / wanted); }
    void cut_into(std::vector<Piece>& pieces, const Piece& piece, int wanted);
    std::vector<TriangleSet> two_sides(const TriangleSet& set, int wanted);
    std::vector<TriangleSet> across_axis(const TriangleSet& set, int wanted, int axis);
    std::array<int, 3> axes_by_extent(const TriangleSet& set) const;

    const Body& body_;
    Parts parts_;
    const Creases& creases_;
    double min_area_;
};

}  // namespace strake
