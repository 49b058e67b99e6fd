#include "objectives/external/process.hpp"

#include "core/error.hpp"
#include "objectives/external/kill_programs.hpp"
#include "objectives/external/log.hpp"
#include "objectives/external/refused.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <utility>

namespace strake {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double drain_s = 0.5;  // wait for late output after the program has ended
constexpr double kill_s = 5;     // wait for a program to disappear after KILL (a hung network disk)
constexpr int look_ms = 20;      // between two looks at a program whose end wakes nobody
constexpr int stop_ms = 200;     // between two questions whether the user stops; a thousand programs ask

Clock::time_point time_after(double seconds) {
    return Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::min(seconds, 1e9)));
}

/// A descriptor that is closed at the end. Numbers start at 10, beyond the targets 0…3 of dup2 in the child, even if
/// our own 0-2 are closed.
class Descriptor {
public:
    Descriptor() = default;
    explicit Descriptor(int fd) {
        if (fd < 0) return;
        fd_ = ::fcntl(fd, F_DUPFD_CLOEXEC, 10);
        const int error = errno;
        ::close(fd);
        errno = error;
    }
    Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    ~Descriptor() { close(); }
    void close() {
        if (fd_ >= 0) ::close(std::exchange(fd_, -1));
    }
    int get() const { return fd_; }

private:
    int fd_ = -1;
};

[[noreturn]] void refuse_spawn(const std::string& what) {
    throw Refused{{"spawn", text(what, ": ", std::strerror(errno))}};
}

struct Pipe {
    Descriptor read, write;
    Pipe() {
        int ends[2];
        if (::pipe2(ends, O_CLOEXEC) != 0) refuse_spawn("no pipe for the program");
        read = Descriptor(ends[0]);
        write = Descriptor(ends[1]);
        if (read.get() < 0 || write.get() < 0) refuse_spawn("no pipe for the program");
    }
};

/// What the child needs, laid out before vfork: after it only async-signal-safe calls are allowed.
struct Start {
    const char* path;
    const char* folder;
    char* const* arguments;
    int in, out, err, report;
    pid_t parent;
};

[[noreturn]] void fail_in_child() {
    const int error = errno;
    [[maybe_unused]] const ssize_t n = ::write(3, &error, sizeof error);
    ::_exit(127);
}

/// Never inlined: its variables must not take the place of those that the parent uses after vfork.
[[noreturn, gnu::noinline]] void run_child(const Start& start) {
    ::dup2(start.in, 0);
    ::dup2(start.out, 1);
    ::dup2(start.err, 2);
    ::dup3(start.report, 3, O_CLOEXEC);
    if (::close_range(4, ~0u, 0) != 0)
        for (int fd = 4; fd < 65536; ++fd) ::close(fd);
    struct sigaction fresh {};
    fresh.sa_handler = SIG_DFL;
    for (int number = 1; number < NSIG; ++number) ::sigaction(number, &fresh, nullptr);
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::setsid();
    // TERM, not KILL, so that a launcher (mpirun, a batch client) can end what it started.
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != start.parent) ::_exit(127);
    if (::chdir(start.folder) != 0) fail_in_child();
    ::execve(start.path, start.arguments, environ);
    fail_in_child();
}

/// By vfork: fork copies the page tables of a large process, and each page it then writes, at every start. The child
/// has our memory until it executes, so no handler of ours may run in it: signals wait until it has its own.
pid_t start_child(const Start& start) {
    sigset_t all, before;
    sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    const pid_t child = ::vfork();
    if (child == 0) run_child(start);
    const int error = errno;
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    errno = error;
    return child;
}

/// Process groups of the programs that run now, for a signal handler; 0: free.
constexpr std::size_t max_at_once = 1024;
std::array<std::atomic<pid_t>, max_at_once> groups{};
static_assert(std::atomic<pid_t>::is_always_lock_free);

