#pragma once
#include <string>

namespace strake {

/// "0.2.0", with the commit behind it where the source came from git: "0.2.0+g2d8fda0", "0.2.0+12.g2d8fda0.dirty".
std::string version();

}  // namespace strake
