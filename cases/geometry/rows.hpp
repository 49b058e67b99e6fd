#pragma once
#include "core/mesh/mesh.hpp"

#include <array>
#include <functional>
#include <vector>

/// Triangulations from rows of points: every row holds as many points as its length asks for, and neighbouring
/// rows are stitched. That keeps triangles near equilateral where a structured grid would squeeze or stretch them.
namespace strake::example {

using Curve = std::function<Eigen::Vector3d(double)>;  ///< parameter in [0, 1]

/// Lengths along a curve: `length[k]` from the start to parameter k / (size - 1), by chords of `samples` pieces.
struct ArcTable {
    std::vector<double> length;
    double total() const { return length.back(); }
    double parameter(double wanted) const;  ///< at which that length is reached, linear between samples
};
/// @param weight local multiplier of the length (a wish for 1 / weight the edge length), by parameter; empty: 1
ArcTable arc_table(const Curve& curve, int samples, const std::function<double(double)>& weight = {});
/// The mean of two tables of the same size (the two sides of a thin body).
ArcTable mean_of(const ArcTable& a, const ArcTable& b);

/// Grows a surface; indices into `vertices` name points.
struct SurfaceBuilder {
    int mirror_axis;  ///< the surface is one half; its image in the plane where this coordinate is zero completes it
    std::vector<Eigen::Vector3d> vertices{};
    std::vector<std::array<int, 3>> triangles{};

    int add(const Eigen::Vector3d& point);
    /// Triangulates the strip between rows `a` and `b` (at least one point each, not both single) by the choice of
    /// diagonals with the best triangles. Both rows run in the same direction, and a x b (along, then across) is the
    /// outward normal; `flip` turns it. Rows may share points: triangles with two equal corners are left out, and
    /// none is made that lies in the mirror plane, where it would meet its own image.
    void stitch(const std::vector<int>& a, const std::vector<int>& b, bool flip);
    /// Adds the mirror image; points whose `mirror_axis` coordinate is exactly zero are shared.
    void mirror();
    TriMesh mesh() const;
};

/// Calls `build(edge_length)` until the number of triangles is within 2 % of the wanted one, or is nearest to it.
/// @throws InvalidInput when `triangles` is outside [least, 5 000 000].
TriMesh with_triangle_count(int triangles, int least, double first_edge_length,
                            const std::function<TriMesh(double)>& build);

}  // namespace strake::example
