#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

/// Files that a program has left for us: never trusted.
namespace strake {

/// Bytes of the file `name` in `folder`. Neither blocks nor follows a link out of the folder.
/// @throws Refused: no_result when there is none; unreadable when the name is absolute or leads out of the folder,
/// when it is not a regular file of ours, longer than `limit` bytes, or not text unless it may be binary.
std::string read_handed_over(const std::filesystem::path& folder, const std::string& name, std::size_t limit,
                             bool may_be_binary = false);
void require_text(const std::string& bytes, const std::string& name);  ///< @throws Refused (UTF-16, NUL)

/// A finite number, independent of locale; blanks around it, a leading '+' and Fortran's D exponent are taken.
enum class NumberIs { finite, not_finite, not_a_number };
NumberIs parse_number(std::string_view text, double& value);

/// "; did you mean 'drag'?" when `candidate` is within two edits (a third of its length) of `wanted`, else "".
bool similar(const std::string& wanted, const std::string& candidate);

}  // namespace strake
