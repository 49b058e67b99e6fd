#include "cli/signals.hpp"

#include "cli/commands.hpp"
#include "objectives/external/kill_programs.hpp"

#include <unistd.h>
#include <array>
#include <atomic>
#include <csignal>
#include <cstring>

namespace strake::cli {
namespace {

std::atomic<int> noted{0};  // the only state a handler may touch
static_assert(std::atomic<int>::is_always_lock_free);

/// Set once, before the handler is installed.
const char* last_words = "";
std::array<char, 5000> how_to_continue{};
bool is_terminal = false;

void write_words(const char* words) {
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, words, std::strlen(words));
}

extern "C" void note(int number) {
    int none = 0;
    if (noted.compare_exchange_strong(none, number)) {
        if (is_terminal && how_to_continue[0] != '\0')
            write_words("\nstrake: ending in order; once more ends at once, and kills programs that run on\n");
        return;
    }
    kill_programs();  // they would outlive us, where they ignore TERM
    write_words(how_to_continue.data());
    ::_exit(128 + number);
}

extern "C" void end_now(int) {
    write_words(last_words);
    ::_exit(interrupted);
}

void handle(void (*handler)(int)) {
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction before {};
        ::sigaction(number, nullptr, &before);
        if (number == SIGHUP && before.sa_handler == SIG_IGN) continue;
        struct sigaction ours {};
        ours.sa_handler = handler;
        ours.sa_flags = SA_RESTART;
        sigemptyset(&ours.sa_mask);
        ::sigaction(number, &ours, nullptr);
    }
}

}  // namespace

void watch_signals(const std::string& when_ended_at_once) {
    is_terminal = ::isatty(STDERR_FILENO) == 1;
    std::strncpy(how_to_continue.data(), when_ended_at_once.c_str(), how_to_continue.size() - 2);
    if (!when_ended_at_once.empty()) std::strcat(how_to_continue.data(), "\n");
    handle(note);
}

void leave_signals() {
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction now {};
        ::sigaction(number, nullptr, &now);
        if (now.sa_handler == note) ::signal(number, SIG_DFL);
    }
}

void end_on_signals(const char* words) {
    last_words = words;
    handle(end_now);
}

bool stop_wanted() { return noted.load() != 0; }
int stop_signal() { return noted.load(); }

}  // namespace strake::cli
