#include "report/run_lock.hpp"

#include "core/error.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>

namespace strake {
namespace {

/// Belongs to the open file description, not to the process: closing another descriptor of the file keeps it.
struct flock whole_file() {
    struct flock whole {};
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    return whole;
}

LockHolder written_in(int fd) {
    char bytes[300];
    const ssize_t n = ::pread(fd, bytes, sizeof bytes, 0);
    const std::string all(bytes, n > 0 ? static_cast<std::size_t>(n) : 0);
    const std::size_t blank = all.find(' '), end = all.find('\n');
    if (blank == std::string::npos || end == std::string::npos || blank > end) return {};
    return {all.substr(0, blank), all.substr(blank + 1, end - blank - 1)};
}

[[noreturn]] void refuse(const std::filesystem::path& file, int error) {
    throw OutputError(text(file.string(), ": cannot write: ", std::strerror(error)));
}

}  // namespace

std::string host_name() {
    char name[256] = "";
    ::gethostname(name, sizeof name - 1);
    return name;
}

std::string LockHolder::words() const {
    return process.empty() ? "another process" : text("process ", process, " on ", host);
}

RunLock::RunLock(const std::filesystem::path& folder) : file_(folder / "lock") {
    for (;;) {
        fd_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (fd_ < 0) refuse(file_, errno);
        struct flock whole = whole_file();
        if (::fcntl(fd_, F_OFD_SETLK, &whole) != 0) {
            const int error = errno;
            const LockHolder holder = written_in(fd_);
            ::close(fd_);
            if (error != EAGAIN && error != EACCES) refuse(file_, error);
            throw OutputError(text(folder.string(), ": a run is in progress in this folder (", holder.words(),
                                   "); wait until it ends, or stop it"));
        }
        struct stat info {};
        if (::fstat(fd_, &info) == 0 && info.st_nlink > 0) break;
        ::close(fd_);  // the previous holder has just removed it
    }
    const std::string words = text(std::to_string(::getpid()), " ", host_name(), "\n");
    if (::ftruncate(fd_, 0) != 0 ||
        ::pwrite(fd_, words.data(), words.size(), 0) != static_cast<ssize_t>(words.size())) {
        const int error = errno;
        ::close(fd_);
        refuse(file_, error);
    }
}

RunLock::~RunLock() {
    ::unlink(file_.c_str());
    ::close(fd_);
}

std::optional<LockHolder> lock_holder(const std::filesystem::path& folder) {
    const int fd = ::open((folder / "lock").c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (fd < 0) return {};
    struct flock whole = whole_file();
    std::optional<LockHolder> holder;
    if (::fcntl(fd, F_OFD_GETLK, &whole) == 0 && whole.l_type != F_UNLCK) holder = written_in(fd);
    ::close(fd);
    return holder;
}

}  // namespace strake