/// Keeps a child in that list until it has been reaped. More than fit are run, too, but not ended by the handler.
class Listed {
public:
    explicit Listed(pid_t child) {
        for (std::atomic<pid_t>& place : groups) {
            pid_t none = 0;
            if (!place.compare_exchange_strong(none, child)) continue;
            place_ = &place;
            return;
        }
    }
    Listed(const Listed&) = delete;
    Listed& operator=(const Listed&) = delete;
    ~Listed() {
        if (place_) *place_ = 0;
    }

private:
    std::atomic<pid_t>* place_ = nullptr;
};

/// Starts the program. @throws Refused (kind spawn) with the system's reason.
pid_t spawn(const ProcessCommand& command, const Descriptor& out, const Descriptor& err) {
    const std::filesystem::path program = find_program(command.arguments.front());
    std::vector<char*> arguments;
    for (const std::string& argument : command.arguments) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    const Descriptor in(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    if (in.get() < 0) refuse_spawn("/dev/null");
    Pipe report;
    const Start start{program.c_str(), command.folder.c_str(), arguments.data(), in.get(), out.get(),
                      err.get(),       report.write.get(),     ::getpid()};
    const pid_t child = start_child(start);
    if (child < 0) refuse_spawn("no new process");
    report.write.close();
    int error = 0;
    ssize_t n;
    do n = ::read(report.read.get(), &error, sizeof error);
    while (n < 0 && errno == EINTR);
    if (n <= 0) return child;  // closed by a successful exec
    while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
    }
    throw Refused{{"spawn", spawn_reason(program, error)}};
}

/// Copies the two pipes of a running program into its logs.
class Outputs {
public:
    /// @param child whose end wakes `take`, where the system can tell (Linux 5.3)
    Outputs(pid_t child, Pipe& out, Pipe& err, CappedLog& out_log, CappedLog& err_log)
        : end_(static_cast<int>(::syscall(SYS_pidfd_open, child, 0))), logs_{&out_log, &err_log} {
        fds_[0] = {out.read.get(), POLLIN, 0};
        fds_[1] = {err.read.get(), POLLIN, 0};
        fds_[2] = {end_.get(), POLLIN, 0};
        for (const Pipe* pipe : {&out, &err}) ::fcntl(pipe->read.get(), F_SETFL, O_NONBLOCK);
    }
    bool open() const { return fds_[0].fd >= 0 || fds_[1].fd >= 0; }
    bool wakes_at_end() const { return fds_[2].fd >= 0; }
    void forget_end() { fds_[2].fd = -1; }
    /// Copies output that arrives within `milliseconds`; at most one buffer per pipe, against floods.
    void take(int milliseconds) {
        if (::poll(fds_.data(), fds_.size(), milliseconds) <= 0) return;
        for (std::size_t k = 0; k < logs_.size(); ++k) {
            if (fds_[k].fd < 0 || fds_[k].revents == 0) continue;
            const ssize_t n = ::read(fds_[k].fd, buffer_.data(), buffer_.size());
            if (n > 0)
                logs_[k]->append({buffer_.data(), static_cast<std::size_t>(n)});
            else if (n == 0 || (errno != EAGAIN && errno != EINTR))
                fds_[k].fd = -1;
        }
    }

private:
    Descriptor end_;
    std::array<pollfd, 3> fds_{};  // poll ignores negative ones
    std::array<CappedLog*, 2> logs_;
    std::array<char, 65536> buffer_{};
};

/// Whether the program has ended; it stays a zombie to keep its process group's number.
bool has_ended(pid_t child) {
    siginfo_t info{};
    const int status = ::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT);
    return (status == 0 && info.si_pid == child) || (status != 0 && errno == ECHILD);
}

/// Copies output until the program ends, until `until`, or until the user stops; true if it has ended.
bool wait_until(pid_t child, Outputs& outputs, Clock::time_point until, const std::function<bool()>& stop_wanted = {}) {
    int pause_ms = 1;
    while (!has_ended(child)) {
        const auto now = Clock::now();
        if (now >= until || (stop_wanted && stop_wanted())) return false;
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - now).count();
        outputs.take(static_cast<int>(std::min<decltype(left)>(left, pause_ms)));
        pause_ms = std::min(2 * pause_ms, outputs.wakes_at_end() ? stop_ms : look_ms);
    }
    outputs.forget_end();
    return true;
}

