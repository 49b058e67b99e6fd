#pragma once
#include <CLI/CLI.hpp>

/// One file for each subcommand; each adds itself to the program. The callbacks throw the typed errors, which main
/// turns into a message on stderr and an exit status; a callback that ends with a status other than 0 throws
/// `ExitStatus`.
namespace strake::cli {

/// Exit statuses (`strake --help`).
enum Status : int {
    done = 0,
    run_failed = 1,
    usage = 2,
    surface_file = 3,
    output_failed = 4,
    external_failed = 5,
    interrupted = 75
};

struct ExitStatus {
    int status;
};

void add_init(CLI::App& app);
void add_info(CLI::App& app);
void add_remesh(CLI::App& app);
void add_repair(CLI::App& app);
void add_patches(CLI::App& app);
void add_deform(CLI::App& app);
void add_check(CLI::App& app);
void add_run(CLI::App& app);
void add_fit(CLI::App& app);
void add_sample(CLI::App& app);
void add_schema(CLI::App& app);
void add_gradient_check(CLI::App& app);
void add_sweep(CLI::App& app);
void add_resume(CLI::App& app);
void add_step(CLI::App& app);
void add_status(CLI::App& app);
void add_studio(CLI::App& app);
void add_history(CLI::App& app);
void add_apply(CLI::App& app);
void add_report(CLI::App& app);
void add_explain(CLI::App& app);
void add_completion(CLI::App& app);
void add_man(CLI::App& app);
void add_licenses(CLI::App& app);
void add_mix(CLI::App& app);
void add_compare(CLI::App& app);

}  // namespace strake::cli
