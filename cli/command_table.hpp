#pragma once
#include <CLI/CLI.hpp>

#include <string>
#include <vector>

/// The command line as data, read from the parser: the source of completions, the man page and the answers to mistyped
/// options.
namespace strake::cli {

struct OptionRow {
    std::vector<std::string> names;  ///< with dashes; for a positional, its name
    std::string doc;
    std::vector<std::string> words;  ///< allowed values, where the help lists them in the form a|b|c
    bool takes_value = false, is_positional = false, required = false;
};
struct CommandRow {
    std::string name, doc;
    std::vector<OptionRow> options;  ///< positionals first
};

std::vector<CommandRow> command_table(const CLI::App& app);

struct ExitMeaning {
    int status;
    const char* words;
};
/// In the order of their numbers; a contract with scripts.
const std::vector<ExitMeaning>& exit_meanings();
std::string exit_help();  ///< the same text, for the end of --help

/// A completion script for `shell`: bash, zsh or fish.
std::string completion_script(const CLI::App& app, const std::string& shell);
/// strake.1 in roff.
std::string man_page(const CLI::App& app);

/// The message about a command line that was not understood: one or two lines, with the nearest command or option.
std::string usage_words(const CLI::App& app, const CLI::ParseError& error, const std::vector<std::string>& arguments);

}  // namespace strake::cli
