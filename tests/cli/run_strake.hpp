#pragma once
#include "core/mesh/temp_folder.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace strake {

struct ProgramRun {
    int status = -1;  ///< exit status; 128 + signal when it did not exit
    std::string out, err;
};

/// Runs the program STRAKE_PROGRAM with these arguments, without a shell.
inline ProgramRun run_strake(const std::vector<std::string>& arguments) {
    const TempFolder folder;
    const std::string out = (folder / "out").string(), err = (folder / "err").string();
    std::vector<char*> argv{const_cast<char*>(STRAKE_PROGRAM)};
    for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    const pid_t child = fork();
    if (child == 0) {
        dup2(open(out.c_str(), O_WRONLY | O_CREAT, 0600), 1);
        dup2(open(err.c_str(), O_WRONLY | O_CREAT, 0600), 2);
        execv(argv[0], argv.data());
        _exit(126);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), bytes_of(out), bytes_of(err)};
}

}  // namespace strake