/// After the end: drains the output, kills the rest of the group, reaps the zombie.
int finish(pid_t child, Outputs& outputs) {
    const auto until = time_after(drain_s);
    while (outputs.open() && Clock::now() < until) outputs.take(10);
    ::kill(-child, SIGKILL);
    int status = -1;
    pid_t reaped;
    do reaped = ::waitpid(child, &status, 0);
    while (reaped < 0 && errno == EINTR);
    return reaped == child ? status : -1;
}

/// Ends the process group, after the timeout or at the user's stop.
Failure end_group(pid_t child, Outputs& outputs, const ProcessCommand& command) {
    const bool is_interrupt = command.stop_wanted && command.stop_wanted();
    const auto message = [&](const char* how) {
        if (is_interrupt) return Failure{"interrupted", text("the run was interrupted; ", how)};
        return Failure{"timeout", text("not finished after the timeout of ", command.timeout_s, " s; ", how)};
    };
    ::kill(-child, SIGTERM);
    ::kill(-child, SIGCONT);  // a stopped program would not see it
    bool ended = wait_until(child, outputs, time_after(command.grace_s));
    const Failure failure = message(ended ? "its process group was ended with SIGTERM"
                                          : "its process group ignored SIGTERM and was killed");
    if (!ended) {
        ::kill(-child, SIGKILL);
        ended = wait_until(child, outputs, time_after(kill_s));
    }
    if (!ended) return message("it survives SIGKILL (waiting for a disk or a network?)");
    finish(child, outputs);
    return failure;
}

std::optional<Failure> how_it_ended(int status) {
    if (WIFSIGNALED(status)) {
        const char* name = ::sigabbrev_np(WTERMSIG(status));
        const char* words = ::sigdescr_np(WTERMSIG(status));
        return Failure{"signal", text("ended by signal ", name != nullptr ? text("SIG", name) : "", " (",
                                      words != nullptr ? words : "unknown", ", ", WTERMSIG(status), ")")};
    }
    if (!WIFEXITED(status)) return Failure{"exit", "its exit status was lost (SIGCHLD is ignored by this program)"};
    if (WEXITSTATUS(status) == 0) return {};
    const char* hint = WEXITSTATUS(status) == 127   ? " (a shell reports this when it cannot find a program)"
                       : WEXITSTATUS(status) == 126 ? " (a shell reports this when it may not execute a program)"
                                                    : "";
    return Failure{"exit", text("exit status ", WEXITSTATUS(status), hint)};
}

}  // namespace

void kill_programs() {
    for (const std::atomic<pid_t>& group : groups)
        if (const pid_t child = group.load(); child > 0) ::kill(-child, SIGKILL);
}

ProcessEnd run_process(const ProcessCommand& command) {
    CappedLog out_log(command.folder / (command.log_prefix + "stdout.log"), command.log_bytes);
    CappedLog err_log(command.folder / (command.log_prefix + "stderr.log"), command.log_bytes);
    ProcessEnd end;
    try {
        Pipe out, err;
        const pid_t child = spawn(command, out.write, err.write);
        const Listed while_it_runs(child);
        out.write.close();
        err.write.close();
        Outputs outputs(child, out, err, out_log, err_log);
        if (wait_until(child, outputs, time_after(command.timeout_s), command.stop_wanted))
            end.failure = how_it_ended(finish(child, outputs));
        else
            end.failure = end_group(child, outputs, command);
    } catch (const Refused& refused) {
        end.failure = refused.failure;
    }
    for (CappedLog* log : {&out_log, &err_log}) try {
            log->close();
        } catch (const OutputError&) {  // of a full disk; what the program has answered counts all the same
            if (end.failure) throw;
        }
    constexpr int lines = 10;
    end.last_lines = err_log.last_lines(lines);
    if (end.last_lines.empty()) end.last_lines = out_log.last_lines(lines);
    return end;
}

}  // namespace strake
