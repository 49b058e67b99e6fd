#pragma once
#include <sys/types.h>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// A command of Strake as a process of its own, in a session of its own: it outlives the studio and does not notice
/// the studio's terminal.
namespace strake {

class Child {
public:
    /// Runs this very program with these arguments in a folder. @throws OutputError: it cannot be started.
    Child(const std::filesystem::path& folder, const std::vector<std::string>& arguments);
    ~Child();  ///< a process that is still running goes on
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Status of the exit (128 + n after signal n); nothing: it is running.
    std::optional<int> ended();
    void interrupt();              ///< SIGINT, once: commands end in order
    std::string output() const;    ///< standard output, the last 4 MB
    std::string messages() const;  ///< standard error, the last 64 kB
    pid_t process() const { return process_; }

private:
    pid_t process_ = -1;
    int out_ = -1, err_ = -1;  ///< files in memory: written on when the studio has gone
    std::optional<int> status_;
};

/// The file of the running program.
std::filesystem::path own_program();

}  // namespace strake
