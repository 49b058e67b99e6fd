#pragma once
#include <string>

namespace strake {

/// What a path in Windows' notation is under WSL, as a remark behind "does not exist": `C:\a\b` is /mnt/c/a/b,
/// `\\wsl$\Debian\home\b` is /home/b, `a\b` is a/b. Empty for every other path.
std::string windows_path_hint(const std::string& path);

}  // namespace strake
