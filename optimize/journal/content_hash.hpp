#pragma once
#include "core/mesh/mesh.hpp"

#include <string>
#include <string_view>

/// Hashes by which a run recognizes surfaces, programs and files.
namespace strake {

/// FNV-1a, 64 bits, in hexadecimal digits.
std::string content_hash(std::string_view bytes);
/// Of vertices and triangles.
std::string content_hash(const TriMesh& surface);

}  // namespace strake
