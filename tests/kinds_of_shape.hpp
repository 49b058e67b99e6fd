#pragma once
#include "core/fields/invariance.hpp"

/// Bodies that are extruded, revolved or cyclic, and how far another one is from that.
namespace strake {

/// An airfoil-like closed section in x and z, along y from 0 to 1 in `rows` rows of cells, with both ends.
TriMesh extruded_section(int around, int rows);
/// About the x axis, from -1 to 1, radius 0.5 (1 - 0.6 x^2) between flat ends.
TriMesh body_of_revolution(int around, int along);
/// A ring with `count` lobes about the x axis, made of one sector with `per_sector` cells and its copies.
TriMesh cyclic_body(int count, int per_sector);
/// The triangles beyond the plane along its normal; `number[new] = old` of the vertices.
TriMesh part_above(const TriMesh& mesh, const SymmetryPlane& plane, std::vector<int>& number);

/// A held part of the kind: the columns behind the nose, the first rings, or the same end of all sectors.
std::vector<int> held_end(const TriMesh& mesh, const ShapeKind& kind);

/// How far the surface is from the kind, a length, measured without the classes of `Invariance`. Extruded: vertices
/// with no other one before or behind them along the axis, and ends that are not flat. Revolved: vertices with no other
/// one at the same place along the axis and distance from it. Cyclic: images that miss the nearest vertex.
double off_kind(const TriMesh& mesh, const ShapeKind& kind);

}  // namespace strake
