#include "core/text/file.hpp"

#include "core/error.hpp"
#include "core/text/utf8.hpp"
#include "core/text/windows_path.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace strake {
namespace {

struct Descriptor {
    int fd;
    ~Descriptor() {
        if (fd >= 0) ::close(fd);
    }
};

std::string kind_of(mode_t mode) {
    if (S_ISDIR(mode)) return "a directory";
    if (S_ISFIFO(mode)) return "a pipe";
    if (S_ISSOCK(mode)) return "a socket";
    return "a device";
}

[[noreturn]] void cannot_write(const std::filesystem::path& file, int error) {
    throw OutputError(text(printable(file.native()), ": cannot write: ", std::strerror(error)));
}

/// Target of a write: follows symbolic links, to keep the link.
std::filesystem::path write_target(const std::filesystem::path& file) {
    struct stat st;
    if (::stat(file.c_str(), &st) == 0) {
        if (!S_ISREG(st.st_mode))
            throw OutputError(text(printable(file.native()), ": cannot write: is ", kind_of(st.st_mode)));
    } else if (errno != ENOENT) {
        cannot_write(file, errno);
    }
    std::error_code error;
    if (!std::filesystem::is_symlink(file, error)) return file;
    auto target = std::filesystem::weakly_canonical(file, error);
    if (error) cannot_write(file, error.value());
    return target;
}

void write_all(int fd, const std::string& bytes, int& error) {
    for (std::size_t done = 0; done < bytes.size() && !error;) {
        const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
        if (n >= 0)
            done += static_cast<std::size_t>(n);
        else if (errno != EINTR)
            error = errno;
    }
}

}  // namespace

std::string printable(std::string_view bytes, std::size_t limit) {
    std::string out;
    for (std::size_t i = 0; i < bytes.size();) {
        if (i >= limit) return out + "...";
        if (const auto [length, code] = utf8_at(bytes, i); length > 0 && !is_control(code)) {
            out += bytes.substr(i, length);
            i += length;
        } else {
            char escaped[5];
            std::snprintf(escaped, sizeof escaped, "\\x%02X", static_cast<unsigned char>(bytes[i++]));
            out += escaped;
        }
    }
    return out;
}

std::string read_bytes(const std::filesystem::path& file) {
    const std::string name = printable(file.native());
    // O_NONBLOCK: opening a pipe that nobody writes to must not wait.
    const Descriptor d{::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)};
    struct stat st;
    if (d.fd < 0 || ::fstat(d.fd, &st) != 0) {
        const int cause = errno;
        throw InputError(text(name, ": cannot read: ", std::strerror(cause),
                              cause == ENOENT ? windows_path_hint(file.native()) : ""));
    }
    if (!S_ISREG(st.st_mode))
        throw InputError(text(name, ": cannot read: is ", kind_of(st.st_mode), ", not a regular file"));
    try {
        std::string bytes(static_cast<std::size_t>(st.st_size), '\0');
        std::size_t done = 0;
        while (done < bytes.size()) {
            const ssize_t n = ::read(d.fd, bytes.data() + done, bytes.size() - done);
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) throw InputError(text(name, ": cannot read: ", std::strerror(errno)));
            if (n == 0) break;
            done += static_cast<std::size_t>(n);
        }
        bytes.resize(done);
        return bytes;
    } catch (const std::bad_alloc&) {
        throw InputError(text(name, ": ", st.st_size, " bytes do not fit into memory"));
    }
}

void write_atomically(const std::filesystem::path& file, const std::string& bytes) {
    static std::atomic<unsigned> serial{0};
    const std::filesystem::path target = write_target(file);
    const auto folder = target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
    // A short separate name: the target's may already have the maximum length.
    const auto temporary = folder / text(".strake-", ::getpid(), "-", serial++, ".tmp");
    int error = 0;
    const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0) cannot_write(file, errno);
    write_all(fd, bytes, error);
    if (!error && ::fsync(fd) != 0) error = errno;
    if (::close(fd) != 0 && !error) error = errno;
    if (!error && ::rename(temporary.c_str(), target.c_str()) != 0) error = errno;
    if (error) {
        ::unlink(temporary.c_str());
        cannot_write(file, error);
    }
    const Descriptor d{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    if (d.fd >= 0) ::fsync(d.fd);
}

}  // namespace strake
