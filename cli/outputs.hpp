#pragma once
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

namespace strake::cli {

/// What is written must not be what is read, nor be written twice. Empty outputs do not count.
/// @throws InvalidInput naming the two.
void check_outputs(const std::vector<std::filesystem::path>& outputs, const std::vector<std::filesystem::path>& inputs);

/// Was it standard output that could not be written?
bool is_lost_output(const std::exception_ptr& thrown);
/// Writes what standard output still holds back. Empty, or what to tell when some of it could not be written.
std::string lost_output();

}  // namespace strake::cli
