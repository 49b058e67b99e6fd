#pragma once
#include "core/mesh/mesh.hpp"

/// The one door to CGAL's alpha wrap (Portaneri et al. 2022), which is GPL-3.0+: a build with -DSTRAKE_GPL=OFF
/// leaves it out. Internal to core/wrap.
namespace strake {

/// Whether this build has it.
bool has_alpha_wrap();

/// A closed, manifold surface without self-intersections that encloses the triangles, `offset` away from them; what is
/// narrower than about alpha is bridged. Its vertices are in no useful order, its triangles uneven.
/// @param max_seconds of CPU; empty result: it would have taken longer. @throws InvalidInput where this build has no
/// alpha wrap.
TriMesh alpha_wrap(const TriMesh& soup, double alpha, double offset, double max_seconds);

}  // namespace strake
