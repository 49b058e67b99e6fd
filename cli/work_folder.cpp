#include "cli/work_folder.hpp"

#include <unistd.h>

namespace strake::cli {

WorkFolder::WorkFolder(const std::string& wanted, const std::string& command)
    : path_(wanted), is_temporary_(wanted.empty()) {
    if (is_temporary_)
        path_ = std::filesystem::temp_directory_path() / ("strake-" + command + "-" + std::to_string(::getpid()));
}

WorkFolder::~WorkFolder() {
    std::error_code ignored;
    if (is_temporary_) std::filesystem::remove_all(path_, ignored);
}

}  // namespace strake::cli
