#include "cli/command_table.hpp"

#include "cli/commands.hpp"

#include <fmt/format.h>

namespace strake::cli {
namespace {

/// The words of "planar|smooth", or of "TEXT:{random,start}" as the parser's own check writes it.
std::vector<std::string> words_in(std::string type) {
    char between = '|';
    if (const std::size_t open = type.find(":{"); open != std::string::npos && type.ends_with('}')) {
        type = type.substr(open + 2, type.size() - open - 3);
        between = ',';
    }
    std::vector<std::string> words;
    if (type.find(between) == std::string::npos) return words;
    std::size_t from = 0;
    for (std::size_t bar; (bar = type.find(between, from)) != std::string::npos; from = bar + 1)
        words.push_back(type.substr(from, bar - from));
    words.push_back(type.substr(from));
    return words;
}

OptionRow row_of(const CLI::Option& option) {
    OptionRow row;
    row.is_positional = option.nonpositional() == false;
    if (row.is_positional) {
        row.names = {option.get_name(true)};
    } else {
        for (const std::string& name : option.get_snames()) row.names.push_back("-" + name);
        for (const std::string& name : option.get_lnames()) row.names.push_back("--" + name);
    }
    row.doc = option.get_description();
    row.words = words_in(option.get_type_name());
    row.takes_value = option.get_items_expected_max() > 0 && option.get_type_size_max() > 0;
    row.required = option.get_required();
    return row;
}

}  // namespace

std::vector<CommandRow> command_table(const CLI::App& app) {
    std::vector<CommandRow> table;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        CommandRow row{command->get_name(), command->get_description(), {}};
        for (const bool positional : {true, false})
            for (const CLI::Option* option : command->get_options()) {
                OptionRow one = row_of(*option);
                if (one.is_positional == positional) row.options.push_back(std::move(one));
            }
        table.push_back(std::move(row));
    }
    return table;
}

const std::vector<ExitMeaning>& exit_meanings() {
    static const std::vector<ExitMeaning> table{
        {done, "done: converged, or stopped by a limit; the status word says which"},
        {run_failed, "the run failed, or its best design is infeasible"},
        {usage, "command line or case file"},
        {surface_file, "surface file"},
        {output_failed, "output: disk, permissions, or a folder in use"},
        {external_failed, "an external evaluation failed for good"},
        {interrupted, "interrupted, can be resumed (128 + n after a second signal)"}};
    return table;
}

std::string exit_help() {
    std::string out = "Exit statuses:\n";
    for (const ExitMeaning& exit : exit_meanings()) out += fmt::format("  {:<3} {}\n", exit.status, exit.words);
    return out;
}

}  // namespace strake::cli
