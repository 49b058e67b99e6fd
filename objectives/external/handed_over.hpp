#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

/// Files written by a program: never trusted.
namespace strake {

/// Bytes of the file `name` in `folder`. Neither blocks nor follows links out of the folder.
/// @throws Refused: no_result when missing; unreadable when the name is absolute or leads out of the folder, or the
/// file is not regular, not owned by us, longer than `limit` bytes, or not text unless `may_be_binary`.
std::string read_handed_over(const std::filesystem::path& folder, const std::string& name, std::size_t limit,
                             bool may_be_binary = false);
void require_text(const std::string& bytes, const std::string& name);  ///< @throws Refused (UTF-16, NUL)

/// A finite number, independent of locale; allows surrounding blanks, a leading '+' and Fortran's D exponent.
enum class NumberIs { finite, not_finite, not_a_number };
NumberIs parse_number(std::string_view text, double& value);

/// Whether `candidate` is within two edits (a third of its length) of `wanted`, for "did you mean".
bool similar(const std::string& wanted, const std::string& candidate);

}  // namespace strake
