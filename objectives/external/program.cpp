#include "core/error.hpp"
#include "objectives/external/log.hpp"
#include "objectives/external/process.hpp"
#include "objectives/external/refused.hpp"

#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace strake {
namespace {

/// 0 when `path` is a file that may be executed, else the reason as errno (EISDIR for a directory).
int executable_error(const std::filesystem::path& path) {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) return errno;
    if (S_ISDIR(info.st_mode)) return EISDIR;
    if (!S_ISREG(info.st_mode)) return EACCES;
    return ::access(path.c_str(), X_OK) == 0 ? 0 : EACCES;
}

/// " (mode 644)", or "" where there is no file.
std::string mode_of(const std::filesystem::path& path) {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) return "";
    std::ostringstream words;
    words << " (mode " << std::oct << (info.st_mode & 07777) << ")";
    return words.str();
}

[[noreturn]] void refuse(const std::string& message) { throw Refused{{"spawn", message}}; }

}  // namespace

std::string spawn_reason(const std::filesystem::path& program, int error) {
    const std::string name = text("'", printable(program.string()), "'");
    switch (error) {
        case EISDIR:
            return text(name, " is a directory, not a program");
        case EACCES:
            return text(name, " may not be executed", mode_of(program),
                        "; chmod +x it, or name its interpreter first: [python3, ...]");
        case ENOEXEC:
            return text(name, " is no program of this machine; does its first line say #!/bin/sh or the like?");
        case E2BIG:
            return text(name, ": the argument list is too long");
        case ENOENT:
            if (executable_error(program) == 0)
                return text(name, ": the interpreter that its first line names does not exist",
                            " (a carriage return at the end of that line?)");
            return text("program ", name, " does not exist");
        default:
            return text(name, ": ", std::strerror(error));
    }
}

std::filesystem::path find_program(const std::string& program) {
    if (program.find('/') != std::string::npos) {
        if (const int error = executable_error(program); error != 0) refuse(spawn_reason(program, error));
        return program;
    }
    const char* variable = std::getenv("PATH");
    std::string_view rest = variable != nullptr ? variable : "/usr/local/bin:/usr/bin:/bin";
    while (!rest.empty()) {
        const std::size_t colon = rest.find(':');
        // An empty entry would mean the working directory, which is a folder that we have just made.
        if (const std::string_view folder = rest.substr(0, colon); !folder.empty()) {
            const auto path = std::filesystem::absolute(std::filesystem::path(folder) / program);
            if (executable_error(path) == 0) return path;
        }
        rest = colon == std::string_view::npos ? std::string_view() : rest.substr(colon + 1);
    }
    refuse(text("program '", printable(program), "' is not on PATH (searched: ",
                printable(variable != nullptr ? variable : "/usr/local/bin:/usr/bin:/bin"), "); write ./",
                printable(program), " for one beside the case file"));
}

}  // namespace strake
