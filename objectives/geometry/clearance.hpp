#pragma once
#include "objectives/quantity/quantity.hpp"

namespace strake {

enum class Side { keep_out, keep_in };

struct Clearance {
    std::string shown;              ///< name of the other surface in messages: its file
    Side side = Side::keep_out;     ///< which side of the other surface the vertices stay on
    double smoothing = 0;           ///< length, >= 0
    std::vector<char> region = {};  ///< per triangle; empty: all
};

/// Minimum signed distance of the surface's vertices to another surface, positive on the permitted side; length. With
/// smoothing s > 0: the lower bound - s log sum exp(- d_k / s), at most s log(number of vertices) below the minimum, on
/// which a constraint >= 0 is conservative. With s = 0: exact; the gradient jumps when another vertex becomes the
/// nearest. The distance d is exact; its derivative is the direction from the closest point and jumps where two points
/// are equally close. Only vertices are measured: between them a sharp corner may come closer by the height of an
/// edge's arc. Where the distance is negative, a log message names the vertex, its position and its depth. Cost: one
/// closest point for each vertex. @throws InvalidInput: another surface that is not closed or has no volume.
Quantity clearance(const std::string& name, const TriMesh& start, const TriMesh& other, const Clearance& what);

}  // namespace strake
