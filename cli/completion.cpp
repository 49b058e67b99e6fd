#include "casefile/schema/explain.hpp"
#include "casefile/schema/quantity_types.hpp"
#include "casefile/schema/schema.hpp"
#include "cli/command_table.hpp"
#include "cli/commands.hpp"
#include "core/error.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <memory>

/// `strake completion SHELL`: a script for shell completion of commands, options, their values and files.
namespace strake::cli {
namespace {

std::string joined(const std::vector<std::string>& words, const char* separator) {
    return fmt::format("{}", fmt::join(words, separator));
}

/// Values of the first positional argument unless it is a file.
std::vector<std::string> positional_words(const CommandRow& command) {
    if (command.name == "explain") {
        std::vector<std::string> keys;
        for (const std::string& path : key_paths())
            if (path.find_first_of("*[") == std::string::npos) keys.push_back(path);
        for (const std::string& type : quantity_type_words())
            if (std::find(keys.begin(), keys.end(), type) == keys.end()) keys.push_back(type);
        return keys;
    }
    for (const OptionRow& option : command.options)
        if (option.is_positional && !option.words.empty()) return option.words;
    return {};
}

/// Values of an option: of --set the keys without names of the user's own.
std::vector<std::string> option_words(const OptionRow& option) {
    if (option.names.front() != "--set") return option.words;
    std::vector<std::string> keys;
    for (const std::string& path : key_paths())
        if (path.find_first_of("*[") == std::string::npos && !schema_index().children.contains(path))
            keys.push_back(path + "=");
    return keys;
}

std::vector<std::string> option_names(const CommandRow& command, bool only_with_value = false) {
    std::vector<std::string> names;
    for (const OptionRow& option : command.options)
        if (!option.is_positional && (option.takes_value || !only_with_value))
            names.insert(names.end(), option.names.begin(), option.names.end());
    return names;
}

std::string bash_script(const std::vector<CommandRow>& table) {
    std::vector<std::string> commands;
    for (const CommandRow& command : table) commands.push_back(command.name);
    std::string out = fmt::format(R"(# bash completion for strake; made by `strake completion bash`
_strake() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}}
    COMPREPLY=()
    if [ "$COMP_CWORD" = 1 ]; then
        COMPREPLY=($(compgen -W "{} --help --version" -- "$word"))
        return
    fi
    case ${{COMP_WORDS[1]}} in
)",
                                  joined(commands, " "));
    for (const CommandRow& command : table) {
        out += fmt::format("    {})\n        case $before in\n", command.name);
        for (const OptionRow& option : command.options)
            if (const auto words = option_words(option); !option.is_positional && !words.empty())
                out += fmt::format("        {}) COMPREPLY=($(compgen -W \"{}\" -- \"$word\")); {}return ;;\n",
                                   joined(option.names, "|"), joined(words, " "),
                                   option.words.empty() ? "compopt -o nospace 2>/dev/null; " : "");
        const std::vector<std::string> valued = option_names(command, true);
        if (!valued.empty())
            out += fmt::format("        {}) COMPREPLY=($(compgen -f -- \"$word\")); return ;;\n", joined(valued, "|"));
        out += fmt::format(
            "        esac\n        case $word in\n        -*) COMPREPLY=($(compgen -W \"{}\" -- \"$word\")); return "
            ";;\n"
            "        esac\n",
            joined(option_names(command), " "));
        const std::vector<std::string> words = positional_words(command);
        if (!words.empty())
            out += fmt::format("        COMPREPLY=($(compgen -W \"{}\" -- \"$word\")); return\n", joined(words, " "));
        out += "        ;;\n";
    }
    return out +
           "    esac\n    COMPREPLY=($(compgen -f -- \"$word\"))\n}\n"
           "complete -o filenames -o bashdefault -F _strake strake\n";
}

/// Text within '...[...]' of zsh's _arguments.
std::string zsh_text(const std::string& words) {
    std::string out;
    for (const char c : words) {
        if (c == '\'')
            out += "'\\''";
        else if (c == '[' || c == ']' || c == ':' || c == '\\')
            out += std::string("\\") + c;
        else
            out += c;
    }
    return out;
}

std::string zsh_script(const std::vector<CommandRow>& table) {
    std::string out =
        "#compdef strake\n# zsh completion for strake; made by `strake completion zsh`\n_strake() {\n"
        "    local -a commands=(\n";
    for (const CommandRow& command : table)
        out += fmt::format("        '{}:{}'\n", command.name, zsh_text(command.doc));
    out +=
        "    )\n    if (( CURRENT == 2 )); then\n        _describe command commands\n        return\n    fi\n"
        "    local command=$words[2]\n    shift words\n    (( CURRENT-- ))\n    case $command in\n";
    for (const CommandRow& command : table) {
        out += fmt::format("    {}) _arguments", command.name);
        for (const OptionRow& option : command.options) {
            if (option.is_positional) continue;
            const std::vector<std::string> words = option_words(option);
            const std::string value = !option.takes_value ? ""
                                      : words.empty()     ? ":value:_files"
                                                          : ":value:(" + joined(words, " ") + ")";
            for (const std::string& name : option.names)
                out += fmt::format(" \\\n        '{}[{}]{}'", name, zsh_text(option.doc), value);
        }
        const std::vector<std::string> words = positional_words(command);
        out += words.empty() ? " \\\n        '*:file:_files' ;;\n"
                             : fmt::format(" \\\n        '1:value:({})' ;;\n", joined(words, " "));
    }
    return out + "    esac\n}\n_strake \"$@\"\n";
}

std::string fish_text(const std::string& words) {
    std::string out;
    for (const char c : words) out += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return out;
}

std::string fish_script(const std::vector<CommandRow>& table) {
    std::string out = "# fish completion for strake; made by `strake completion fish`\n";
    for (const CommandRow& command : table)
        out += fmt::format("complete -c strake -n __fish_use_subcommand -f -a {} -d '{}'\n", command.name,
                           fish_text(command.doc));
    for (const CommandRow& command : table) {
        const std::string head = fmt::format("complete -c strake -n '__fish_seen_subcommand_from {}'", command.name);
        for (const OptionRow& option : command.options) {
            if (option.is_positional) continue;
            out += head;
            for (const std::string& name : option.names)
                out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
            if (const auto words = option_words(option); !words.empty())
                out += fmt::format(" -x -a '{}'", joined(words, " "));
            else if (option.takes_value)
                out += " -r";
            out += fmt::format(" -d '{}'\n", fish_text(option.doc));
        }
        const std::vector<std::string> words = positional_words(command);
        if (!words.empty()) out += fmt::format("{} -f -a '{}'\n", head, joined(words, " "));
    }
    return out;
}

}  // namespace

std::string completion_script(const CLI::App& app, const std::string& shell) {
    const std::vector<CommandRow> table = command_table(app);
    if (shell == "bash") return bash_script(table);
    if (shell == "zsh") return zsh_script(table);
    if (shell == "fish") return fish_script(table);
    throw InvalidInput(text("completion ", shell, ": must be bash, zsh or fish"));
}

void add_completion(CLI::App& app) {
    auto shell = std::make_shared<std::string>();
    CLI::App* command = app.add_subcommand("completion", "print a shell script that completes commands and options");
    command->add_option("SHELL", *shell, "for example: source <(strake completion bash)")
        ->required()
        ->type_name("bash|zsh|fish");
    command->callback([shell, &app] { fmt::print("{}", completion_script(app, *shell)); });
}

}  // namespace strake::cli
