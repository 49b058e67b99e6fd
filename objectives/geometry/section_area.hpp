#pragma once
#include "core/primo/shell.hpp"
#include "objectives/quantity/quantity.hpp"

/// Area of a plane section of the body.
namespace strake {

struct Section {
    Eigen::Vector3d normal;        ///< any nonzero length
    double offset = 0;             ///< the plane is (normal / |normal|) . x = offset, length
    std::optional<double> target;  ///< for fits, > 0, length squared
};

/// Area enclosed by the cut of the surface with the plane, A = 1/2 n . sum (p - o) x (q - o) over the cut triangles'
/// segments pq; loops of the opposite sense (holes) count negative; the area is positive at the start. A cut point
/// p = a + t (b - a) of an edge moves by dp/da = (1 - t) P, dp/db = t P, P = I - e n^T / (n . e), e = b - a. Vertices
/// in the plane count as above it; a triangle in the plane makes the area jump.
/// With `symmetry` (open edges on that plane): the area of the half, closed by the plane.
/// Residual (with `target`): (A - target) / L, L the length of the outline at the start: the mean shift of the outline.
/// `evaluate` fails with kind `undefined` when the plane misses the surface or cuts an open edge.
/// @throws InvalidInput for the same at the start, naming the edge; zero area; a zero normal; numbers that are not
/// finite.
Quantity section_area(const std::string& name, const TriMesh& start, const Section& section,
                      const std::optional<SymmetryPlane>& symmetry = {});

}  // namespace strake
