#pragma once
#include "casefile/build/build_problem.hpp"
#include "cli/commands.hpp"

#include <exception>
#include <filesystem>
#include <string>

/// What every command prints with -v (its steps, their times and the cost) and with --debug (details of an error), all
/// on standard error, one line each. There is one command line per process, so this state is global.
namespace strake::cli {

/// Adds --threads to the commands that solve.
void add_threads_option(CLI::App& app);
/// Adds -v and --debug to every command added so far.
void add_detail_options(CLI::App& app);

bool wants_detail();  ///< -v was given
/// What the program is about to do, or has found: printed with -v, and kept for --debug.
void log_step(const std::string& words);
/// With -v: seconds, CPU time, memory and status.
void log_end(int status);

/// With --debug: types of the error and of its causes, the last step, program, machine and command line; otherwise
/// empty.
std::string debug_words(const std::exception_ptr& thrown);

/// `read_surface` and `check_coordinates`, logged as a step.
SurfaceFile read_logged(const std::filesystem::path& file);
/// @throws InputError if the total area is not positive.
void check_area(const std::filesystem::path& file, const TriMesh& surface);

}  // namespace strake::cli
