#pragma once
#include <functional>
#include <string>
#include <vector>

/// The text of a region that is made of others: `wing + body - (nose & "upper side")`.
namespace strake {

/// A set of triangles, one mark per triangle.
using TriangleMarks = std::vector<char>;

/// Evaluates the text: `+` both, `-` without, `&` what both hold; `&` binds closer, equal signs go from left to right.
/// A name ends at a blank or a parenthesis; one in double quotes may hold both. Signs stand between blanks, because
/// names may hold them.
/// @param named what a name stands for; may throw.
/// @throws InvalidInput: a name or a sign is missing, a parenthesis or quote is not closed, more than 100 parentheses
/// within each other.
TriangleMarks evaluate_formula(const std::string& formula,
                               const std::function<TriangleMarks(const std::string&)>& named);

/// The names in it, in order. @throws InvalidInput as above.
std::vector<std::string> names_in_formula(const std::string& formula);

}  // namespace strake
