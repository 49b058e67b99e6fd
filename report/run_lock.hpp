#pragma once
#include <filesystem>
#include <optional>
#include <string>

/// Two runs never write to one folder: `lock` in it is locked while one does, and goes away at its end. The system
/// lifts the lock of a process that is gone, however it went.
namespace strake {

class RunLock {
public:
    /// @throws OutputError: the folder is in use (by which process of which machine), or nothing can be written there.
    explicit RunLock(const std::filesystem::path& folder);
    ~RunLock();
    RunLock(const RunLock&) = delete;
    RunLock& operator=(const RunLock&) = delete;

private:
    std::filesystem::path file_;
    int fd_ = -1;
};

struct LockHolder {
    std::string process, host;  ///< as it wrote them; empty: not known
    std::string words() const;  ///< "process 123 on node7"
};

/// Of this machine.
std::string host_name();

/// Who is running there; nothing where nobody is.
std::optional<LockHolder> lock_holder(const std::filesystem::path& folder);

}  // namespace strake
