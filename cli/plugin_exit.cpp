#include "cli/plugin_exit.hpp"

#include "cli/commands.hpp"
#include "objectives/external/running_plugin.hpp"

#include <unistd.h>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace strake::cli {
namespace {

/// Plain memory: other objects may be destroyed already when the handler runs.
std::array<char, 5000> how_to_continue{};

extern "C" void at_exit() {
    const char* plugin = running_plugin();
    if (plugin == nullptr) return;
    std::fflush(stdout);
    std::fprintf(
        stderr,
        "strake: %s: the plug-in has ended the program with exit(); a plug-in must return an error instead%s%s\n",
        plugin, how_to_continue[0] != '\0' ? "; " : "", how_to_continue.data());
    ::_exit(external_failed);
}

}  // namespace

void watch_for_exit() { std::atexit(at_exit); }

void say_at_exit(const std::string& words) {
    std::strncpy(how_to_continue.data(), words.c_str(), how_to_continue.size() - 1);
}

}  // namespace strake::cli
