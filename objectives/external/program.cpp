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

/// 0 if `path` is an executable file, else the reason as errno (EISDIR for a directory).
int executable_error(const std::filesystem::path& path) {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) return errno;
    if (S_ISDIR(info.st_mode)) return EISDIR;
    if (!S_ISREG(info.st_mode)) return EACCES;
    return ::access(path.c_str(), X_OK) == 0 ? 0 : EACCES;
}

/// " (mode 644)", or "" without a file.
std::string mode_of(const std::filesystem::path& path) {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) return "";
    std::ostringstream words;
    words << " (mode " << std::oct << (info.st_mode & 07777) << ")";
    return words.str();
}

[[noreturn]] void refuse_program(const std::string& message) { throw Refused{{"spawn", message}}; }

}  // namespace

std::string spawn_reason(const std::filesystem::path& program, int error) {
    const std::string name = text("'", printable_line(program.string()), "'");
    switch (error) {
        case EISDIR:
            return text(name, " is a directory, not a program");
        case EACCES:
            return text(name, " may not be executed", mode_of(program),
                        "; chmod +x it, or name its interpreter first: [python3, ...]");
        case ENOEXEC:
            return text(name,
                        " is not a program for this machine; does its first line name an interpreter (#!/bin/sh)?");
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
        if (const int error = executable_error(program); error != 0) refuse_program(spawn_reason(program, error));
        return program;
    }
    const char* variable = std::getenv("PATH");
    std::string_view rest = variable != nullptr ? variable : "/usr/local/bin:/usr/bin:/bin";
    while (!rest.empty()) {
        const std::size_t colon = rest.find(':');
        // An empty entry would mean the working directory, a folder that we have just created.
        if (const std::string_view folder = rest.substr(0, colon); !folder.empty()) {
            const auto path = std::filesystem::absolute(std::filesystem::path(folder) / program);
            if (executable_error(path) == 0) return path;
        }
        rest = colon == std::string_view::npos ? std::string_view() : rest.substr(colon + 1);
    }
    refuse_program(text("program '", printable_line(program), "' is not on PATH (searched: ",
                        printable_line(variable != nullptr ? variable : "/usr/local/bin:/usr/bin:/bin"), "); write ./",
                        printable_line(program), " for one beside the case file"));
}

}  // namespace strake
