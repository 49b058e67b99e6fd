#pragma once
#include "cases/build_problem.hpp"
#include "cli/commands.hpp"

#include <exception>
#include <filesystem>
#include <string>

/// What every command says with -v (what it does, when, and what that cost) and with --debug (more about an error). All
/// of it on standard error, a line each. One program has one command line: this is kept once for it.
namespace strake::cli {

/// Adds --threads to the commands that solve.
void add_threads_option(CLI::App& app);
/// Adds -v and --debug to every command that the program has by now.
void add_detail_options(CLI::App& app);

bool wants_detail();  ///< -v was given
/// What the program is about to do, or has found: printed with -v, and remembered for --debug.
void tell_step(const std::string& words);
/// With -v: seconds, time of processors, memory and status.
void tell_end(int status);

/// With --debug: type of the error and of those inside it, the last step, program, machine and command line. Empty
/// without.
std::string debug_words(const std::exception_ptr& thrown);

/// `read_surface` and `check_coordinates`, told as a step.
SurfaceFile read_told(const std::filesystem::path& file);
/// What asks for areas needs some. @throws InputError.
void check_area(const std::filesystem::path& file, const TriMesh& surface);

}  // namespace strake::cli
