#include "studio/studio.hpp"

#include "casefile/load_case.hpp"
#include "cli/commands.hpp"
#include "cli/say.hpp"
#include "cli/signals.hpp"
#include "cli/studio_session.hpp"
#include "core/error.hpp"
#include "report/run_folder.hpp"
#include "report/run_lock.hpp"

#include <fmt/core.h>
#include <spawn.h>
#include <unistd.h>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>

extern char** environ;

namespace strake::cli {
namespace {

struct StudioArguments {
    std::string target;
    int port = 0;
    bool no_browser = false, read_only = false, new_address = false;
};

bool is_set(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
}

/// The user's own browser, where there is a screen. That it does not start is no error: the address is printed.
void open_browser(const std::string& url) {
    if (!is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY")) return;
    const std::string program = "xdg-open";
    char* words[] = {const_cast<char*>(program.c_str()), const_cast<char*>(url.c_str()), nullptr};
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    for (const int stream : {0, 1, 2})
        posix_spawn_file_actions_addopen(&files, stream, "/dev/null", stream == 0 ? 0 : 1, 0);
    posix_spawn_file_actions_addclosefrom_np(&files, 3);
    pid_t process = 0;
    ::posix_spawnp(&process, words[0], &files, nullptr, words, environ);
    posix_spawn_file_actions_destroy(&files);
}

/// Prints the address, and opens it where there is a screen.
void announce(const Studio& at_work, bool no_browser) {
    fmt::print("{}\n", at_work.url());
    if (std::fflush(stdout) != 0) throw std::system_error(errno, std::generic_category(), "standard output");
    if (const std::string notice = at_work.notice(); !notice.empty()) say("strake: studio: {}\n", notice);
    if (is_set("SSH_CONNECTION"))
        say("strake: studio: on your own machine: ssh -L {0}:127.0.0.1:{0} {1}, then open the address above there\n",
            at_work.port(), host_name());
    else if (!no_browser)
        open_browser(at_work.url());
}

void studio(const StudioArguments& args) {
    watch_signals();
    StudioOptions options;
    options.target = args.target;
    options.port = args.port;
    options.read_only = args.read_only;
    options.new_address = args.new_address;
    Studio at_work(options);
    announce(at_work, args.no_browser);
    while (!stop_wanted()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (const std::string words = at_work.continuing(); !words.empty()) say("strake: studio: {}\n", words);
    if (!at_work.leave()) return;
    std::fflush(nullptr);
    std::_Exit(0);  // reading leaves nothing behind, and a large file takes half a minute
}

}  // namespace

void run_in_studio(const SessionArguments& args) {
    watch_signals();
    StudioOptions options;
    options.target = args.case_file;
    Case the_case = load_case(args.case_file, Purpose::run, args.settings);  // its errors are told here, without a page
    set_output_folder(the_case, args.out);
    check_run_folder(the_case.output.dir);
    Studio at_work(options);
    at_work.run(args.case_file, the_case.output.dir, args.settings);
    announce(at_work, false);
    const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(100)); };
    std::optional<int> status;
    while (!stop_wanted() && !(status = at_work.run_status())) pause();
    const bool is_stopped = !status;
    if (is_stopped) at_work.interrupt_run();
    while (!status) {
        pause();
        status = at_work.run_status();
    }
    if (const std::string words = at_work.run_messages(); !words.empty()) say("{}", words);
    if (!is_stopped) {
        say("strake: studio: the run has ended; the page stays until Ctrl-C\n");
        while (!stop_wanted()) pause();
    }
    if (*status != 0) throw ExitStatus{*status};
}

void add_studio(CLI::App& app) {
    auto args = std::make_shared<StudioArguments>();
    CLI::App* command = app.add_subcommand(
        "studio", "choose regions, write a case, run it and watch it, in the browser; prints the address of the page");
    command->add_option("TARGET", args->target,
                        "surface, case, run folder, or a folder with these (default: the present folder)");
    command->add_option("--port", args->port, "port of the loopback address (default: any free one)")
        ->check(CLI::Range(1, 65535));
    command->add_flag("--no-browser", args->no_browser, "print the address only");
    command->add_flag("--new-address", args->new_address, "another address than the last studio of this folder had");
    command->add_flag("--read-only", args->read_only, "write, start and stop nothing");
    command->callback([args] { studio(*args); });
}

}  // namespace strake::cli
