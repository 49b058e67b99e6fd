#pragma once
#include "core/planform/wing.hpp"

/// Finds what looks like a wing on a surface.
namespace strake {

struct FoundWing {
    WingDeclaration declaration;  ///< with its triangles, unless the whole surface is the wing
    bool has_body = false;        ///< the wing ends at a body
    double root = 0;              ///< coordinate along the span at which it ends there (positive side)
    std::string why;              ///< what speaks for it, for the user
};

struct WingSearch {
    std::optional<Eigen::Vector3d> downstream = {}, up = {};  ///< known axes; else those of the coordinates are tried
    std::optional<SymmetryPlane> symmetry = {};
};

/// The largest wing of the surface, or nothing. Along each coordinate, from both tips inward, sections are followed as
/// long as they stay thin (thickness below 30 % of the chord), rounded or sharp at the rear (unlike plates of constant
/// thickness), and change little from one to the next; where that ends a body begins. What was followed is a wing if
/// its aspect ratio is above 1, its mean thickness below 22 % and its camber at half span below 12 %.
std::optional<FoundWing> find_wing(const TriMesh& mesh, const WingSearch& search = {});

}  // namespace strake
