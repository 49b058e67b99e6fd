#pragma once
#include "core/formats/io.hpp"

#include <exception>
#include <filesystem>
#include <string>
#include <vector>

namespace strake::cli {

/// An output must not overwrite an input or another output. Empty outputs do not count.
/// @throws InvalidInput naming the two.
void check_outputs(const std::vector<std::filesystem::path>& outputs, const std::vector<std::filesystem::path>& inputs);

/// Writes a surface in the format that the name asks for, as text where `like` is the text form of the same. Notes on
/// standard error when names of parts are lost. @throws OutputError.
void write_output(const std::filesystem::path& out, const TriMesh& surface, SurfaceFormat like);

/// True if standard output could not be written.
bool is_lost_output(const std::exception_ptr& thrown);
/// Flushes standard output. Empty, or the message when some of it could not be written.
std::string lost_output();

}  // namespace strake::cli
