#pragma once
#include "studio/subject.hpp"

namespace strake {

/// A surface for the page, in one piece: the length of a JSON text as four bytes, the text padded with blanks to a
/// multiple of four bytes, then the arrays that it lists under `arrays` ({name: {offset, count, type: f32 | u32 |
/// u16}}, offsets from the end of the text), all little-endian. Positions are relative to `center`.
/// @param the_case null: a bare surface. @param wing is set to the one that the page shows
std::string payload_of(const Subject& subject, const Case* the_case, std::optional<FoundWing>& wing);

/// Three numbers a vertex, relative to a point: single precision is spent on the shape, not on where it lies.
std::vector<float> relative_to(const Eigen::Vector3d& center, const Points& vertices);

}  // namespace strake
