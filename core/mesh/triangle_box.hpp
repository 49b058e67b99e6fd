#pragma once
#include "core/mesh/geometry.hpp"

namespace strake {

/// Of the corners of some triangles; zero box without any.
Box triangle_box(const TriMesh& mesh, const std::vector<int>& triangles);

}  // namespace strake
