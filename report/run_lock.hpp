#pragma once
#include <filesystem>
#include <optional>
#include <string>

/// Keeps two runs from writing to one folder: its file `lock` is locked during a run and removed at the end. The system
/// releases the lock of a process that has ended in any way.
namespace strake {

class RunLock {
public:
    /// @throws OutputError: the folder is in use (naming process and machine), or is not writable.
    explicit RunLock(const std::filesystem::path& folder);
    ~RunLock();
    RunLock(const RunLock&) = delete;
    RunLock& operator=(const RunLock&) = delete;

private:
    std::filesystem::path file_;
    int fd_ = -1;
};

struct LockHolder {
    std::string process, host;  ///< as it wrote them; empty: unknown
    std::string words() const;  ///< "process 123 on node7"
};

/// The name of this machine.
std::string host_name();

/// Who is running there, if anybody.
std::optional<LockHolder> lock_holder(const std::filesystem::path& folder);

}  // namespace strake
