#pragma once
#include <filesystem>
#include <vector>

namespace strake::cli {

/// What is written must not be what is read, nor be written twice. Empty outputs do not count.
/// @throws InvalidInput naming the two.
void check_outputs(const std::vector<std::filesystem::path>& outputs, const std::vector<std::filesystem::path>& inputs);

}  // namespace strake::cli
