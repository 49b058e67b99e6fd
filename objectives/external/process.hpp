#pragma once
#include "objectives/quantity/quantity.hpp"

#include <filesystem>

/// Runs a program: without a shell, bounded in time and output, without leftovers.
namespace strake {

struct ProcessCommand {
    std::vector<std::string> arguments;  ///< program first: an absolute path, or a name without '/' for PATH
    std::filesystem::path folder;        ///< working directory, for stdout.log and stderr.log
    double timeout_s = 3600;             ///< > 0; then TERM to the process group, grace_s, KILL
    double grace_s = 5;
    std::function<bool()> stop_wanted;  ///< polled while it runs; true: ends it like the timeout, kind `interrupted`
    std::string log_prefix = "";        ///< before "stdout.log" and "stderr.log"
    std::size_t log_bytes = std::size_t{10} << 20;  ///< per log, from the start; the last 64 KiB are always kept
};

struct ProcessEnd {
    std::optional<Failure> failure;  ///< spawn, exit, signal, timeout, interrupted; nothing after status 0
    std::string last_lines;          ///< printable, of stderr.log, or of stdout.log if that is empty
};

/// Runs the program in a session and process group of its own: stdin is /dev/null, no descriptor beyond 0-2 is
/// inherited, signals are at their defaults, the environment is ours. When it ends, the rest of its process group is
/// killed. Returns within timeout + grace + 6 s even if a descendant has left the group and holds the output.
/// @throws OutputError when the log of a program that failed cannot be written.
ProcessEnd run_process(const ProcessCommand& command);

/// Path of the file to execute. @throws Refused (kind spawn): missing, a directory, not executable, not on PATH.
std::filesystem::path find_program(const std::string& program);
/// Why the system refused to execute `program`, with advice.
std::string spawn_reason(const std::filesystem::path& program, int error);

}  // namespace strake
