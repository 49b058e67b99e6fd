#include "cli/command_table.hpp"
#include "cli/commands.hpp"
#include "cli/detail.hpp"
#include "cli/errors.hpp"
#include "cli/outputs.hpp"
#include "cli/plugin_exit.hpp"
#include "core/parallel.hpp"
#include "core/version.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>

namespace {

/// Factors of hundreds of megabytes are allocated and freed all the time; letting the system clear their pages each
/// time took a fifth of a run.
void keep_large_blocks() {
#ifdef __GLIBC__
    mallopt(M_MMAP_MAX, 0);  // glibc refuses a threshold above 32 MB
    mallopt(M_TRIM_THRESHOLD, -1);
#endif
}

/// If one of the three standard streams is closed, the next file opened would take its number and receive our output.
void keep_standard_streams() {
    for (int descriptor = 0; descriptor <= 2; ++descriptor)
        if (::fcntl(descriptor, F_GETFD) < 0 && errno == EBADF && ::open("/dev/null", O_RDWR) < 0) return;
}

/// An empty name of a file, a folder or a key never means anything: it is a variable of a script that was not set.
void refuse_empty_values(CLI::App& app) {
    const CLI::Validator not_empty([](std::string& value) { return value.empty() ? "must not be empty" : ""; }, "");
    for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; }))
        for (CLI::Option* option : command->get_options([](CLI::Option*) { return true; })) option->check(not_empty);
}

/// Prints what ended the program and returns its exit status.
int report_end(const std::exception_ptr& thrown) {
    using namespace strake;
    if (cli::is_lost_output(thrown)) return cli::output_failed;  // lost_output() reports it
    const cli::ProgramEnd end = cli::end_of(thrown);
    if (!end.message.empty()) std::fprintf(stderr, "%s\n", end.message.c_str());
    const std::string more = cli::debug_words(thrown);
    if (!more.empty()) std::fprintf(stderr, "%s\n", more.c_str());
    return end.status;
}

}  // namespace

/// The `strake` program: parses the command line, runs a subcommand, turns errors into exit statuses.
int main(int argc, char** argv) {
    using namespace strake;
    keep_standard_streams();
    keep_large_blocks();
    cli::watch_for_exit();
    CLI::App app{"Strake: shape optimization of triangulated surfaces without CAD", "strake"};
    app.set_version_flag("--version", "strake " + version());
    cli::add_licenses(app);
    app.require_subcommand(1);
    cli::add_init(app);
    cli::add_info(app);
    cli::add_repair(app);
    cli::add_remesh(app);
    cli::add_patches(app);
    cli::add_deform(app);
    cli::add_check(app);
    cli::add_run(app);
    cli::add_fit(app);
    cli::add_sample(app);
    cli::add_schema(app);
    cli::add_gradient_check(app);
    cli::add_sweep(app);
    cli::add_resume(app);
    cli::add_step(app);
    cli::add_status(app);
    cli::add_history(app);
    cli::add_apply(app);
    cli::add_mix(app);
    cli::add_compare(app);
    cli::add_report(app);
    cli::add_studio(app);
    cli::add_explain(app);
    cli::add_completion(app);
    cli::add_man(app);
    cli::add_threads_option(app);
    cli::add_detail_options(app);
    refuse_empty_values(app);
    app.footer("\n" + cli::exit_help());
    int status = cli::done;
    try {
        (void)num_threads();  // a wrong STRAKE_NUM_THREADS is reported before the work starts
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() != 0) {
            std::fprintf(stderr, "%s\n", cli::usage_words(app, e, {argv + std::min(argc, 1), argv + argc}).c_str());
            return cli::usage;
        }
        app.exit(e);  // --help, --version
    } catch (...) {
        status = report_end(std::current_exception());
    }
    const std::string lost = cli::lost_output();
    if (!lost.empty()) {
        std::fprintf(stderr, "%s\n", lost.c_str());
        if (status != cli::interrupted) status = cli::output_failed;
    }
    cli::log_end(status);
    return status;
}
