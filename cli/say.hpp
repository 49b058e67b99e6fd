#pragma once
#include <fmt/format.h>

#include <csignal>
#include <cstdio>

namespace strake::cli {

/// Prints to standard error. That nobody reads it any more (`2>&1 | head`), or that it cannot be written, ends nothing.
template <class... Args>
void say(fmt::format_string<Args...> words, Args&&... args) {
    std::fputs(fmt::format(words, std::forward<Args>(args)...).c_str(), stderr);
}

/// From now on a reader of our output that goes away (`2>&1 | head`) does not end the program: writes fail instead.
inline void outlive_readers() {
    struct sigaction before {};
    ::sigaction(SIGPIPE, nullptr, &before);
    if (before.sa_handler == SIG_DFL) ::signal(SIGPIPE, SIG_IGN);
}

}  // namespace strake::cli
