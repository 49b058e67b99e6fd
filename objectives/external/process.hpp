#pragma once
#include "objectives/quantity.hpp"

#include <filesystem>

/// One run of a program: no shell, bounded in time and output, nothing left behind.
namespace strake {

struct ProcessCommand {
    std::vector<std::string> arguments;  ///< program first: an absolute path, or a name without '/' for PATH
    std::filesystem::path folder;        ///< working directory; stdout.log and stderr.log are made there
    double timeout_s = 3600;             ///< > 0; then TERM to the process group, grace_s, KILL
    double grace_s = 5;
    std::function<bool()> stop_wanted;  ///< asked while it runs; true: as after the timeout, kind `interrupted`
    std::string log_prefix = "";        ///< before "stdout.log" and "stderr.log"
    std::size_t log_bytes = std::size_t{10} << 20;  ///< of each log, from the start; the last 64 KiB are always kept
};

struct ProcessEnd {
    std::optional<Failure> failure;  ///< spawn, exit, signal, timeout, interrupted; nothing after status 0
    std::string last_lines;          ///< printable: of stderr.log, or of stdout.log when that is empty
};

/// Runs the program in a session and process group of its own: stdin is /dev/null, no descriptor beyond 0-2 is
/// inherited, signals are at their defaults, the environment is ours. When it ends, whatever is left of its process
/// group is killed. Returns within timeout + grace + 6 s even if a descendant left the group and holds the output.
/// @throws OutputError when a log cannot be written.
ProcessEnd run_process(const ProcessCommand& command);

/// Path of the file to execute. @throws Refused (kind spawn): missing, a directory, not executable, not on PATH.
std::filesystem::path find_program(const std::string& program);
/// Why the system refused to execute `program`, with what to do about it.
std::string spawn_reason(const std::filesystem::path& program, int error);

}  // namespace strake
