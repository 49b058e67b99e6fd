#pragma once
#include <string>
#include <string_view>

namespace strake::formats {

/// What an OBJ file holds that its reader skips, in words with their count: curves and surfaces of the format's
/// free-form part. Empty: nothing.
std::string skipped_in_obj(std::string_view bytes);

}  // namespace strake::formats
