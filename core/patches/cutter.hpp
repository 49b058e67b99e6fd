#pragma once
#include "core/patches/parts.hpp"

#include <algorithm>
#include <array>

namespace strake {

/// Parts that an area of `x` fair shares is worth. Rounds up late, so that the half of an odd number of shares, which
/// symmetric bodies have often, falls on the same side on every mesh.
int worth(double x);

/// A part, and the area it was meant to have. Cuts follow the triangles, so that areas differ a little from mesh to
/// mesh; the number of parts that a part gets next is decided by what is due, which does not.
struct Piece {
    TriangleSet triangles;
    double due = 0;
};

/// Cuts sets of triangles into a wanted number of parts of similar area. In this order: along creases; a sheet that
/// lies on both sides of itself (a wing) into its two sides; by a plane across one of the body's principal axes.
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
    /// What a part needs to stand alone: half a fair share.
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
