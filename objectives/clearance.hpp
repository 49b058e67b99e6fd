#pragma once
#include "objectives/quantity.hpp"

namespace strake {

enum class Side { keep_out, keep_in };

struct Clearance {
    std::string shown;              ///< what the other surface is called in messages: its file
    Side side = Side::keep_out;     ///< the vertices stay outside of the other surface, or inside
    double smoothing = 0;           ///< length, >= 0
    std::vector<char> region = {};  ///< per triangle; empty: all
};

/// The least distance of the surface's vertices to another surface, positive on the side where they may be; length.
/// With smoothing s > 0 the bound - s log sum exp(- d_k / s) that lies below it by at most s log(number of vertices):
/// a constraint >= 0 on it errs on the safe side. With 0 exact; its gradient jumps where another vertex becomes the
/// nearest. d is exact, with derivative the direction from the closest place; that jumps where two places are equally
/// close. Only vertices are looked at: between them a sharp corner may come closer by what an edge spans.
/// Where the least distance is negative the remark names the vertex, its place and how deep it is.
/// Cost: one closest point for each vertex. @throws InvalidInput: another surface that is not closed or has no volume.
Quantity clearance(const std::string& name, const TriMesh& start, const TriMesh& other, const Clearance& what);

}  // namespace strake
