#pragma once
#include "core/mesh/io.hpp"

#include <exception>
#include <filesystem>
#include <string>
#include <vector>

namespace strake::cli {

/// What is written must not be what is read, nor be written twice. Empty outputs do not count.
/// @throws InvalidInput naming the two.
void check_outputs(const std::vector<std::filesystem::path>& outputs, const std::vector<std::filesystem::path>& inputs);

/// Writes a surface in the format that the name asks for, as text where `like` is the text form of the same. Tells on
/// standard error when names of parts are lost by it. @throws OutputError.
void write_output(const std::filesystem::path& out, const TriMesh& surface, SurfaceFormat like);

/// Was it standard output that could not be written?
bool is_lost_output(const std::exception_ptr& thrown);
/// Writes what standard output still holds back. Empty, or what to tell when some of it could not be written.
std::string lost_output();

}  // namespace strake::cli
