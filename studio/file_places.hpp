#pragma once
#include <algorithm>
#include <filesystem>

namespace strake {

/// Whether a path, links followed, is a folder or lies below it.
inline bool lies_in(const std::filesystem::path& path, const std::filesystem::path& folder) {
    std::error_code no_path, no_folder;
    const auto real = std::filesystem::weakly_canonical(path, no_path);
    const auto around = std::filesystem::weakly_canonical(folder, no_folder);
    return !no_path && !no_folder &&
           std::mismatch(around.begin(), around.end(), real.begin(), real.end()).first == around.end();
}

}  // namespace strake
