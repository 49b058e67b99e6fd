#include "cli/command_table.hpp"
#include "cli/commands.hpp"

#include <fmt/format.h>

/// `strake man`: the man page, generated from the commands.
namespace strake::cli {
namespace {

/// Text that roff prints literally: no requests, no escapes, dashes that can be copied.
std::string roff(const std::string& words) {
    std::string out;
    for (const char c : words) {
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else
            out += c;
    }
    return out.empty() || (out[0] != '.' && out[0] != '\'') ? out : "\\&" + out;
}

std::string synopsis(const CommandRow& command) {
    std::string out = ".B strake " + roff(command.name) + "\n";
    for (const OptionRow& option : command.options)
        if (option.is_positional)
            out += fmt::format(".RI {} \"{}\" {}\n", option.required ? "\"\"" : "[", roff(option.names[0]),
                               option.required ? "\"\"" : "]");
    return out + ".RI [ options ]\n";
}

std::string option_text(const OptionRow& option) {
    std::string names;
    for (const std::string& name : option.names)
        names +=
            fmt::format("{}{}{}\\fR", names.empty() ? "" : ", ", option.is_positional ? "\\fI" : "\\fB", roff(name));
    if (!option.is_positional && option.takes_value)
        names += option.words.empty() ? " \\fIVALUE\\fR" : " " + roff(fmt::format("{}", fmt::join(option.words, "|")));
    return fmt::format(".TP\n{}\n{}{}\n", names, roff(option.doc),
                       option.required && !option.is_positional ? " (required)" : "");
}

}  // namespace

std::string man_page(const CLI::App& app) {
    std::string out = fmt::format(
        ".TH STRAKE 1 \"\" \"{}\" \"User Commands\"\n.SH NAME\nstrake \\- shape optimization of triangulated surfaces "
        "without CAD\n.SH SYNOPSIS\n.B strake\n.I command\n.RI [ options ]\n.SH DESCRIPTION\n"
        "\\fBstrake init\\fR proposes a case for a bare surface file; \\fBstrake check\\fR shows what it would do and "
        "cost; \\fBstrake run\\fR optimizes, coarse to fine; \\fBstrake status\\fR shows the progress and "
        "\\fBstrake resume\\fR continues the run. Data goes to standard output, messages to standard error.\n"
        ".SH COMMANDS\n",
        roff(app.version()));
    for (const CommandRow& command : command_table(app)) {
        out += fmt::format(".SS {}\n{}{}.PP\n{}.\n", roff(command.name), synopsis(command), "", roff(command.doc));
        for (const OptionRow& option : command.options) out += option_text(option);
    }
    out += ".SH EXIT STATUS\n";
    for (const ExitMeaning& exit : exit_meanings())
        out += fmt::format(".TP\n.B {}\n{}\n", exit.status, roff(exit.words));
    return out +
           ".SH FILES\n.TP\n.I case.yaml\nA case; \\fBstrake explain\\fR and \\fBstrake schema\\fR describe its keys.\n"
           ".TP\n.I journal.sqlite\nEvery evaluation of a run, in the run folder.\n.SH ENVIRONMENT\n.TP\n.B "
           "TERM=dumb\nPlain lines instead of the progress bar.\n";
}

void add_man(CLI::App& app) {
    CLI::App* command = app.add_subcommand("man", "print the manual page in roff, for example: strake man | man -l -");
    command->callback([&app] { fmt::print("{}", man_page(app)); });
}

}  // namespace strake::cli
