#pragma once
#include <filesystem>
#include <string>

namespace strake::cli {

/// Where programs of a case are run outside of a run: the folder that was asked for, else one that goes away in the
/// end.
class WorkFolder {
public:
    /// @param wanted may be empty. @param command for the name of the other.
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
