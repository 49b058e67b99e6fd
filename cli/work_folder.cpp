#include "cli/work_folder.hpp"

#include <unistd.h>

namespace strake::cli {

WorkFolder::WorkFolder(const std::string& wanted, const std::string& command)
    : path_(wanted), is_temporary_(wanted.empty()) {
    if (!is_temporary_) return;
    const std::string name = "strake-" + command + "-" + std::to_string(::getpid());
    path_ = std::filesystem::temp_directory_path() / name;
    // A process that was killed may have left its folder, and numbers of processes come again.
    for (int k = 2; std::filesystem::exists(path_); ++k)
        path_ = std::filesystem::temp_directory_path() / (name + "-" + std::to_string(k));
}

WorkFolder::~WorkFolder() {
    std::error_code ignored;
    if (is_temporary_) std::filesystem::remove_all(path_, ignored);
}

}  // namespace strake::cli
