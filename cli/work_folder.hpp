#pragma once
#include <filesystem>
#include <string>

namespace strake::cli {

/// Where the programs of a case work outside a run: the requested folder, otherwise a temporary one.
class WorkFolder {
public:
    /// @param wanted may be empty. @param command names the temporary folder.
    WorkFolder(const std::string& wanted, const std::string& command);
    ~WorkFolder();
    WorkFolder(const WorkFolder&) = delete;
    WorkFolder& operator=(const WorkFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }
    void keep() { is_temporary_ = false; }

private:
    std::filesystem::path path_;
    bool is_temporary_;
};

}  // namespace strake::cli
