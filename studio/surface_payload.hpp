#pragma once
#include "studio/subject.hpp"

namespace strake {

/// A surface for the page, in one piece: the length of a JSON text as four bytes, the text padded with blanks to a
/// multiple of four bytes, then the arrays that it lists under `arrays` ({name: {offset, count, type: f32 | u32 |
/// u16}}, offsets from the end of the text), all little-endian. Positions are relative to `center`.
/// @param the_case null: a bare surface.
std::string payload_of(const Subject& subject, const Case* the_case);

}  // namespace strake
