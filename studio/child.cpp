#include "studio/child.hpp"

#include "core/error.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <cstring>

extern char** environ;

namespace strake {
namespace {

std::string tail_of(int file, off_t most) {
    struct stat facts {};
    if (::fstat(file, &facts) != 0) return {};
    const off_t from = std::max<off_t>(0, facts.st_size - most);
    std::string bytes(static_cast<std::size_t>(facts.st_size - from), '\0');
    const ssize_t n = ::pread(file, bytes.data(), bytes.size(), from);
    bytes.resize(n < 0 ? 0 : static_cast<std::size_t>(n));
    return bytes;
}

}  // namespace

std::filesystem::path own_program() {
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
    if (error) throw OutputError(text("studio: /proc/self/exe: ", error.message()));
    return program;
}

Child::Child(const std::filesystem::path& folder, const std::vector<std::string>& arguments) {
    const std::string program = own_program().string(), where = folder.string();
    std::vector<char*> words{const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    out_ = ::memfd_create("output", MFD_CLOEXEC);
    err_ = ::memfd_create("messages", MFD_CLOEXEC);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, out_, 1);
    posix_spawn_file_actions_adddup2(&files, err_, 2);
    posix_spawn_file_actions_addchdir_np(&files, where.c_str());
    posix_spawn_file_actions_addclosefrom_np(&files, 3);  // above all the server's sockets
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none, usual;
    sigemptyset(&none);
    sigemptyset(&usual);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) sigaddset(&usual, number);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    const int error = ::posix_spawn(&process_, program.c_str(), &files, &attributes, words.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    if (error == 0) return;
    ::close(out_);
    ::close(err_);
    throw OutputError(text("studio: ", program, " cannot be started: ", std::strerror(error)));
}

Child::~Child() {
    ended();
    ::close(out_);
    ::close(err_);
}

std::optional<int> Child::ended() {
    if (status_) return status_;
    int status = 0;
    const pid_t which = ::waitpid(process_, &status, WNOHANG);
    if (which == 0 || (which < 0 && errno == EINTR)) return {};
    if (which < 0)
        status_ = 1;
    else
        status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return status_;
}

void Child::interrupt() {
    if (!ended()) ::kill(process_, SIGINT);
}

std::string Child::output() const { return tail_of(out_, 4 << 20); }
std::string Child::messages() const { return tail_of(err_, 64 << 10); }

}  // namespace strake
