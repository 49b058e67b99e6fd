#include "cases/diagnostics.hpp"
#include "cli/commands.hpp"
#include "core/error.hpp"

#include <cstdio>
#include <exception>

/// The `strake` program: parses the command line, runs a subcommand, turns errors into exit statuses.
int main(int argc, char** argv) {
    using namespace strake;
    CLI::App app{"Strake: shape optimization of surface triangulations without CAD", "strake"};
    app.set_version_flag("--version", "strake 0.1.0");
    app.require_subcommand(1);
    cli::add_info(app);
    cli::add_patches(app);
    cli::add_deform(app);
    cli::add_check(app);
    cli::add_run(app);
    cli::add_fit(app);
    cli::add_schema(app);
    try {
        app.parse(argc, argv);
        return cli::done;
    } catch (const cli::ExitStatus& end) {
        return end.status;
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? cli::done : cli::usage;
    } catch (const CaseError& e) {
        std::fprintf(stderr, "%s\n", e.quoted().c_str());
        return cli::usage;
    } catch (const InputError& e) {
        std::fprintf(stderr, "strake: %s\n", e.what());
        return cli::surface_file;
    } catch (const OutputError& e) {
        std::fprintf(stderr, "strake: %s\n", e.what());
        return cli::output_failed;
    } catch (const std::invalid_argument& e) {
        std::fprintf(stderr, "strake: %s\n", e.what());
        return cli::usage;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "strake: %s\n", e.what());
        return cli::run_failed;
    }
}
